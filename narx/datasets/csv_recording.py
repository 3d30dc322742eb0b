"""A single recording in a text file of the user's own.

The header says what a column is and in which unit; columns in any order, others are ignored:

============================== ==================================================
``time_s``                     sampling times in s (``_ms``, ``_us``, ``_ns``), or as ISO 8601
``gyroscope_x_rad_s``, y, z    angular rate in rad/s; or
``gyroscope_x_deg_s``, y, z    in deg/s
``accelerometer_x_m_s2``, y, z specific force in m/s^2 (at rest it points up); or
``accelerometer_x_g``, y, z    in units of standard gravity. Optional
============================== ==================================================

An empty cell, ``NA`` or ``nan`` is a missing value. Which dialect of text it is, is found
(`narx.datasets.text_dialect`), and the stamps become sampling times (`narx.recordings.stamps`).
"""

import os
from pathlib import Path

import numpy as np
import pandas as pd

from narx.datasets.layout import AXES, OWN, Found, Layout, find, require
from narx.datasets.text_dialect import TextTable, read_table
from narx.errors import RecordingError
from narx.files import atomic_path
from narx.recordings.one_clock import at_gyroscope_times
from narx.recordings.stamps import sampling_times
from narx.recordings.trial import ImuRecording
from narx.types import FloatArray


def read_recording(
    path: str | os.PathLike[str], segment: str = "imu", layout: Layout = OWN
) -> ImuRecording:
    """Read a recording from a text file.

    Parameters
    ----------
    path : path-like
        File in the format above, in any dialect of CSV.
    segment : str
        Segment that the sensor sits on, such as ``thigh_right``.
    layout : Layout
        What the columns are called.

    Returns
    -------
    ImuRecording
        In SI; the accelerometer is NaN throughout where the file has none. Its notes say what
        was done to the file's content.

    Raises
    ------
    RecordingError
        If a column is missing or there twice, has no known unit or not the same unit as its
        neighbours, a cell is not a number, the last line is cut off, or time does not increase;
        one line that names file and place.
    """
    file = Path(path)
    table = read_table(file)
    names, units = table.names, table.units
    time_column = require(layout.time, "time", names, units, str(file))
    gyroscope_columns = require(layout.gyroscope, "gyroscope", names, units, str(file))
    accelerometer_columns = None
    if layout.accelerometer is not None:
        accelerometer_columns = find(layout.accelerometer, "accelerometer", names, units, str(file))
        if accelerometer_columns is None and any(n.startswith("accelerometer_") for n in names):
            require(layout.accelerometer, "accelerometer", names, units, str(file))
    stamps, notes = _times(table, time_column)
    gyroscope = _vectors(table, gyroscope_columns)
    accelerometer = (
        np.full_like(gyroscope, np.nan)
        if accelerometer_columns is None
        else _vectors(table, accelerometer_columns)
    )
    used = np.column_stack([stamps, gyroscope, accelerometer])
    if not table.ends_in_line_break:
        read = used[-1, : used.shape[1] if accelerometer_columns else 4]
        if not np.isfinite(read).all():
            raise RecordingError(
                f"{file}: the last line has an empty cell and no line break (cut off?)"
            )
    times = sampling_times(stamps, used[:, 1:], str(file))
    recording = ImuRecording(
        segment,
        times.time_s,
        gyroscope[times.rows],
        accelerometer[times.rows],
        notes=(*table.notes, *notes, *times.notes),
    )
    return at_gyroscope_times(recording)


def write_recording(path: str | os.PathLike[str], recording: ImuRecording) -> None:
    """Write a recording to a CSV file that `read_recording` reads back exactly.

    Parameters
    ----------
    path : path-like
        File to write; replaced only when complete.
    recording : ImuRecording
        What to write. An accelerometer without any sample is left out.
    """
    columns: dict[str, FloatArray] = {"time_s": recording.time_s}
    for k, axis in enumerate(AXES):
        columns[f"gyroscope_{axis}_rad_s"] = recording.gyroscope_rad_s[:, k]
    if np.isfinite(recording.accelerometer_m_s2).any():
        for k, axis in enumerate(AXES):
            columns[f"accelerometer_{axis}_m_s2"] = recording.accelerometer_m_s2[:, k]
    with atomic_path(path) as temporary:
        # 17 digits hold a double exactly
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.17g", na_rep="nan")


def _vectors(table: TextTable, found: Found) -> FloatArray:
    columns = [
        table.numbers(index) * factor
        for index, factor in zip(found.indices, found.factors, strict=True)
    ]
    return np.column_stack(columns)


def _times(table: TextTable, found: Found) -> tuple[FloatArray, list[str]]:
    """Stamps in s; calendar times count from the first."""
    (column,), (factor,) = found.indices, found.factors
    cells = table.cells(column)
    if sum(":" in cell for cell in cells) > len(cells) // 2:
        stamps = pd.to_datetime(pd.Series(cells), format="ISO8601", utc=True, errors="coerce")
        wrong = np.flatnonzero(stamps.isna().to_numpy())
        if wrong.size:
            raise RecordingError(
                f"{table.path}: line {table.line_numbers[wrong[0]]}, column "
                f"{table.names[column]}: found '{cells[wrong[0]][:40]}', expected a date and time"
            )
        seconds = (stamps - stamps.iloc[0]).dt.total_seconds()
        return np.asarray(seconds, dtype=np.float64), [f"times count from {cells[0]}"]
    return table.numbers(column) * factor, []
