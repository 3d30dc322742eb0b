"""Output of an optical system for a segment: markers on skin, manually placed landmarks, gaps."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose
from narx.simulation.skeleton import SkeletonMotion
from narx.simulation.soft_tissue import MARKER_GAIN, SoftTissue, draw_soft_tissue
from narx.types import FloatArray

# errors of the frame's axes about x, y, z: misplaced landmarks rotate the knee's axis by some
# degrees about the long axis (Della Croce et al., Gait & Posture 21:226, 2005), here at the lower
# end: one trained examiner
FRAME_SD_DEG = (1.0, 1.0, 2.0)
# orientation noise of a cluster: 0.2 mm of marker noise over some 0.1 m
NOISE_SD_DEG = 0.1
# occlusions of a segment: how often and how long (assumed)
GAPS_PER_MINUTE = 1.0
GAP_MEAN_S = 0.2


@dataclass(frozen=True)
class Markers:
    """Markers of one segment in one session.

    Parameters
    ----------
    tissue : SoftTissue
        Soft tissue under the markers.
    frame : scipy.spatial.transform.Rotation
        From the frame that the landmarks define to the anatomical frame.
    """

    tissue: SoftTissue
    frame: Rotation


def draw_markers(rng: np.random.Generator, segment: str, skin: Mapping[str, FloatArray]) -> Markers:
    """Draw the markers of one segment.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    segment : str
        Segment.
    skin : mapping of str to ndarray, shape (3, 3)
        Tissue motion shared with a sensor on the segment, as from `draw_skin`.

    Returns
    -------
    Markers
        The same throughout a session.
    """
    tissue = draw_soft_tissue(rng, segment, MARKER_GAIN, skin, wobbles=False)
    return Markers(tissue, Rotation.from_rotvec(np.radians(FRAME_SD_DEG) * rng.standard_normal(3)))


def track(
    markers: Markers, motion: SkeletonMotion, segment: str, keep: slice, rng: np.random.Generator
) -> FloatArray:
    """Track a segment.

    Parameters
    ----------
    markers : Markers
        Its markers.
    motion : SkeletonMotion
        Motion of the segments.
    segment : str
        Segment.
    keep : slice
        Samples of the motion's clock to report.
    rng : numpy.random.Generator
        Source of randomness.

    Returns
    -------
    ndarray, shape (n, 4)
        Quaternions w, x, y, z from the landmarks' frame to the global frame, relative to the
        calibration posture; rows of NaN where markers are hidden.
    """
    time = motion.time_s[keep]
    noise = Rotation.from_rotvec(np.radians(NOISE_SD_DEG) * rng.standard_normal((len(time), 3)))
    tissue = markers.tissue.rotation(motion)[keep]
    # both frames are the identity in the calibration posture
    tracked = compose(
        markers.frame.inv(), motion.orientations[segment][keep], tissue, markers.frame, noise
    )
    quaternion = np.asarray(tracked.as_quat(scalar_first=True))
    length = time[-1] - time[0]
    n_gaps = rng.poisson(GAPS_PER_MINUTE * length / 60.0)
    starts = time[0] + length * rng.random(n_gaps)
    for start, duration in zip(starts, rng.exponential(GAP_MEAN_S, n_gaps), strict=True):
        quaternion[(time >= start) & (time < start + duration)] = np.nan
    return quaternion
