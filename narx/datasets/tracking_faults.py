"""Faults of optical tracking: lost poses, poses that are none, and spikes."""

import numpy as np
from scipy.spatial.transform import Rotation

from narx.errors import RecordingError
from narx.types import FloatArray

# a body that turns this many times faster than its gyroscope measures is a tracking fault
_SPIKE_FACTOR = 2.0
_SPIKE_MAX_S = 0.2
# length of a quaternion that stands for a lost pose, and largest deviation from 1 of any other
_LOST_POSE, _UNIT_TOLERANCE = 1e-6, 0.1


def tracked_poses(
    segment: str, time_s: FloatArray, body_wxyz: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Check the poses of a tracked body.

    Parameters
    ----------
    segment : str
        Its name, for messages.
    time_s : ndarray, shape (K,)
        The reference's clock, s.
    body_wxyz : ndarray, shape (K, 4)
        Orientation; NaN where missing.

    Returns
    -------
    body_wxyz : ndarray, shape (K, 4)
        NaN also where all four numbers are zero, as some systems write a lost pose.
    notes : list of str
        Number of those, if any.

    Raises
    ------
    RecordingError
        If time does not increase, or an orientation is no unit quaternion.
    """
    back = np.flatnonzero(~(np.diff(time_s) > 0))
    if back.size:
        k = int(back[0])
        raise RecordingError(
            f"'{segment}': the reference's time does not increase at its sample {k + 2} "
            f"({time_s[k]:g} s, then {time_s[k + 1]:g} s)"
        )
    with np.errstate(over="ignore"):  # an infinite length is refused below
        length = np.linalg.norm(body_wxyz, axis=1)
    lost = length < _LOST_POSE
    wrong = np.flatnonzero(~lost & (np.abs(length - 1.0) > _UNIT_TOLERANCE))
    if wrong.size:
        k = int(wrong[0])
        raise RecordingError(
            f"'{segment}': the orientation at the reference's sample {k + 1} has length "
            f"{length[k]:.3g}, expected a unit quaternion"
        )
    if not lost.any():
        return body_wxyz, []
    return np.where(lost[:, None], np.nan, body_wxyz), [
        f"{segment}: {lost.sum()} optical samples of zeros are lost poses, taken as missing"
    ]


def without_spikes(
    time_s: FloatArray, quaternion_wxyz: FloatArray, fastest_rad_s: float
) -> tuple[FloatArray, int]:
    """Remove tracking faults from an orientation.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    quaternion_wxyz : ndarray, shape (N, 4)
        Orientation; NaN where missing.
    fastest_rad_s : float
        Highest rate of the gyroscope, rad/s.

    Returns
    -------
    quaternion_wxyz : ndarray, shape (N, 4)
        A copy with NaN where samples lie between two jumps (turns faster than twice the
        gyroscope's fastest) less than 0.2 s apart.
    removed : int
        Number of samples removed.
    """
    cleaned = quaternion_wxyz.copy()
    valid = np.flatnonzero(np.isfinite(cleaned).all(axis=1))
    if valid.size < 2:
        return cleaned, 0
    rotation = Rotation.from_quat(cleaned[valid], scalar_first=True)
    interval = np.diff(time_s[valid])
    speed = (rotation[:-1].inv() * rotation[1:]).magnitude() / interval
    runs = np.split(valid, np.flatnonzero(speed > _SPIKE_FACTOR * fastest_rad_s) + 1)
    if len(runs) == 1:
        return cleaned, 0
    short = [run for run in runs if time_s[run[-1]] - time_s[run[0]] < _SPIKE_MAX_S]
    for run in short:
        cleaned[run] = np.nan
    return cleaned, sum(run.size for run in short)
