"""`host_sim.fleet` against the program's `fleet`: on this process and on a cluster, whatever happens to a worker."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import pandas as pd
import pytest
from conftest import CASE, HOLDOUT, ROOT, TRAIN

import host_sim

NIGHTS = 12


@pytest.fixture(scope="module")
def hall(program: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two drives of twelve nights, a third without machine file; in one night a recording that is none."""
    import subprocess

    folder = tmp_path_factory.mktemp("fleet")
    machine = folder / "w.toml"
    learn = [program, "watch", "--machine", CASE / "machine.toml", "--healthy", *TRAIN, "--save-machine", machine]
    subprocess.run([str(part) for part in learn], check=True, capture_output=True)
    for drive in ("a", "b", "lost"):
        for number in range(NIGHTS):
            night = folder / "hall" / f"drive={drive}" / f"date=2026-01-{number + 1:02}"
            night.mkdir(parents=True)
            shutil.copy(HOLDOUT[number % len(HOLDOUT)], night / "1.csv")
        if drive != "lost":
            shutil.copy(machine, folder / "hall" / f"drive={drive}" / "machine.toml")
    (folder / "hall" / "drive=a" / "date=2026-01-03" / "poisoned.parquet").write_bytes(b"PAR1 and nothing else")
    return folder / "hall"


@pytest.fixture(scope="module")
def expected(program: str, hall: Path) -> pd.DataFrame:
    """The rows that the program makes."""
    import subprocess

    out = hall.parent / "by-program"
    subprocess.run([program, "fleet", str(hall), "--upto", "refit", "--out", str(out)], check=True, capture_output=True)
    return rows(out)


def rows(table: Path | str) -> pd.DataFrame:
    """The rows of a table in their order, without the time that they took."""
    found = pd.concat(pd.read_parquet(part) for part in sorted(Path(table).glob("part-*.parquet")))
    found = found.drop(columns="seconds").sort_values(["drive", "night", "recording"], na_position="first")
    return found.reset_index(drop=True)


def test_rows_are_those_of_the_program_and_a_second_run_adds_none(hall: Path, expected: pd.DataFrame, tmp_path: Path) -> None:
    run = host_sim.fleet(hall, tmp_path / "table", upto="refit", threads=1)
    assert run.nights == 3 * NIGHTS and run.verdicts["unusable"] == NIGHTS
    pd.testing.assert_frame_equal(rows(run.table), expected)
    assert host_sim.fleet(hall, tmp_path / "table", upto="refit").nights == 0
    pd.testing.assert_frame_equal(rows(run.table), expected)


def test_wrong_arguments_and_a_table_that_another_run_writes_to_are_refused(hall: Path, tmp_path: Path) -> None:
    with pytest.raises(host_sim.Error, match="expected watch, refit, diagnose"):
        host_sim.fleet(hall, tmp_path / "table", upto="all")  # type: ignore[arg-type]
    with pytest.raises(host_sim.Error, match="a share between 0 and 1"):
        host_sim.fleet(hall, tmp_path / "table", false_alarms=2.0)
    with pytest.raises(host_sim.Error, match="no night of any drive"):
        host_sim.fleet(tmp_path, tmp_path / "table")
    held = host_sim._native.FleetTable(tmp_path / "table")
    with pytest.raises(host_sim.Error, match="another run is writing"):
        host_sim.fleet(hall, tmp_path / "table")
    held.close()


def test_a_cluster_makes_the_same_rows_though_a_worker_is_killed_and_a_recording_is_poisoned(
    hall: Path, expected: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client, LocalCluster

    # Rows are written as they come: the kill falls between them.
    monkeypatch.setattr("host_sim._fleet._KEPT_S", 0.0)
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            first = next(iter(client.run(os.getpid).values()))

            def kill() -> None:
                # In the middle: when the first rows are there.
                began = time.monotonic()
                while time.monotonic() - began < 60.0 and not list((tmp_path / "table").glob("part-*")):
                    time.sleep(0.02)
                os.kill(first, signal.SIGKILL)

            killer = threading.Thread(target=kill)
            killer.start()
            run = host_sim.fleet(hall, tmp_path / "table", upto="refit", threads=1, client=client)
            killer.join()
            # One that is dying does not answer.
            assert first not in client.run(os.getpid, on_error="ignore").values()
            pd.testing.assert_frame_equal(rows(run.table), expected)
            assert host_sim.fleet(hall, tmp_path / "table", upto="refit", client=client).nights == 0


def test_a_fault_that_passes_makes_no_row_and_the_next_run_judges_the_night(
    hall: Path, expected: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client, LocalCluster

    judged = host_sim._fleet._judged

    def without_an_answer(night: host_sim.FleetNight, *arguments: object, **named: object) -> bytes:
        if night.drive == "b" and night.night == "2026-01-05":
            raise TimeoutError("the bucket does not answer")
        return judged(night, *arguments, **named)  # type: ignore[arg-type]

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            monkeypatch.setattr("host_sim._fleet._judged", without_an_answer)
            with pytest.raises(RuntimeError, match="1 of 36 nights .* b 2026-01-05: TimeoutError: the bucket does not answer"):
                host_sim.fleet(hall, tmp_path / "table", upto="refit", threads=1, client=client)
            monkeypatch.undo()
            assert host_sim.fleet(hall, tmp_path / "table", upto="refit", threads=1, client=client).nights == 1
    pd.testing.assert_frame_equal(rows(tmp_path / "table"), expected)


def test_a_bucket_is_a_path(hall: Path, expected: pd.DataFrame, tmp_path: Path) -> None:
    import fsspec
    from distributed import Client, LocalCluster

    # A bucket of fsspec's own, in the memory of the process that the worker is a thread of; of that filesystem a file cannot be read by two at once.
    bucket = fsspec.filesystem("memory")
    bucket.put(str(hall), "/hall", recursive=True)
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            run = host_sim.fleet("memory://hall", tmp_path / "table", upto="refit", threads=1, client=client)
    found = rows(run.table)
    # A reason names the machine file, which lies elsewhere.
    usable = found["verdict"] != "unusable"
    pd.testing.assert_frame_equal(found[usable], expected[usable])
    assert list(found["verdict"]) == list(expected["verdict"])


def test_any_engine_can_judge_the_nights_and_one_process_keeps_them(hall: Path, expected: pd.DataFrame, tmp_path: Path) -> None:
    # Not forked: a copy of this process has its threads' locks and not its threads.
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool, host_sim.FleetTable(tmp_path / "table") as table:
        parts = pool.map(partial(host_sim.fleet_part, upto="refit", threads=1), host_sim.fleet_nights(hall))
        assert sum(table.append([part]).get("unusable", 0) for part in parts) == NIGHTS
    pd.testing.assert_frame_equal(rows(tmp_path / "table"), expected)


def told(section: str) -> str:
    """The program that the book shows under this heading."""
    text = (ROOT / "docs" / "fleet.md").read_text(encoding="utf-8")
    return text.split(f"## {section}\n", 1)[1].split("```python\n", 1)[1].split("```", 1)[0]


@pytest.mark.parametrize("engine, needs", [("With Ray", "ray"), ("With Spark", "pyspark")])
def test_the_books_programs_for_other_engines_make_the_same_rows(
    engine: str, needs: str, hall: Path, expected: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip(needs)
    if needs == "pyspark" and shutil.which("java") is None:
        pytest.skip("pyspark is there, and no Java for it")
    monkeypatch.chdir(tmp_path)
    # Spark's workers run whatever is called python3.
    monkeypatch.setenv("PYSPARK_PYTHON", sys.executable)
    (tmp_path / "hall").symlink_to(hall)
    exec(compile(told(engine).replace('upto="diagnose"', 'upto="refit"'), engine, "exec"), {})
    found = pd.concat(pd.read_parquet(part) for part in sorted((tmp_path / "table").glob("part-*.parquet")))
    found = found.drop(columns="seconds", errors="ignore").sort_values(["drive", "night", "recording"], na_position="first")
    found = found.reset_index(drop=True)
    # A reason names the machine file, by the folder that was given.
    usable = expected["verdict"] != "unusable"
    pd.testing.assert_frame_equal(found[usable], expected.loc[usable, found.columns], check_dtype=False)
    assert list(found["verdict"]) == list(expected["verdict"])
