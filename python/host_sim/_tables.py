"""Tables of numbers, for pandas, polars, pyarrow and NumPy, none of which is needed until it is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy
    import pandas
    import polars
    import pyarrow

    from ._native import Table as _NativeTable


def array(values: bytes) -> numpy.ndarray:
    """The doubles of these bytes, which are not copied."""
    import numpy

    return numpy.frombuffer(values, dtype=numpy.float64)


class Table:
    """Columns of doubles under headers with their units, such as ``position [mm]``.

    It has Arrow's capsule, so that ``polars.DataFrame(table)`` and ``pyarrow.table(table)`` copy no number. A blank cell is null
    there, and NaN in NumPy and pandas.
    """

    def __init__(self, native: _NativeTable) -> None:
        self._inner = native

    @property
    def headers(self) -> list[str]:
        """The headers, each a name with its unit in brackets."""
        return self._inner.headers

    def __getitem__(self, header: str) -> numpy.ndarray:
        """The values of a column in the unit of its header."""
        return array(self._inner.column(header))

    def __iter__(self) -> Iterator[str]:
        return iter(self.headers)

    def __len__(self) -> int:
        """The number of columns, as of a mapping."""
        return len(self.headers)

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any:
        return self._inner.__arrow_c_stream__(requested_schema)

    def to_dict(self) -> dict[str, list[float | None]]:
        """Every column as a list of numbers; None where a cell is blank."""
        return {header: self._inner.cells(header) for header in self.headers}

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame({header: self[header] for header in self.headers})

    def to_polars(self) -> polars.DataFrame:
        """The table as a polars DataFrame, without a copy."""
        import polars

        return polars.DataFrame(self)

    def to_arrow(self) -> pyarrow.Table:
        """The table as a pyarrow Table, without a copy."""
        import pyarrow

        return pyarrow.table(self)

    def __repr__(self) -> str:
        return f"Table({', '.join(self.headers)})"
