"""The joints of a leg, from the angles of their two segments.

All joints use the same joint coordinate system (Grood and Suntay 1983, as recommended by the ISB
for hip, knee and ankle: Wu et al., J Biomech 35:543, 2002): flexion about the proximal segment's
mediolateral axis, rotation about the distal segment's long axis, abduction about the axis
perpendicular to both.
"""

from typing import NamedTuple

import numpy as np

from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import orientation_from_angles
from narx.types import FloatArray


class Joint(NamedTuple):
    """A joint between two segments.

    Parameters
    ----------
    proximal, distal : str
        Names of the segments.
    flexion_sign : float
        +1 if the distal segment swings backwards in flexion (knee), -1 if it swings forwards (hip,
        and the foot in dorsiflexion).
    """

    proximal: str
    distal: str
    flexion_sign: float


JOINTS = {
    f"{name}_{side}": Joint(proximal.format(side), distal.format(side), sign)
    for side in ("right", "left")
    for name, proximal, distal, sign in (
        ("hip", "pelvis", "thigh_{}", -1.0),
        ("knee", "thigh_{}", "shank_{}", 1.0),
        ("ankle", "shank_{}", "foot_{}", -1.0),
    )
}


def joint_between(joint: str, proximal_rad: FloatArray, distal_rad: FloatArray) -> FloatArray:
    """Compute the angles of a joint from those of its segments.

    Parameters
    ----------
    joint : str
        Key of `JOINTS`.
    proximal_rad, distal_rad : ndarray, shape (N, 3)
        Segment angles with the reported signs; those of a pelvis as for a right leg.

    Returns
    -------
    ndarray, shape (N, 3)
        Flexion (dorsiflexion of the ankle), abduction and internal rotation, rad; NaN where a
        segment is missing.
    """
    definition = JOINTS[joint]
    proximal = proximal_rad
    if definition.proximal == "pelvis" and joint.endswith("_left"):
        # the left leg is mirrored through the sagittal plane, the pelvis was not
        proximal = proximal_rad * [1.0, -1.0, -1.0]
    angles = grood_suntay(orientation_from_angles(proximal), orientation_from_angles(distal_rad))
    return np.asarray(angles * [definition.flexion_sign, 1.0, 1.0])
