"""Many drives, every night: the recordings of each night of each drive become a row of a Parquet table.

The work is the program's own (``host-sim fleet``): one drive and one night know nothing of any other. Here it runs on the threads
of this process, or on the workers of a Dask cluster, which may be anywhere; the rows are the same.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, Union

from . import _native

Upto = Literal["watch", "refit", "diagnose"]
How = tuple[str, float, float]


class FleetNight(NamedTuple):
    """One drive and one night: a piece of work that knows nothing of the others, and may be sent anywhere."""

    drive: str
    """The drive's name."""
    night: str
    """The night's name."""
    machine: _native.Path
    """The drive's machine file; it may not be there."""
    recordings: list[_native.Path]
    """The night's recordings."""
    twin: _native.Path | None
    """Another folder of the same name; then neither can be used."""


_KEPT_S = 5.0
"""How long parts are kept back at most before they are written: as much is lost when the run is killed."""


@dataclass(frozen=True)
class FleetRun:
    """What one run over the nights of many drives did."""

    table: str
    """The folder of the rows: ``pandas.read_parquet(run.table)``."""
    verdicts: dict[str, int]
    """How many of the nights that it judged ended how: ``in-band``, ``unchanged``, ``changed``, ``left-band``, ``unexplained``, ``unusable``."""

    @property
    def nights(self) -> int:
        """How many nights it judged; those that were in the table already do not count."""
        return sum(self.verdicts.values())


def fleet(
    dataset: Union[str, "os.PathLike[str]"],
    out: Union[str, "os.PathLike[str]"],
    *,
    upto: Upto = "diagnose",
    false_alarms: float = 1e-3,
    time_limit_s: float = 300.0,
    threads: int | None = None,
    client: Any = None,
    storage_options: Mapping[str, Any] | None = None,
) -> FleetRun:
    """Judges every night of every drive that the table does not have yet.

    A run that was killed goes on where it was: no row is lost and none comes twice. Whatever is wrong with a night is a row with the reason.

    Args:
        dataset: a folder ``drive=NAME/machine.toml``, ``drive=NAME/date=NIGHT/`` with recordings; with ``client`` also a bucket, as fsspec names it.
        out: the folder of the rows, Parquet; made where it is not there.
        upto: how far a night is looked into: ``watch`` whether the drive is in its band, ``refit`` also how much there is of every effect,
            ``diagnose`` also what has changed in a drive that left its band.
        false_alarms: share of a healthy drive's recordings that may leave the band by chance.
        time_limit_s: what the search of one diagnosis may take, s on two usual cores.
        threads: how many threads compute here, or on each worker for one night.
        client: a ``dask.distributed.Client``: its workers judge the nights. A worker that dies has its nights judged by another.
        storage_options: what fsspec needs to open ``dataset``.
    """
    how = (str(upto), float(false_alarms), float(time_limit_s))
    if client is None:
        if storage_options is not None:
            raise TypeError("storage_options: only for the workers of a client; expected client=dask.distributed.Client(...)")
        counts = _native.fleet(Path(dataset), Path(out), how, threads)
        return FleetRun(os.fspath(out), counts)
    return FleetRun(os.fspath(out), _on_workers(client, os.fspath(dataset), Path(out), how, threads, dict(storage_options or {})))


def fleet_nights(dataset: Union[str, "os.PathLike[str]"]) -> list[FleetNight]:
    """Every night of every drive in a folder, in the order of their names; paths are absolute, since workers may stand in another folder."""
    return [FleetNight(*night) for night in _native.nights(Path(dataset).absolute())]


def fleet_part(
    night: FleetNight,
    *,
    upto: Upto = "diagnose",
    false_alarms: float = 1e-3,
    time_limit_s: float = 300.0,
    threads: int | None = None,
) -> bytes:
    """The rows of one night as the bytes of a Parquet file: what a worker of any engine computes.

    Whatever is wrong with the night is a row with the reason. The arguments are those of :func:`fleet`.
    """
    return _native.judge(night, (str(upto), float(false_alarms), float(time_limit_s)), threads)


def _nights(dataset: str, storage: dict[str, Any]) -> tuple[list[FleetNight], bool]:
    """The nights of a data set, and whether its files have to be fetched first."""
    if "://" not in dataset:
        # Workers may stand in another folder.
        return fleet_nights(dataset), False
    import fsspec

    files, root = fsspec.core.url_to_fs(dataset, **storage)
    below = [path[len(root) :].lstrip("/") for path in files.find(root)]
    return [FleetNight(*night) for night in _native.nights_of(Path(root), below)], True


def _judged(night: FleetNight, how: How, threads: int | None, source: tuple[str, dict[str, Any]] | None) -> bytes:
    """The rows of a night as a part of a table; on a worker."""
    if source is None:
        return _native.judge(night, how, threads)
    import fsspec

    files, _ = fsspec.core.url_to_fs(source[0], **source[1])
    drive, name, machine, recordings, twin = night
    with tempfile.TemporaryDirectory() as folder:

        def fetched(path: _native.Path) -> Path:
            here = Path(folder) / Path(path).name
            try:
                files.get_file(os.fspath(path), os.fspath(here))
            except FileNotFoundError:
                # It is missing, which the row says; a bucket that does not answer is no row.
                pass
            return here

        near = FleetNight(drive, name, fetched(machine), [fetched(path) for path in recordings], twin)
        return _native.judge(near, how, threads)


def _on_workers(
    client: Any, dataset: str, out: Path, how: How, threads: int | None, storage: dict[str, Any]
) -> dict[str, int]:
    from distributed import as_completed

    # It has no types.
    completed: Any = as_completed
    nights, is_remote = _nights(dataset, storage)
    if not nights:
        raise _native.Error(f"{dataset}: no night of any drive; expected folders as drive=press-1/date=2026-11-30 with recordings")
    table = _native.FleetTable(out)
    try:
        pending = [night for night in nights if not table.has(night[0], night[1])]
        source = (dataset, storage) if is_remote else None
        futures = client.map(_judged, pending, how=how, threads=threads, source=source, pure=False)
        of = {future.key: night for future, night in zip(futures, pending)}
        counts: dict[str, int] = {}
        kept: list[bytes] = []
        since = time.monotonic()

        def write() -> None:
            for verdict, count in table.append(kept).items():
                counts[verdict] = counts.get(verdict, 0) + count
            kept.clear()

        failed: list[tuple[FleetNight, BaseException]] = []
        for future in completed(futures):
            night = of[future.key]
            try:
                kept.append(_part(future, night))
            except Exception as error:
                # A passing fault makes no row: the next run judges the night.
                failed.append((night, error))
            future.release()
            if time.monotonic() - since >= _KEPT_S:
                write()
                since = time.monotonic()
        write()
        if failed:
            night, first = failed[0]
            if isinstance(first, _native.Error):
                raise first
            what = f"{len(failed)} of {len(pending)} nights could not be judged and are left for the next run, the first is {night.drive} {night.night}"
            raise RuntimeError(f"{what}: {type(first).__name__}: {first}") from first
        return counts
    finally:
        table.close()


def _part(future: Any, night: FleetNight) -> bytes:
    """What a worker made of a night; that of a night on which workers die again and again is a row that says so. Any other error is raised."""
    from distributed.scheduler import KilledWorker

    error = future.exception()
    if error is None:
        part: bytes = future.result()
        return part
    if isinstance(error, KilledWorker):
        return _native.unusable(night, f"{type(error).__name__}: {error}")
    raise error
