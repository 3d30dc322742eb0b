"""Named numeric columns of binary files: Parquet, and arrays in a MATLAB file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from narx.datasets.layout import AXES
from narx.datasets.mat_file import read_mat
from narx.errors import RecordingError
from narx.recordings.input_file import check_memory, regular_file
from narx.types import FloatArray

# columns that are read, and copies of them in memory until a recording is made
_COLUMNS, _COPIES = 7, 3


class ArrayTable:
    """Named columns, each read on demand.

    Parameters
    ----------
    path : pathlib.Path
        The file, for messages.
    names : tuple of str
        One name per column.
    read : callable
        Returns the column with a given index.
    """

    units: None = None
    notes: tuple[str, ...] = ()
    comments: tuple[str, ...] = ()

    def __init__(
        self, path: Path, names: tuple[str, ...], read: Callable[[int], pd.Series]
    ) -> None:
        self.path = path
        self.names = names
        self._read = read

    def numbers(self, column: int) -> FloatArray:
        """Return a column of numbers.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        ndarray, shape (N,)
            NaN where missing.

        Raises
        ------
        RecordingError
            If it is not numeric.
        """
        try:
            values = np.asarray(self._read(column), dtype=np.float64)
        except (TypeError, ValueError):
            raise RecordingError(
                f"{self.path}: column {self.names[column]} does not hold numbers"
            ) from None
        # a damaged file may hold NaN that signal, of which arithmetic would warn
        return np.where(np.isnan(values), np.nan, values)

    def seconds(self, column: int) -> tuple[FloatArray, tuple[str, ...]] | None:
        """Return a column of dates and times as seconds from the first.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        tuple of ndarray and tuple of str, or None
            Seconds and a note; None for a column of numbers.

        Raises
        ------
        RecordingError
            If they are further apart than pandas can tell.
        """
        values = self._read(column)
        if pd.api.types.is_timedelta64_dtype(values):
            return np.asarray(values.dt.total_seconds(), dtype=np.float64), ()
        if not pd.api.types.is_datetime64_any_dtype(values):
            return None
        if not len(values):
            return np.zeros(0), ()
        begin = values.iloc[0]
        try:
            seconds = (values - begin).dt.total_seconds()
        except OverflowError:
            raise RecordingError(
                f"{self.path}: column {self.names[column]} has dates centuries apart"
            ) from None
        return np.asarray(seconds, dtype=np.float64), (f"times count from {begin.isoformat()}",)


def read_parquet(path: Path, rows: tuple[int, int] | None = None) -> ArrayTable:
    """Open a Parquet file; columns are read one by one.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    rows : tuple of (int, int), optional
        First row, and the row after the last; only the groups of rows that hold them are read.

    Returns
    -------
    ArrayTable
        Its columns.

    Raises
    ------
    RecordingError
        If it is not a complete Parquet file.
    """
    import pyarrow
    import pyarrow.parquet

    try:
        # metadata.schema would be a cycle of references: 16 MB for a day, until it is collected
        with pyarrow.parquet.ParquetFile(regular_file(path)) as whole:
            metadata, names = whole.metadata, tuple(whole.schema_arrow.names)
    except (pyarrow.ArrowException, OSError, UnicodeDecodeError) as error:
        line = str(error).strip().splitlines()[0]
        raise RecordingError(f"{path}: not a whole Parquet file ({line})") from None

    # a recording takes seven columns; equal values take no space in the file
    start, stop = rows or (0, metadata.num_rows)
    check_memory(path, 8 * (stop - start) * min(len(names), _COLUMNS) * _COPIES)
    ends = np.cumsum([metadata.row_group(g).num_rows for g in range(metadata.num_row_groups)])
    groups = range(int(np.searchsorted(ends, start, "right")), int(np.searchsorted(ends, stop)) + 1)

    def read(k: int) -> pd.Series:
        try:
            with pyarrow.parquet.ParquetFile(path) as file:
                if rows is None:
                    column, skipped = file.read(columns=[names[k]]).column(0), 0
                else:
                    inside = [group for group in groups if group < len(ends)]
                    column = file.read_row_groups(inside, columns=[names[k]]).column(0)
                    skipped = start - (int(ends[groups[0] - 1]) if groups[0] else 0)
            values = column.slice(skipped, stop - start).to_pandas()
        except (pyarrow.ArrowException, OSError) as error:
            line = str(error).strip().splitlines()[0]
            raise RecordingError(f"{path}: column {names[k]} cannot be read ({line})") from None
        if len(values) != min(stop, metadata.num_rows) - start:
            raise RecordingError(
                f"{path}: column {names[k]} has {len(values)} rows, the file {metadata.num_rows}: "
                "not a whole Parquet file"
            )
        return values

    return ArrayTable(path, names, read)


def read_mat_table(path: Path) -> ArrayTable:
    """Read the arrays of a MATLAB file as columns.

    Parameters
    ----------
    path : pathlib.Path
        MATLAB 5 file with vectors (``time_s``, ``gyroscope_x_rad_s``) or arrays of three columns
        (``gyroscope_rad_s``), whose axes are then x, y, z; or with one struct of these.

    Returns
    -------
    ArrayTable
        An array of three columns appears as ``gyroscope_x_rad_s`` etc.

    Raises
    ------
    RecordingError
        If it is not a complete MATLAB file, or arrays differ in length.
    """
    columns: dict[str, FloatArray] = {}
    variables = read_mat(regular_file(path))
    if len(variables) == 1 and hasattr(one := next(iter(variables.values())), "_fieldnames"):
        variables = {name: getattr(one, name) for name in one._fieldnames}
    for name, value in variables.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "iuf":
            continue
        if value.ndim == 1:
            columns[name] = value
        elif value.ndim == 2 and 3 in value.shape:
            first, _, rest = name.partition("_")
            for axis, one in zip(AXES, value.T if value.shape[1] == 3 else value, strict=True):
                columns["_".join(part for part in (first, axis, rest) if part)] = one
    lengths = {len(values) for values in columns.values() if len(values) > 1}
    if len(lengths) > 1:
        raise RecordingError(f"{path}: arrays of {' and '.join(map(str, sorted(lengths)))} samples")
    names = tuple(name for name, values in columns.items() if len(values) in lengths)
    return ArrayTable(path, names, lambda k: pd.Series(columns[names[k]]))
