"""The part of a recording in which the wearer walks straight on, from gyroscopes alone."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from narx.types import FloatArray

# a stride's own turning averages out over about a stride
_STRIDE_S = 1.0
# a turn, and not the drift of the integral: so much within so short a time
_TURN_RAD, _TURN_S = np.radians(20.0), 2.0
_MIN_WALK_S = 3.0


def straight_walk_s(
    gyroscopes_rad_s: Sequence[FloatArray],
    up: Sequence[FloatArray],
    sampling_rate_hz: float,
    begin_s: float,
) -> tuple[float, float] | None:
    """Find the walk from the first step to the first turn.

    Parameters
    ----------
    gyroscopes_rad_s : sequence of ndarray, shape (N, 3)
        Angular rates of sensors on one clock, without bias, rad/s; NaN where missing.
    up : sequence of ndarray, shape (3,)
        Direction of up in each sensor while standing, unit vectors.
    sampling_rate_hz : float
        Samples per second.
    begin_s : float
        Time from the first sample at which the rest at the start ends, s.

    Returns
    -------
    tuple of (float, float) or None
        Seconds from the first sample; None where the heading (mean of the sensors, averaged
        over a second) never changes by 20 degrees within two seconds, or does so within three
        seconds of the begin.
    """
    turning = np.mean(
        [np.nan_to_num(rate) @ axis for rate, axis in zip(gyroscopes_rad_s, up, strict=True)],
        axis=0,
    )
    begin = round(begin_s * sampling_rate_hz)
    heading = np.cumsum(turning) / sampling_rate_hz
    smooth = uniform_filter1d(heading, max(1, round(_STRIDE_S * sampling_rate_hz)), mode="nearest")
    walked = smooth[begin:]
    lag = round(_TURN_S * sampling_rate_hz)
    earlier = np.r_[np.full(min(lag, len(walked)), walked[0]), walked[:-lag]][: len(walked)]
    turned = np.flatnonzero(np.abs(walked - earlier) > _TURN_RAD)
    if not turned.size or turned[0] < _MIN_WALK_S * sampling_rate_hz:
        return None
    return begin / sampling_rate_hz, (begin + int(turned[0])) / sampling_rate_hz
