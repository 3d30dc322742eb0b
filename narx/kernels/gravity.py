"""Gravity in one accelerometer sample, in plain arithmetic with countable operations."""

from typing import Any

import numpy as np


def tilt(frontal: Any, x: Any, y: Any, z: Any) -> Any:
    """Tilt of the frontal or of the sagittal axis, rad, from the specific force.

    ``atan2(-y, sqrt(x^2 + z^2))`` or ``atan2(x, z)``, with x forward, y left and z up, in any unit;
    as `narx.kinematics.segment_angles.tilt_from_specific_force`.
    """
    return np.arctan2(-y, np.sqrt(x * x + z * z)) if frontal else np.arctan2(x, z)


def gravity_alone(x: float, y: float, z: float, low: float, high: float) -> bool:
    """Abhayasinghe et al., eq. (1), squared to avoid the square root."""
    norm_squared = x * x + y * y + z * z
    return low < norm_squared < high
