"""The program and the shipped case, beside which the package is held."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CASE = ROOT / "examples" / "press-63-40"
TRAIN = sorted(CASE.glob("train-*.csv"))
HOLDOUT = sorted(CASE.glob("holdout-*.csv"))


@pytest.fixture(scope="session")
def program() -> str:
    """The program: $HOST_SIM, or that of the PATH."""
    found = os.environ.get("HOST_SIM") or shutil.which("host-sim")
    assert found, "no host-sim; HOST_SIM names the program that the package is compared with"
    return found


@pytest.fixture
def run(program: str, tmp_path: Path):
    """Runs the program in an empty folder; gives what it prints, and refuses a failure unless one is expected."""

    def of(*arguments: object, fails: bool = False) -> str:
        command = [program, *map(str, arguments)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (done.returncode != 0) == fails, done.stderr
        return done.stderr if fails else done.stdout

    return of
