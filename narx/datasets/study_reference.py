"""Orientation of a tracked body from a file: quaternions over time."""

from pathlib import Path

import numpy as np

from narx.datasets.column_search import require
from narx.datasets.csv_recording import open_table
from narx.datasets.layout import Columns
from narx.datasets.study_file import ReferenceFiles
from narx.datasets.synchronised import Tracked
from narx.datasets.table_recording import Table
from narx.errors import RecordingError
from narx.types import FloatArray

_NORM_TOLERANCE = 1e-2


def read_orientation(path: Path, reference: ReferenceFiles) -> Tracked:
    """Read an orientation over time.

    Parameters
    ----------
    path : pathlib.Path
        Text, Parquet or MATLAB file.
    reference : ReferenceFiles
        Names of its columns.

    Returns
    -------
    time_s : ndarray, shape (K,)
        Increasing, s.
    quaternion_wxyz : ndarray, shape (K, 4)
        Of norm 1, from the tracked body to the global frame; NaN where missing. A row of zeros is
        a lost pose.

    Raises
    ------
    RecordingError
        If a column is missing, time does not increase, or a quaternion is not of norm 1.
    """
    table = open_table(path)
    time = _time_s(table, Columns(reference.time))
    quaternion = np.column_stack([_column(table, name) for name in reference.quaternion])
    norm = np.linalg.norm(quaternion, axis=1)
    quaternion[norm == 0] = np.nan
    wrong = np.flatnonzero(np.isfinite(norm) & (norm != 0) & (np.abs(norm - 1) > _NORM_TOLERANCE))
    if wrong.size:
        raise RecordingError(
            f"{path}: the quaternion of data row {wrong[0] + 1} has norm {norm[wrong[0]]:.3g}, "
            "expected 1"
        )
    quaternion /= np.where(norm > 0, norm, np.nan)[:, None]
    if reference.rotates == "from_global":
        quaternion[:, 1:] *= -1
    backwards = np.flatnonzero(~(np.diff(time) > 0))
    if backwards.size:
        raise RecordingError(f"{path}: time does not increase at data row {backwards[0] + 2}")
    if np.isfinite(quaternion).all(axis=1).sum() < 2:
        raise RecordingError(f"{path}: no two orientations, expected a recording")
    return time, quaternion


def _time_s(table: Table, columns: Columns) -> FloatArray:
    hint = "another name is given as reference.time in the study's file"
    found = require((columns,), "time", table.names, table.units, str(table.path), hint)
    calendar = table.seconds(found.indices[0])
    if calendar is not None:
        return calendar[0]
    return table.numbers(found.indices[0]) * found.factors[0]


def _column(table: Table, name: str) -> FloatArray:
    names = [one.strip().lower() for one in table.names]
    if names.count(name.lower()) != 1:
        raise RecordingError(
            f"{table.path}: {names.count(name.lower())} columns '{name}', expected one; found "
            f"{', '.join(one for one in table.names[:20] if one)}"
        )
    return table.numbers(names.index(name.lower()))
