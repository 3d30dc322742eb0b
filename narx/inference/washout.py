"""Washout: subtract a slow mean of the network's output, to remove the effect of bias drift.

A gyroscope's bias changes by hundredths of a degree per second within an hour, and a leak turns
that into tenths of a degree. Walking has no such slow component: the angle swings about the posture
from the start-up. The deviation of the network's output from the posture is therefore averaged with
a time constant of minutes, and that mean is subtracted::

    m_k = m_{k-1} + g (d_k - m_{k-1}),  g = interval / (washout + interval)
    angle_k = posture + d_k - m_k

with d the deviation from the posture: the backward Euler form of a first-order high-pass filter.
The mean is zero when the network takes over, so there is no jump. A constant rate has no lasting
effect. The feedback of the network, and the tilt that couples the axes, are unchanged.
"""

import numpy as np
from scipy.signal import lfilter

from narx.errors import UserError
from narx.types import FloatArray

# long compared with events in a walk (a turn, a slope, a rest), short compared with an hour
WASHOUT_S = 300.0


def washout_gain(washout_s: float | None, interval_s: float) -> float:
    """Compute the weight of a sample in the slow mean.

    Parameters
    ----------
    washout_s : float, optional
        Time constant of the mean, s; None for no washout.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    float
        0 without washout.

    Raises
    ------
    UserError
        If the time constant is not positive.
    """
    if washout_s is None:
        return 0.0
    if not (isinstance(washout_s, int | float) and np.isfinite(washout_s) and washout_s > 0):
        raise UserError(f"washout_s is {washout_s}, expected seconds above zero, or null for none")
    return interval_s / (washout_s + interval_s)


def wash_out(
    angles_rad: FloatArray, posture_rad: FloatArray, gain: float, mean_rad: FloatArray
) -> FloatArray:
    """Subtract the slow mean.

    Parameters
    ----------
    angles_rad : ndarray, shape (N, 3)
        Output of the network, no NaN.
    posture_rad : ndarray, shape (3,)
        Posture.
    gain : float
        From `washout_gain`.
    mean_rad : ndarray, shape (3,)
        Mean deviation after the previous sample, initially zero; changed in place.

    Returns
    -------
    ndarray, shape (N, 3)
        Angles, rad.
    """
    if not gain or not len(angles_rad):
        return angles_rad
    mean, _ = lfilter(
        [gain],
        [1.0, gain - 1.0],
        angles_rad - posture_rad,
        axis=0,
        zi=(1.0 - gain) * mean_rad[None],
    )
    mean_rad[:] = mean[-1]
    return np.asarray(angles_rad - mean)
