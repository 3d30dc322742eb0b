"""Headings of thigh and shank from the knee, seen by both sensors over a walk.

Which way a sensor faces about the long axis of its segment is what gravity does not tell. An error
there turns the axis about which the knee is said to flex, and the knee's 60 degrees of flexion then
show up as abduction ('cross-talk'). Baker et al. (Hum Mov Sci 18:655, 1999) turn the thigh until
knee abduction varies least over the walk; here thigh and shank are turned, since each sensor has a
heading of its own, and what the calibration said before is weighed in.
"""

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from narx.anatomical_frame import walking_band
from narx.joint_angles import grood_suntay
from narx.recording import FloatArray
from narx.segment_angles import orientation_from_angles
from narx.start_up import StartUp

# how much a knee abducts and adducts over a stride, root mean square: order of what bone pins
# show (Lafortune et al., J Biomech 25:347, 1992: 5 degrees from stance to swing)
ABDUCTION_DEG = 2.0
# errors of the headings that thigh and shank find in their own walk (docs/recordings.md)
HEADING_SD_DEG = (5.0, 10.0)
# two slow strides
MIN_STRIDES_S = 3.0
# drift of the integrated gyroscope stays below a degree or two, and strides are many enough
MAX_WALK_S = 60.0
# walking is below 10 Hz
_RATE_HZ = 50.0


def knee_headings(
    thigh_rad_s: FloatArray,
    shank_rad_s: FloatArray,
    sampling_rate_hz: float,
    heading_sd_deg: tuple[float, float] = HEADING_SD_DEG,
) -> FloatArray:
    """Find by how much thigh and shank must be turned for the knee to abduct least.

    Parameters
    ----------
    thigh_rad_s, shank_rad_s : ndarray, shape (N, 3)
        Rates about the clinical axes (`narx.segment_angles.axis_rates`) in the frames found so
        far, without bias and without a gap, rad/s, of a walk that starts in the calibration
        posture.
    sampling_rate_hz : float
        Samples per second.
    heading_sd_deg : tuple of (float, float)
        Standard deviation of the errors of the headings of thigh and shank so far, degrees.

    Returns
    -------
    ndarray, shape (2,)
        Turns about z of the (mirrored) anatomical frames of thigh and shank, rad: vectors in the
        better frame are those in the frame so far, turned by this.

    Notes
    -----
    Least squares: the knee's abduction at 0.5-10 Hz against `ABDUCTION_DEG`, all of the walk
    counting as one observation since its strides are alike, and both turns against
    `heading_sd_deg`. The latter keeps a knee that does abduct with its flexion from being
    straightened, and the answer from running along the valley in which turns of thigh and shank
    nearly cancel.
    """
    every = max(1, int(sampling_rate_hz / _RATE_HZ))
    thigh, shank = (
        _integrated(rates, sampling_rate_hz)[::every] for rates in (thigh_rad_s, shank_rad_s)
    )

    def residual(turns_rad: FloatArray) -> FloatArray:
        knee = grood_suntay(
            *(
                # the calibration posture is zero in any frame, so a turn acts on both sides
                (turn * orientation * turn.inv()).as_quat(scalar_first=True)
                for turn, orientation in zip(
                    Rotation.from_euler("Z", turns_rad[:, None]), (thigh, shank), strict=True
                )
            )
        )
        abduction = np.degrees(walking_band(knee[:, 1:2], sampling_rate_hz / every)[:, 0])
        return np.concatenate(
            [
                abduction / (ABDUCTION_DEG * np.sqrt(len(abduction))),
                np.degrees(turns_rad) / heading_sd_deg,
            ]
        )

    return np.asarray(least_squares(residual, np.zeros(2), diff_step=1e-3, x_scale=0.1).x)


def _integrated(axis_rates_rad_s: FloatArray, sampling_rate_hz: float) -> Rotation:
    """Orientation from the gyroscope alone, from a start at zero."""
    start_up = StartUp(duration_s=np.inf)
    begun = start_up.begin(np.zeros(3))
    angles = start_up.run(axis_rates_rad_s, 1.0 / sampling_rate_hz, begun)
    return Rotation.from_quat(orientation_from_angles(angles), scalar_first=True)
