"""A single recording in a user's file.

The names of the columns give quantity and unit; in any order, others are ignored:

============================== ==================================================
``time_s``                     sampling times in s (``_ms``, ``_us``, ``_ns``, ``_min``), or as
                               dates and times
``gyroscope_x_rad_s``, y, z    angular rate in rad/s; or
``gyroscope_x_deg_s``, y, z    in deg/s
``accelerometer_x_m_s2``, y, z specific force in m/s^2 (at rest it points up); or
``accelerometer_x_g``, y, z    in units of standard gravity. Optional
============================== ==================================================

An empty cell, ``NA`` or ``nan`` is a missing value. The dialect of the text is detected
(`narx.datasets.text_dialect`), exports of known devices are recognised
(`narx.datasets.device_layouts`), and the stamps become sampling times (`narx.recordings.stamps`).
"""

import gzip
import io
import os
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from narx.datasets.apdm_file import SUFFIXES as APDM_SUFFIXES
from narx.datasets.apdm_file import read_apdm
from narx.datasets.array_table import read_mat_table, read_parquet
from narx.datasets.bundle import read_bundle
from narx.datasets.layout import AXES, Layout
from narx.datasets.plain_text import plain_table
from narx.datasets.table_recording import Table, recording_from
from narx.datasets.text_dialect import read_table
from narx.errors import RecordingError
from narx.files import atomic_path
from narx.recordings.input_file import check_memory, is_bundle, limit_mib, regular_file
from narx.recordings.trial import ImuRecording
from narx.types import FloatArray


def read_recording(
    path: str | os.PathLike[str], segment: str = "imu", layout: Layout | None = None
) -> ImuRecording:
    """Read a recording.

    Parameters
    ----------
    path : path-like
        Text in any dialect of CSV, also compressed (``.csv.gz``); Parquet (``.parquet``); MATLAB 5
        with named arrays (``.mat``); HDF5 of APDM (``.h5``), of which the sensor labelled as the
        segment is read; a zip or folder of a phone app, with one file per sensor.
    segment : str
        Segment that carries the sensor, such as ``thigh_right``.
    layout : Layout, optional
        Names of the columns; None uses the names above, or those of a known device.

    Returns
    -------
    ImuRecording
        In SI; the accelerometer is NaN throughout if the file has none. Its notes list the
        processing of the file's content.

    Raises
    ------
    RecordingError
        If a column is missing or duplicated, has an unknown unit or not the same unit as its
        neighbours, a cell is not a number, the last line is cut off, or time does not increase; the
        message is one line with file and place.
    """
    file = Path(path)
    if file.suffix.lower() == ".zip" or is_bundle(file):
        return read_bundle(file, segment)
    if file.suffix.lower() in APDM_SUFFIXES:
        return recording_from(read_apdm(file, segment), layout, segment)
    return recording_from(open_table(file), layout, segment)


def open_table(file: Path) -> Table:
    """Open a file of named columns.

    Parameters
    ----------
    file : pathlib.Path
        Text, Parquet or MATLAB 5, by its suffix.

    Returns
    -------
    Table
        Its columns.

    Raises
    ------
    RecordingError
        If it is damaged.
    """
    suffix = file.suffix.lower()
    if suffix in (".parquet", ".pq"):
        return read_parquet(file)
    if suffix == ".mat":
        return read_mat_table(file)
    content = regular_file(file).read_bytes()
    if suffix == ".gz":
        content = _unpacked(file, content)
    return plain_table(file, content) or read_table(file, content)


def _unpacked(file: Path, content: bytes) -> bytes:
    """Unpack a compressed text, no further than the memory limit."""
    most = int(limit_mib() * 2**20)
    try:
        with gzip.open(io.BytesIO(content)) as stream:
            unpacked = stream.read(most + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise RecordingError(f"{file}: not a whole gzip file ({error})") from None
    check_memory(file, len(unpacked))
    return unpacked


def write_recording(path: str | os.PathLike[str], recording: ImuRecording) -> None:
    """Write a recording to a CSV file that `read_recording` reads back exactly.

    Parameters
    ----------
    path : path-like
        File to write; replaced only when complete.
    recording : ImuRecording
        Recording to write. An accelerometer without any sample is left out.
    """
    columns: dict[str, FloatArray] = {"time_s": recording.time_s}
    for k, axis in enumerate(AXES):
        columns[f"gyroscope_{axis}_rad_s"] = recording.gyroscope_rad_s[:, k]
    if np.isfinite(recording.accelerometer_m_s2).any():
        for k, axis in enumerate(AXES):
            columns[f"accelerometer_{axis}_m_s2"] = recording.accelerometer_m_s2[:, k]
    with atomic_path(path) as temporary:
        # 17 digits represent a double exactly
        pd.DataFrame(columns).to_csv(temporary, index=False, float_format="%.17g", na_rep="nan")
