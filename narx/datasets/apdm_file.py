"""HDF5 files of APDM's Opal sensors, as Motion Studio, Mobility Lab and Moveo write them.

Up to format 4 every sensor is a group named by ``CaseIdList``, its label is in ``MonitorLabelList``
and its samples in ``Calibrated``; from format 5 it is a group below ``Sensors``, whose
``Configuration`` has the label ``Label 0``. Times are in microseconds since 1970, rates in rad/s,
specific forces in m/s^2.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from narx.datasets.array_table import ArrayTable
from narx.datasets.layout import AXES
from narx.datasets.segment_names import segment_of
from narx.errors import RecordingError, UserError
from narx.recordings.input_file import check_memory, regular_file
from narx.types import FloatArray

SUFFIXES = (".h5", ".hdf5")
_DATASETS = {
    "gyroscope_{}_rad_s": ("Gyroscope", "Calibrated/Gyroscopes"),
    "accelerometer_{}_m_s2": ("Accelerometer", "Calibrated/Accelerometers"),
}


def read_apdm(path: Path, segment: str) -> ArrayTable:
    """Read one sensor of an APDM file.

    Parameters
    ----------
    path : pathlib.Path
        HDF5 file.
    segment : str
        Segment whose sensor is read, by the sensor's label; of a file with a single sensor, any.

    Returns
    -------
    ArrayTable
        ``time_us``, ``gyroscope_x_rad_s``, ..., ``accelerometer_x_m_s2``, ...

    Raises
    ------
    RecordingError
        If it is no such file, or no or several sensors have the segment's label.
    UserError
        If h5py is not installed.
    """
    try:
        import h5py
    except ImportError:
        raise UserError(f"{path}: HDF5 needs h5py: pip install 'narx-orientation[apdm]'") from None
    try:
        with h5py.File(regular_file(path), "r") as file:
            sensors = _sensors(file)
            label, sensor = _chosen(path, sensors, segment)
            check_memory(path, 8 * 7 * 3 * int(sensor["Time"].size))
            columns: dict[str, FloatArray] = {"time_us": _counted(sensor["Time"])}
            for name, places in _DATASETS.items():
                values = _numbers(next(sensor[one] for one in places if one in sensor), 2)
                for axis, column in zip(AXES, values.T, strict=True):
                    columns[name.format(axis)] = np.asarray(column, dtype=np.float64)
    # a group may be data in a damaged file, and the other way round
    except (OSError, LookupError, StopIteration, ValueError, RuntimeError, TypeError,
            AttributeError) as error:  # fmt: skip
        reason = str(error).strip().splitlines()[0] if str(error).strip() else "samples missing"
        raise RecordingError(f"{path}: not a whole HDF5 file of APDM ({reason})") from None
    if len({len(values) for values in columns.values()}) > 1:
        found = ", ".join(f"{len(values)} of {name}" for name, values in columns.items())
        raise RecordingError(f"{path}: arrays of one length expected, found {found}")
    names = tuple(columns)
    table = ArrayTable(path, names, lambda k: pd.Series(columns[names[k]]))
    table.notes = (f"APDM: sensor '{label}'",)
    return table


def _sensors(file: Any) -> list[tuple[str, Any]]:
    """Labels and groups of the sensors."""
    if "Sensors" in file:
        return [
            (_text(group["Configuration"].attrs["Label 0"]), group)
            for group in file["Sensors"].values()
        ]
    cases = [_text(one) for one in file.attrs["CaseIdList"]]
    labels = [_text(one) for one in file.attrs["MonitorLabelList"]]
    return [(label, file[case]) for case, label in zip(cases, labels, strict=True)]


def _chosen(path: Path, sensors: list[tuple[str, Any]], segment: str) -> tuple[str, Any]:
    fitting = [one for one in sensors if segment_of(one[0]) == segment]
    if len(sensors) == 1:
        return sensors[0]
    if len(fitting) != 1:
        labels = ", ".join(f"'{label}'" for label, _ in sensors) or "none"
        raise RecordingError(
            f"{path}: {len(fitting)} sensors for '{segment}', expected one; labels: {labels}"
        )
    return fitting[0]


def _numbers(data: Any, dimensions: int) -> Any:
    values = np.asarray(data)
    if values.dtype.kind not in "iuf" or values.ndim != dimensions:
        raise ValueError(
            f"{data.name} is of type {values.dtype} and shape {values.shape}, expected numbers "
            f"in {dimensions} dimensions"
        )
    return values


def _counted(times: Any) -> FloatArray:
    """Times from the first: microseconds since 1970 exceed the digits of a float of seconds."""
    counts = _numbers(times, 1)
    if np.isinf(counts).any():
        raise ValueError(f"{times.name} has an infinite number")
    return np.asarray(counts - counts[:1], dtype=np.float64)


def _text(value: Any) -> str:
    text = value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)
    return text.strip("\0 ")
