"""The native half, for type checkers. What users see has its own types."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, final

Path = str | os.PathLike[str]

__version__: str

class Error(Exception):
    """What cannot be done, in the program's words."""

    file: str | None
    """The file, or the name of a recording in memory."""
    row: int | None
    """The line of a text, or the row of a table, from 1."""
    key: str | None
    """The column, the key of a machine file, or the argument."""

@final
class Table:
    headers: list[str]
    def column(self, header: str) -> bytes: ...
    def cells(self, header: str) -> list[float | None]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any: ...

@final
class Machine:
    name: str
    path: str
    source: str
    effects: list[str]
    @staticmethod
    def read(path: Path) -> Machine: ...
    @staticmethod
    def from_toml(text: str, name: str) -> Machine: ...
    @staticmethod
    def describe(key: str) -> tuple[str, str, float, float]: ...
    def keys(self) -> list[str]: ...
    def __getitem__(self, key: str) -> float: ...
    def replaced(self, values: Sequence[tuple[str, float]]) -> Machine: ...
    def to_toml(self) -> str: ...
    def save(self, path: Path) -> None: ...

@final
class Recording:
    name: str
    path: str
    rows: int
    columns: list[tuple[str, str, str]]
    ignored: list[str]
    notes: list[str]
    def si(self, name: str) -> tuple[bytes, str]: ...
    def table(self) -> Table: ...
    def save(self, path: Path) -> None: ...

@final
class Simulated:
    table: Table
    tick_ms: float
    notes: list[str]
    drawing: str | None

@final
class Diagnosed:
    notes: list[str]
    def json(self) -> str: ...
    def text(self) -> str: ...
    def page(self) -> Page: ...
    def machine(self) -> Machine: ...
    def recordings(self) -> list[str]: ...
    def trajectories(self, index: int) -> Table | None: ...

@final
class Page:
    def html(self, written: str | None, command: str | None) -> str: ...

def read(path: Path, machine: Machine | None, maps: Sequence[str]) -> Recording: ...
def listed(folder: Path, prefix: str) -> list[str]: ...
def from_arrow(
    table: Any, name: str, units: Mapping[str, str], machine: Machine | None, maps: Sequence[str]
) -> Recording: ...
def from_columns(
    columns: Sequence[tuple[str, str | None, Any]], name: str, machine: Machine | None, maps: Sequence[str]
) -> Recording: ...
def inspect(
    recordings: Sequence[Recording], machine: Machine | None, threads: int | None
) -> tuple[str, str, Page]: ...
def simulate(
    machine: Machine,
    recording: Recording | None,
    input: str | None,
    number: str,
    tick_ms: float | None,
    threads: int | None,
) -> Simulated: ...
def compare(
    machine: Machine,
    recordings: Sequence[Recording],
    judge: Sequence[str],
    number: str,
    tick_ms: float | None,
    threads: int | None,
) -> tuple[str, list[str], list[str], list[Table], Page]: ...
def fit(
    machine: Machine,
    train: Sequence[Recording],
    holdout: Sequence[Recording],
    judge: Sequence[str],
    tick_ms: float | None,
    as_recorded: bool,
    threads: int | None,
) -> tuple[str, Machine, list[str], str, Page]: ...
def diagnose(
    machine: Machine,
    train: Sequence[Recording],
    holdout: Sequence[Recording],
    asks_since: bool,
    judge: Sequence[str],
    tick_ms: float | None,
    limit_s: float,
    as_recorded: bool,
    threads: int | None,
) -> Diagnosed: ...
def plan(
    machine: Machine,
    sensors: Sequence[str],
    excitation: tuple[str | None, Recording | None],
    largest_v: float | None,
    longest_s: float,
    can_load: bool,
    threads: int | None,
) -> tuple[str, Recording, str, str]: ...

_Night = tuple[str, str, Path, list[Path], Path | None]

def nights(dataset: Path) -> list[_Night]: ...
def nights_of(dataset: Path, paths: Sequence[str]) -> list[_Night]: ...
def judge(one: _Night, asked: tuple[str, float, float], threads: int | None) -> bytes: ...
def unusable(one: _Night, reason: str) -> bytes: ...
def fleet(dataset: Path, out: Path, asked: tuple[str, float, float], threads: int | None) -> dict[str, int]: ...
@final
class FleetTable:
    def __init__(self, folder: Path) -> None: ...
    def has(self, drive: str, night: str) -> bool: ...
    def append(self, parts: Sequence[bytes]) -> dict[str, int]: ...
    def close(self) -> None: ...
    def __enter__(self) -> "FleetTable": ...
    def __exit__(self, *error: object) -> None: ...
