"""The gyroscope's static bias, from the parts in which the sensor was at rest."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from narx.recordings.trial import Trial
from narx.types import FloatArray

# length of a window, s: averages out noise and sway, and excludes handling of the sensor
WINDOW_S = 5.0
# a sensor on a table does not turn, so a (smoothed) rate above this indicates handling
HANDLING_RAD_S = np.radians(2.0)
HANDLING_MARGIN_S = 0.5


@dataclass(frozen=True)
class StillPart:
    """A part of a recording in which the sensor did not turn.

    Parameters
    ----------
    where : str
        Part of the recording, for messages.
    bias_rad_s : ndarray, shape (3,)
        Mean of the gyroscope in the sensor frame, rad/s.
    gyroscope_scatter_rad_s : float
        Root mean square deviation from that mean, rad/s.
    """

    where: str
    bias_rad_s: FloatArray
    gyroscope_scatter_rad_s: float


def quietest_window(
    gyroscope_rad_s: FloatArray, sampling_rate_hz: float, where: str, window_s: float = WINDOW_S
) -> StillPart | None:
    """Find the window with the least variation in a part that should be still.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate in the sensor frame, rad/s; samples with NaN are left out.
    sampling_rate_hz : float
        Samples per second.
    where : str
        Name of the part.
    window_s : float
        Length of the window, s.

    Returns
    -------
    StillPart or None
        Mean over the window (or over the whole part, if shorter) in which the rate varies
        least; None without a sample.
    """
    rate = gyroscope_rad_s[np.isfinite(gyroscope_rad_s).all(axis=1)]
    if not len(rate):
        return None
    length = min(len(rate), max(1, round(window_s * sampling_rate_hz)))
    # a shifted origin keeps the difference of two running sums exact
    origin = rate.mean(axis=0)
    shifted = rate - origin
    sums = np.vstack([np.zeros(6), np.cumsum(np.hstack([shifted, shifted**2]), axis=0)])
    means = (sums[length:] - sums[:-length]) / length
    variance = np.maximum(means[:, 3:] - means[:, :3] ** 2, 0.0).sum(axis=1)
    best = int(np.argmin(variance))
    return StillPart(where, means[best, :3] + origin, float(np.sqrt(variance[best])))


def resting_mean(
    gyroscope_rad_s: FloatArray, sampling_rate_hz: float, where: str
) -> StillPart | None:
    """Average a recording of a sensor at rest, without the handling at its start and end.

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
        Mean over all samples except those within `HANDLING_MARGIN_S` of a rate (averaged over a
        tenth of a second) that is more than `HANDLING_RAD_S` off its median; None without one.
    """
    rate = gyroscope_rad_s[np.isfinite(gyroscope_rad_s).all(axis=1)]
    if not len(rate):
        return None
    tenth = max(1, round(0.1 * sampling_rate_hz))
    smooth = uniform_filter1d(rate - np.median(rate, axis=0), tenth, axis=0, mode="nearest")
    handled = np.linalg.norm(smooth, axis=1) > HANDLING_RAD_S
    margin = 2 * round(HANDLING_MARGIN_S * sampling_rate_hz) + 1
    at_rest = rate[~maximum_filter1d(handled, margin)]
    return _mean(at_rest, where) if len(at_rest) else None


def static_bias(trial: Trial, segment: str) -> StillPart | None:
    """Estimate the static gyroscope bias of one sensor.

    Parameters
    ----------
    trial : Trial
        With a ``still`` or a ``standing`` calibration recording, or `still_s`.
    segment : str
        Which sensor.

    Returns
    -------
    StillPart or None
        From the ``still`` recording, where the sensor lay at rest (`resting_mean`); without it
        from all standing parts together; None where the trial has neither.

    Notes
    -----
    A standing person sways, so the mean rate over a standing part of length T has an error of the
    angle between its ends divided by T, whatever the sensor. The whole of each part is therefore
    averaged, and parts are weighted by ``(T / scatter)^2``, the inverse of that error's variance.
    """
    recording = trial.calibration.get("still", {}).get(segment)
    if recording is not None and recording.n_samples > 1:
        still = resting_mean(
            recording.gyroscope_rad_s, recording.sampling_rate_hz, "recording 'still'"
        )
        if still is not None:
            return still
    parts: list[tuple[float, StillPart]] = []
    recording = trial.calibration.get("standing", {}).get(segment)
    if recording is not None and recording.n_samples > 1:
        parts += _standing_part(
            recording.gyroscope_rad_s, recording.sampling_rate_hz, "recording 'standing'"
        )
    time = trial.time_s
    for begin, end in trial.still_s:
        inside = (time >= begin) & (time <= end)
        parts += _standing_part(
            trial.imus[segment].gyroscope_rad_s[inside],
            trial.sampling_rate_hz,
            f"still part {begin:.1f}-{end:.1f} s",
        )
    if not parts:
        return None
    # a constant signal has no scatter; its weight is limited to a finite value
    weights = np.array(
        [(length / max(part.gyroscope_scatter_rad_s, 1e-9)) ** 2 for length, part in parts]
    )
    weights /= weights.sum()
    return StillPart(
        " and ".join(part.where for _, part in parts),
        np.asarray(weights @ np.array([part.bias_rad_s for _, part in parts])),
        float(np.sqrt(weights @ np.array([part.gyroscope_scatter_rad_s**2 for _, part in parts]))),
    )


def _standing_part(
    gyroscope_rad_s: FloatArray, sampling_rate_hz: float, where: str
) -> list[tuple[float, StillPart]]:
    """Average a standing part; return its length in s and the average, nothing if it is empty."""
    rate = gyroscope_rad_s[np.isfinite(gyroscope_rad_s).all(axis=1)]
    return [(len(rate) / sampling_rate_hz, _mean(rate, where))] if len(rate) else []


def _mean(rate_rad_s: FloatArray, where: str) -> StillPart:
    scatter = np.sqrt(rate_rad_s.var(axis=0).sum())
    return StillPart(where, np.asarray(rate_rad_s.mean(axis=0)), float(scatter))
