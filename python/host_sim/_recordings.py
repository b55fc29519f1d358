"""Recordings from files, data frames and arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Union

from . import _native
from ._machine import Machine
from ._tables import Table, array

if TYPE_CHECKING:
    import numpy
    import pandas
    import polars

Source = Union["Recording", str, "os.PathLike[str]", Mapping[str, Any], Any]
"""A recording, a file, a mapping from headers to arrays, or anything with Arrow's capsule: pandas, polars, pyarrow."""


class Column(NamedTuple):
    """A known column of a recording."""

    signal: str
    header: str
    unit: str
    """The unit of the file, not that of the values inside, which is SI."""


class Recording:
    """A recording: signals in SI units on one time base. Made by :func:`read`."""

    _inner: _native.Recording

    @classmethod
    def _of(cls, native: _native.Recording) -> Recording:
        recording = cls.__new__(cls)
        recording._inner = native
        return recording

    @property
    def name(self) -> str:
        """The file's name without its folder, or the name that was given."""
        return self._inner.name

    @property
    def path(self) -> str:
        """The file as it was named."""
        return self._inner.path

    @property
    def columns(self) -> list[Column]:
        """The known columns; time is the first."""
        return [Column(*column) for column in self._inner.columns]

    @property
    def ignored(self) -> list[str]:
        """The headers of columns that no signal is known by."""
        return self._inner.ignored

    @property
    def notes(self) -> list[str]:
        """What was corrected or noticed in reading."""
        return self._inner.notes

    def __len__(self) -> int:
        """The number of rows."""
        return self._inner.rows

    def __getitem__(self, signal: str) -> numpy.ndarray:
        """The values of a signal in its SI unit (``"position"`` in m, ``"pressure_a"`` in Pa, ``"time"`` in s)."""
        values, _ = self._inner.si(signal)
        return array(values)

    def table(self) -> Table:
        """The columns in the units of the recording, as they would be written."""
        return Table(self._inner.table())

    def to_pandas(self) -> pandas.DataFrame:
        """The columns in the units of the recording, as a pandas DataFrame."""
        return self.table().to_pandas()

    def to_polars(self) -> polars.DataFrame:
        """The columns in the units of the recording, as a polars DataFrame."""
        return self.table().to_polars()

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any:
        return self._inner.table().__arrow_c_stream__(requested_schema)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it, whole or not at all: .csv, .txt, .mat or .parquet."""
        self._inner.save(path)

    def __repr__(self) -> str:
        return f"Recording({self.name!r}, {len(self)} rows, {', '.join(column.header for column in self.columns)})"


def read(
    source: Source,
    *,
    name: str | None = None,
    units: Mapping[str, str] | None = None,
    map: Mapping[str, str] | None = None,
    machine: Machine | None = None,
) -> Recording:
    """Reads a recording.

    Args:
        source: a file (CSV, TwinCAT Scope text, .mat, .mf4, .parquet); a data frame of pandas, polars or pyarrow, or anything else
            with ``__arrow_c_stream__`` or ``__arrow_c_array__``; or a mapping from headers to NumPy arrays or sequences. Memory
            is read where it is: the only copy is that into the recording, in SI units.
        name: stands for the file in messages and results, for a recording in memory.
        units: the units of columns whose headers give none, ``{"position": "mm"}``; in memory only. Headers may give it
            themselves, as ``"position [mm]"`` or ``"position_mm"``.
        map: which column holds a signal, where its header does not say: ``{"position": "Kolbenweg [mm]"}``.
        machine: its ``[channels]`` and ``[linkage]`` apply, as they do where a file is given to ``compare`` or ``diagnose``. A
            ``Recording`` is taken as it was read: give the machine where it is read.

    Raises:
        Error: what is wrong, with ``file``, ``row`` and ``key`` (the column).
    """
    if isinstance(source, Recording):
        return source
    maps = [f"{signal}={header}" for signal, header in (map or {}).items()]
    native = machine._inner if machine is not None else None
    if isinstance(source, (str, os.PathLike)):
        if units:
            raise TypeError("units: a file gives its own; expected none, or map={'position': 'Kolbenweg [mm]'}")
        return Recording._of(_native.read(source, native, maps))
    label = name or "recording"
    given = {str(header): unit for header, unit in (units or {}).items()}
    if hasattr(source, "__arrow_c_stream__") or hasattr(source, "__arrow_c_array__"):
        try:
            return Recording._of(_native.from_arrow(source, label, given, native, maps))
        except ImportError:
            # pandas makes its capsule by pyarrow; without it the columns are NumPy's.
            if not hasattr(source, "to_numpy"):
                raise
    columns = [(str(header), given.get(str(header)), _plain(values)) for header, values in _items(source)]
    return Recording._of(_native.from_columns(columns, label, native, maps))


def _items(source: Any) -> list[tuple[Any, Any]]:
    if hasattr(source, "items"):
        index = getattr(source, "index", None)
        label = getattr(index, "name", None)
        named = [(label, index)] if label is not None else []
        return named + list(source.items())
    raise TypeError(
        f"a {type(source).__name__} is no recording; expected a file, a mapping from headers to arrays, or a data frame"
    )


def _plain(values: Any) -> Any:
    """A pandas Series or index as the array that it holds, times of a zone as those of UTC; NumPy's numbers of other widths or byte orders as doubles, with NaN
    where they are masked; everything else as it is."""
    if hasattr(values, "to_numpy"):
        has_zone = getattr(getattr(values, "dtype", None), "tz", None) is not None
        values = values.to_numpy(dtype=f"datetime64[{values.dtype.unit}]") if has_zone else values.to_numpy()
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if kind not in ("f", "i", "u"):
        return values
    if hasattr(values, "mask"):
        return values.astype("f8").filled(float("nan"))
    bytes_each = values.dtype.itemsize
    is_read = values.dtype.isnative and (bytes_each in (4, 8) or (kind != "f" and bytes_each < 4))
    return values if is_read else values.astype("f8")


def read_all(
    sources: Source | Sequence[Source], map: Mapping[str, str] | None, machine: Machine | None
) -> list[_native.Recording]:
    """One recording or several, as the native half takes them."""
    listed = sources if isinstance(sources, Sequence) and not isinstance(sources, str) else [sources]
    names = [f"recording-{number}" for number in range(1, len(listed) + 1)] if len(listed) > 1 else [None]
    return [read(source, name=name, map=map, machine=machine)._inner for source, name in zip(listed, names)]
