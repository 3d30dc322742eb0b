"""Tilt of one axis from one accelerometer sample, in plain arithmetic.

The same as `narx.kinematics.segment_angles.tilt_from_specific_force`, in a form that can be
compiled by numba and run on numbers that count their operations.
"""

from typing import Any

import numpy as np

from narx.kinematics.segment_angles import FRONTAL


def tilt(axis: int, x: Any, y: Any, z: Any) -> Any:
    """Angle of a segment about one axis from the direction of gravity.

    Parameters
    ----------
    axis : int
        `narx.kinematics.segment_angles.SAGITTAL` or `FRONTAL`.
    x, y, z : float
        Specific force forward, left and up, in any unit.

    Returns
    -------
    float
        ``atan2(x, z)`` or ``atan2(-y, sqrt(x^2 + z^2))``, rad.
    """
    return np.arctan2(-y, np.sqrt(x * x + z * z)) if axis == FRONTAL else np.arctan2(x, z)
