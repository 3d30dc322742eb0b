"""A single recording in a CSV file of the user's own.

The header says what a column is and in which unit; columns in any order, others are ignored:

============================== ==================================================
``time_s``                     sampling times in s, increasing, regular or not
``gyroscope_x_rad_s``, y, z    angular rate in rad/s; or
``gyroscope_x_deg_s``, y, z    in deg/s
``accelerometer_x_m_s2``, y, z specific force in m/s^2 (at rest it points up); or
``accelerometer_x_g``, y, z    in units of standard gravity. Optional
============================== ==================================================

An empty cell or ``nan`` is a missing value.
"""

import os
from pathlib import Path

import numpy as np
import pandas as pd

from narx.datasets.text_table import read_header, read_numbers
from narx.errors import RecordingError
from narx.files import atomic_path
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording
from narx.types import FloatArray

_AXES = ("x", "y", "z")
_GYROSCOPE_UNITS = {"rad_s": 1.0, "deg_s": np.pi / 180.0}
_ACCELEROMETER_UNITS = {"m_s2": 1.0, "g": GRAVITY_M_S2}


def read_recording(path: str | os.PathLike[str], segment: str = "imu") -> ImuRecording:
    """Read a recording from a CSV file.

    Parameters
    ----------
    path : path-like
        File in the format above.
    segment : str
        Segment that the sensor sits on, such as ``thigh_right``.

    Returns
    -------
    ImuRecording
        In SI; the accelerometer is NaN throughout where the file has none.

    Raises
    ------
    RecordingError
        If a column is missing, has no known unit or not the same unit as its neighbours, a cell
        is not a number, the last line is cut off, or time does not increase; one line that names
        file and place.
    """
    file = Path(path)
    header = read_header(file, separator=",")
    gyroscope_columns, gyroscope_unit = _columns(file, header, "gyroscope", _GYROSCOPE_UNITS)
    accelerometer_columns: list[str] = []
    accelerometer_unit = 1.0
    if any(name.startswith("accelerometer_") for name in header):
        accelerometer_columns, accelerometer_unit = _columns(
            file, header, "accelerometer", _ACCELEROMETER_UNITS
        )
    table = read_numbers(
        file,
        separator=",",
        columns=["time_s", *gyroscope_columns, *accelerometer_columns],
        missing_allowed=True,
    )
    if not np.isfinite(table[-1]).all() and not file.read_bytes().endswith(b"\n"):
        raise RecordingError(
            f"{file}: the last line has an empty cell and no line break (cut off?)"
        )
    time, gyroscope = table[:, 0], table[:, 1:4] * gyroscope_unit
    accelerometer = (
        table[:, 4:7] * accelerometer_unit
        if accelerometer_columns
        else np.full_like(gyroscope, np.nan)
    )
    wrong = np.flatnonzero(~(np.diff(time, prepend=-np.inf) > 0))
    if wrong.size:
        raise RecordingError(
            f"{file}: time_s does not increase at data row {wrong[0] + 1} ({time[wrong[0]]:g} s)"
        )
    return ImuRecording(segment, time, gyroscope, accelerometer)


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
    for k, axis in enumerate(_AXES):
        columns[f"gyroscope_{axis}_rad_s"] = recording.gyroscope_rad_s[:, k]
    if np.isfinite(recording.accelerometer_m_s2).any():
        for k, axis in enumerate(_AXES):
            columns[f"accelerometer_{axis}_m_s2"] = recording.accelerometer_m_s2[:, k]
    with atomic_path(path) as temporary:
        # 17 digits hold a double exactly
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.17g", na_rep="nan")


def _columns(
    path: Path, header: list[str], sensor: str, units: dict[str, float]
) -> tuple[list[str], float]:
    """Find the three columns of a sensor and their factor to SI."""
    for unit, factor in units.items():
        names = [f"{sensor}_{axis}_{unit}" for axis in _AXES]
        present = [name for name in names if name in header]
        if len(present) == len(names):
            return names, factor
        if present:
            missing = next(name for name in names if name not in header)
            raise RecordingError(
                f"{path}: no column '{missing}' beside '{present[0]}'; found {', '.join(header)}"
            )
    expected = " or ".join(f"{sensor}_x_{unit}" for unit in units)
    raise RecordingError(
        f"{path}: no column '{expected}' (and y, z); found {', '.join(header) or 'nothing'}"
    )
