"""The straight walk in a recording, detected from gyroscopes only."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from narx.recordings.trial import Trial
from narx.types import FloatArray

# averaging time, s: turning within a stride cancels over about one stride
_STRIDE_S = 1.0
# a turn is a change of heading by this much within this time; drift is slower
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
        Upward direction in each sensor frame during standing, unit vectors.
    sampling_rate_hz : float
        Samples per second.
    begin_s : float
        Time from the first sample at which the rest at the start ends, s.

    Returns
    -------
    tuple of (float, float) or None
        Start and end in s from the first sample; None if the heading (mean of the sensors,
        averaged over a second) never changes by 20 degrees within two seconds, or already does so
        within three seconds after `begin_s`.
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


def walk_before_turn_s(trial: Trial, stand_s: tuple[float, float]) -> tuple[float, float] | None:
    """Find the walk from the end of standing to the first turn, from the trial's sensors only.

    Parameters
    ----------
    trial : Trial
        Sensors on one clock.
    stand_s : tuple of (float, float)
        Standing before the walk, on the trial's clock, s: gives bias and vertical of each sensor.

    Returns
    -------
    tuple of (float, float) or None
        Start and end in s on the trial's clock; None if no turn is found, or a sensor has no
        samples during standing.
    """
    inside = (trial.time_s >= stand_s[0]) & (trial.time_s <= stand_s[1])
    rates, up = [], []
    for imu in trial.imus.values():
        still, force = imu.gyroscope_rad_s[inside], imu.accelerometer_m_s2[inside]
        if not np.isfinite(still + force).all(axis=1).any():
            return None
        mean = np.nanmean(force, axis=0)
        rates.append(imu.gyroscope_rad_s - np.nanmean(still, axis=0))
        up.append(mean / np.linalg.norm(mean))
    begin = float(trial.time_s[0])
    found = straight_walk_s(rates, up, trial.sampling_rate_hz, stand_s[1] - begin)
    return None if found is None else (found[0] + begin, found[1] + begin)
