"""Frames, signs, rotations; angles of segments and joints."""

from narx.kinematics.joint_angles import grood_suntay, joint_angles
from narx.kinematics.segment_angles import (
    AXES,
    angles_from_orientation,
    axis_rates,
    coupled_rates,
    orientation_from_angles,
)
from narx.kinematics.strapdown import strapdown_orientation

__all__ = [
    "AXES",
    "angles_from_orientation",
    "axis_rates",
    "coupled_rates",
    "grood_suntay",
    "joint_angles",
    "orientation_from_angles",
    "strapdown_orientation",
]
