"""Soft tissue between bone and what is strapped or glued to the skin.

The tissue turns with the angles of the adjacent joints (Camomilla et al., J Biomech 46:625-630,
2013; Bonci et al., J Biomech 47:2354, 2014), so the artefact is zero in the calibration posture,
repeats with the stride and grows with the movement; after a heel strike it wobbles.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from narx.simulation.skeleton import SkeletonMotion

FloatArray = NDArray[np.float64]

# standard deviation of the tissue's rotation per angle of the joint, about each anatomical axis
# (x, y, z). In walking this makes, RMS about x, y, z, some (1.7, 1.7, 1.1) deg on the thigh and
# (0.8, 0.7, 0.5) on the shank for strapped sensors, (1.4, 1.4, 3.7) and (0.4, 0.6, 1.1) for skin
# markers, the order of Leardini et al., Gait & Posture 21:212, 2005; Benoit et al., Gait &
# Posture 24:152, 2006; Barre et al., IEEE Trans Biomed Eng 60:3131, 2013.
SENSOR_GAIN = {"pelvis": (0.03, 0.03, 0.03), "thigh": (0.06, 0.06, 0.06), "shank": (0.03,) * 3}
MARKER_GAIN = {
    "pelvis": (0.03, 0.03, 0.03),
    "thigh": (0.06, 0.06, 0.12),
    "shank": (0.03, 0.03, 0.06),
}

_ADJACENT = {"pelvis": ("pelvis",), "thigh": ("hip", "knee"), "shank": ("knee",)}

# wobble of a strapped sensor: degrees per m/s^2 of impact, damped within some hundredths of a s
WOBBLE_RAD_PER_M = 20.0


@dataclass(frozen=True)
class SoftTissue:
    """How the tissue of one segment of one person gives way under one instrument.

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
        """Turn of the instrument relative to the bone.

        Parameters
        ----------
        motion : SkeletonMotion
            Motion of the segments.

        Returns
        -------
        scipy.spatial.transform.Rotation
            N rotations from the instrument's place on the skin to the anatomical frame.
        """
        vector = np.zeros((len(motion.time_s), 3))
        for joint, gain in self.gains.items():
            vector += np.einsum("nj,ij->ni", motion.joint_angles[joint], gain)
        if self.segment in motion.impact_m:
            vector += motion.impact_m[self.segment][:, 2:] * self.wobble_axis
        return Rotation.from_rotvec(vector)


def draw_soft_tissue(
    rng: np.random.Generator, segment: str, gain: Mapping[str, tuple[float, ...]], wobbles: bool
) -> SoftTissue:
    """Draw the tissue of one segment.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    segment : str
        Segment.
    gain : mapping of str to tuple of float
        Standard deviations as in `SENSOR_GAIN`.
    wobbles : bool
        Whether the instrument has the mass to swing after an impact.

    Returns
    -------
    SoftTissue
        The same throughout a session.
    """
    kind, _, side = segment.partition("_")
    spread = np.array(gain[kind])[:, None]
    joints = [joint if joint == "pelvis" else f"{joint}_{side}" for joint in _ADJACENT[kind]]
    return SoftTissue(
        segment,
        {joint: spread * rng.standard_normal((3, 3)) for joint in joints},
        WOBBLE_RAD_PER_M * rng.standard_normal(3) * wobbles,
    )
