"""Soft tissue between bone and an instrument strapped or glued to the skin.

The tissue rotates with the angles of the adjacent joints (Camomilla et al., J Biomech 46:625-630,
2013; Bonci et al., J Biomech 47:2354, 2014), so the artefact is zero in the calibration posture,
repeats with the stride and grows with the movement; heel strikes add a damped oscillation.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.simulation.skeleton import SkeletonMotion
from narx.types import FloatArray

# standard deviation of the tissue's rotation per angle of the joint, about each anatomical axis
# (x, y, z); sizes and sources: docs/simulator.md
SENSOR_GAIN = {"pelvis": (0.03, 0.03, 0.03), "thigh": (0.04, 0.04, 0.04), "shank": (0.02,) * 3}
MARKER_GAIN = {
    "pelvis": (0.03, 0.03, 0.03),
    "thigh": (0.04, 0.05, 0.10),
    "shank": (0.02, 0.025, 0.05),
}
# a strap and the markers beside it are on the same muscle: this share of the variance is common
SHARED_VARIANCE = 0.5

_ADJACENT = {"pelvis": ("pelvis",), "thigh": ("hip", "knee"), "shank": ("knee",)}

# wobble of a strapped sensor: degrees per m/s^2 of impact, damped within some hundredths of a s
WOBBLE_RAD_PER_M = 20.0


@dataclass(frozen=True)
class SoftTissue:
    """Motion of the soft tissue of one segment of one person under one instrument.

    Parameters
    ----------
    segment : str
        Segment.
    gains : dict of str to ndarray, shape (3, 3)
        By adjacent joint: rotation vector of the tissue = gain @ joint angles.
    wobble_axis : ndarray, shape (3,)
        Rotation vector per metre of impact displacement.
    """

    segment: str
    gains: dict[str, FloatArray]
    wobble_axis: FloatArray

    def rotation(self, motion: SkeletonMotion) -> Rotation:
        """Rotation of the instrument relative to the bone.

        Parameters
        ----------
        motion : SkeletonMotion
            Motion of the segments.

        Returns
        -------
        scipy.spatial.transform.Rotation
            N rotations from the instrument on the skin to the anatomical frame.
        """
        vector = np.zeros((len(motion.time_s), 3))
        for joint, gain in self.gains.items():
            vector += np.einsum("nj,ij->ni", motion.joint_angles[joint], gain)
        if self.segment in motion.impact_m:
            vector += motion.impact_m[self.segment][:, 2:] * self.wobble_axis
        return Rotation.from_rotvec(vector)

    def still(self) -> "SoftTissue":
        """Return tissue that does not move.

        Returns
        -------
        SoftTissue
            Of the same segment.
        """
        none = {joint: 0.0 * gain for joint, gain in self.gains.items()}
        return SoftTissue(self.segment, none, 0.0 * self.wobble_axis)


def draw_skin(rng: np.random.Generator, segment: str) -> dict[str, FloatArray]:
    """Draw the motion of a segment's tissue that all instruments on it share.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    segment : str
        Segment.

    Returns
    -------
    dict of str to ndarray, shape (3, 3)
        By adjacent joint: gains of unit variance.
    """
    kind, _, side = segment.partition("_")
    joints = [joint if joint == "pelvis" else f"{joint}_{side}" for joint in _ADJACENT[kind]]
    return {joint: rng.standard_normal((3, 3)) for joint in joints}


def draw_soft_tissue(
    rng: np.random.Generator,
    segment: str,
    gain: Mapping[str, tuple[float, ...]],
    skin: Mapping[str, FloatArray],
    wobbles: bool,
) -> SoftTissue:
    """Draw the tissue of one segment under one instrument.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    segment : str
        Segment.
    gain : mapping of str to tuple of float
        Standard deviations as in `SENSOR_GAIN`.
    skin : mapping of str to ndarray, shape (3, 3)
        Motion shared by all instruments on the segment, as from `draw_skin`.
    wobbles : bool
        Whether the instrument is heavy enough to oscillate after an impact.

    Returns
    -------
    SoftTissue
        Constant over a session.
    """
    spread = np.array(gain[segment.partition("_")[0]])[:, None]
    own, common = np.sqrt(1.0 - SHARED_VARIANCE), np.sqrt(SHARED_VARIANCE)
    return SoftTissue(
        segment,
        {
            joint: spread * (common * shared + own * rng.standard_normal((3, 3)))
            for joint, shared in skin.items()
        },
        WOBBLE_RAD_PER_M * rng.standard_normal(3) * wobbles,
    )
