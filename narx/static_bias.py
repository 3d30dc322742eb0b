"""The gyroscope's static bias, from whatever the sensor was at rest in."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from narx.recording import FloatArray, Trial

# long enough to average noise and sway out, short enough that a hand on the sensor is avoided
WINDOW_S = 5.0
# standing sway and sensor noise stay below, movement does not (Han et al., gamma of eq. (3))
REST_RAD_S = np.radians(10.0)


@dataclass(frozen=True)
class StillPart:
    """A part in which the sensor did not turn.

    Parameters
    ----------
    where : str
        What it was taken from, for people.
    bias_rad_s : ndarray, shape (3,)
        Mean of the gyroscope in the sensor frame, rad/s.
    unrest_rad_s : float
        Root mean square deviation from that mean, rad/s.
    """

    where: str
    bias_rad_s: FloatArray
    unrest_rad_s: float


def quietest_window(
    gyroscope_rad_s: FloatArray, sampling_rate_hz: float, where: str
) -> StillPart | None:
    """Find the quietest window of a part that should be still.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate in the sensor frame, rad/s; samples with NaN are left out.
    sampling_rate_hz : float
        Samples per second.
    where : str
        Name of the part.

    Returns
    -------
    StillPart or None
        Mean over the `WINDOW_S` (or over the whole part, if shorter) in which the rate varies
        least; None without a sample.
    """
    rate = gyroscope_rad_s[np.isfinite(gyroscope_rad_s).all(axis=1)]
    if not len(rate):
        return None
    length = min(len(rate), max(1, round(WINDOW_S * sampling_rate_hz)))
    # a shifted origin keeps the difference of two running sums exact
    origin = rate.mean(axis=0)
    shifted = rate - origin
    sums = np.vstack([np.zeros(6), np.cumsum(np.hstack([shifted, shifted**2]), axis=0)])
    means = (sums[length:] - sums[:-length]) / length
    variance = np.maximum(means[:, 3:] - means[:, :3] ** 2, 0.0).sum(axis=1)
    best = int(np.argmin(variance))
    return StillPart(where, means[best, :3] + origin, float(np.sqrt(variance[best])))


def static_bias(trial: Trial, segment: str) -> StillPart | None:
    """Estimate the static gyroscope bias of one sensor.

    Parameters
    ----------
    trial : Trial
        Still parts are its ``still`` and ``standing`` calibration recordings and its `still_s`.
    segment : str
        Which sensor.

    Returns
    -------
    StillPart or None
        The quietest of all still parts; None where the trial has none.
    """
    parts = []
    for name in ("still", "standing"):
        recording = trial.calibration.get(name, {}).get(segment)
        if recording is not None and recording.n_samples > 1:
            parts.append(
                quietest_window(
                    recording.gyroscope_rad_s, recording.sampling_rate_hz, f"recording '{name}'"
                )
            )
    time = trial.time_s
    for begin, end in trial.still_s:
        inside = (time >= begin) & (time <= end)
        parts.append(
            quietest_window(
                trial.imus[segment].gyroscope_rad_s[inside],
                trial.sampling_rate_hz,
                f"still part {begin:.1f}-{end:.1f} s",
            )
        )
    found = [part for part in parts if part is not None]
    return min(found, key=lambda part: part.unrest_rad_s, default=None)


def first_rest_s(gyroscopes_rad_s: Sequence[FloatArray], sampling_rate_hz: float) -> float:
    """Find how long sensors are at rest at the start of a recording.

    Parameters
    ----------
    gyroscopes_rad_s : sequence of ndarray, shape (N, 3)
        Angular rates of sensors on one clock, rad/s.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    float
        Time until a tenth of a second before the first sample in which any sensor turns by more
        than 10 deg/s (averaged over a tenth of a second) beside its median over the first half
        second; 0 without a rest.
    """
    first = max(1, round(0.5 * sampling_rate_hz))
    margin = max(1, round(0.1 * sampling_rate_hz))
    ends = []
    for rate in gyroscopes_rad_s:
        if not np.isfinite(rate[:first]).all(axis=1).any():
            return 0.0
        deviation = rate - np.nanmedian(rate[:first], axis=0)
        # what is missing at rest does not end the rest
        smooth = uniform_filter1d(np.nan_to_num(deviation), margin, axis=0, mode="nearest")
        speed = np.linalg.norm(smooth, axis=1)
        moving = np.flatnonzero(speed > REST_RAD_S)
        ends.append(moving[0] if moving.size else len(rate))
    return max(0.0, float((min(ends) - 1 - margin) / sampling_rate_hz))
