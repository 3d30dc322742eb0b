"""Write angles as C3D, the format of optical motion capture, by ezc3d."""

from pathlib import Path

import numpy as np
import pandas as pd

from narx.errors import UserError
from narx.experiments.predictions.angle_columns import angle_column
from narx.files import atomic_path
from narx.kinematics.segment_angles import AXES

# frames are counted in 16 bits
_MOST_FRAMES = 65_535
# a C3D has one rate and no time stamps
_LATEST_SAMPLES = 0.5


def write_c3d(table: pd.DataFrame, path: Path, alone: str) -> None:
    """Write each segment and joint as a point of the group ANGLES: x, y, z are the three angles.

    Standard deviations are points with ``_std`` after the name. Missing angles are invalid points
    (residual -1); `quality` is left out.

    Parameters
    ----------
    table : pandas.DataFrame
        ``time_s`` first; angles in degrees.
    path : pathlib.Path
        File to write.
    alone : str
        Name of the segment of a single sensor.

    Raises
    ------
    UserError
        If ezc3d is missing, the recording is too long, or its samples are not regular.
    """
    try:
        import ezc3d
    except ImportError as error:
        raise UserError(
            "output: C3D needs another package: pip install 'narx-orientation[c3d]'"
        ) from error
    rate_hz = _rate_hz(table["time_s"].to_numpy(), path)
    points: dict[str, list[str]] = {}
    for name in map(str, table):
        column = angle_column(name, alone)
        if column is not None:
            label = f"{column.point}_std" if column.is_std else column.point
            points.setdefault(label, [""] * len(AXES))[AXES.index(column.axis)] = name
    data = np.ones((4, len(points), len(table)))
    for k, names in enumerate(points.values()):
        data[:3, k] = table[names].to_numpy().T
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [rate_hz]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(points)
    file["parameters"]["POINT"]["UNITS"]["value"] = ["deg"]
    file.add_parameter("POINT", "ANGLES", list(points))
    file.add_parameter("POINT", "ANGLE_UNITS", "deg")
    file["data"]["points"] = data
    missing = np.isnan(data[:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(missing, -1.0, 0.0)[None]
    with atomic_path(path) as temporary:
        # ezc3d appends the suffix unless it is in small letters
        written = temporary.with_suffix(".c3d")
        file.write(str(written))
        written.replace(temporary)


def _rate_hz(time_s: np.ndarray, path: Path) -> float:
    n = len(time_s)
    if n > _MOST_FRAMES:
        raise UserError(
            f"output: '{path}': {n} samples, a C3D file holds {_MOST_FRAMES}; expected another "
            "format"
        )
    if n < 2:
        raise UserError(f"output: '{path}': {n} samples, a C3D file needs two to have a rate")
    rate_hz = float((n - 1) / (time_s[-1] - time_s[0]))
    late = np.abs((time_s - time_s[0]) * rate_hz - np.arange(n)).max()
    if late > _LATEST_SAMPLES:
        raise UserError(
            f"output: '{path}': times deviate from a constant rate by {late:.1f} samples, and a "
            "C3D file has no time stamps; expected another format"
        )
    return rate_hz
