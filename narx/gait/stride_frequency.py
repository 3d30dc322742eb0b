"""Cadence from a thigh's or shank's sagittal gyroscope: over a whole walk, or causally.

Everything here uses one axis, the rate about the sagittal axis of a leg segment, because
that axis carries the swing: one large positive lobe per stride. Times and frequencies are in
physical units, so a recording may have any sampling rate.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft, signal

from narx.kernels.stride import MINIMUM_RMS_RAD_S, TrackerState, track, track_all
from narx.types import FloatArray

# from a very slow, cautious gait (Parkinson's disease, 0.5 strides/s) to sprinting (1.7)
STRIDE_FREQUENCY_RANGE_HZ = (0.4, 1.8)

# sampling rate that is sufficient for a stride frequency accurate to a thousandth
_ENOUGH_HZ = 100.0


def stride_frequency_hz(
    sagittal_rate_rad_s: ArrayLike,
    sampling_rate_hz: float,
    frequency_range_hz: tuple[float, float] = STRIDE_FREQUENCY_RANGE_HZ,
    minimum_correlation: float = 0.4,
) -> float:
    """Estimate the stride frequency of a recording from its autocorrelation.

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate of a thigh or shank about its sagittal axis, rad/s; NaN where missing.
    sampling_rate_hz : float
        Sampling rate.
    frequency_range_hz : tuple of (float, float)
        Lowest and highest stride frequency considered.
    minimum_correlation : float
        Autocorrelation that one stride must have with the next for the signal to count as
        walking.

    Returns
    -------
    float
        Strides per second (half the cadence in steps per second); NaN where no walking is
        found.

    Notes
    -----
    The autocorrelation repeats at twice, three times ... the stride time, nearly as high; the
    first maximum that comes within 15 % of the highest is the stride. It is computed over pairs of
    valid samples, so gaps neither add nor remove periods.
    """
    block = max(1, int(sampling_rate_hz / _ENOUGH_HZ))
    rate = _block_means(np.asarray(sagittal_rate_rad_s, dtype=float), block)
    sampling_rate_hz = sampling_rate_hz / block
    valid = np.isfinite(rate)
    shortest = sampling_rate_hz / frequency_range_hz[1]
    longest = sampling_rate_hz / frequency_range_hz[0]
    if valid.sum() < 2 * shortest or shortest < 2:
        return float("nan")
    centred = np.where(valid, rate - rate[valid].mean(), 0.0)
    power = float(centred @ centred) / int(valid.sum())
    if np.sqrt(power) < MINIMUM_RMS_RAD_S:
        return float("nan")
    lags = np.arange(min(len(rate), int(np.ceil(longest)) + 2))
    products = _autocorrelation(centred, len(lags))
    pairs = len(rate) - lags if valid.all() else _autocorrelation(valid.astype(float), len(lags))
    # a lag covered by few pairs is unreliable
    covered = pairs > 0.25 * valid.sum()
    correlation = np.where(covered, products / np.maximum(pairs, 1.0) / power, 0.0)
    peaks, _ = signal.find_peaks(correlation)
    peaks = peaks[(peaks >= shortest) & (peaks <= longest)]
    if not peaks.size or correlation[peaks].max() < minimum_correlation:
        return float("nan")
    peak = int(peaks[correlation[peaks] >= 0.85 * correlation[peaks].max()][0])
    return sampling_rate_hz / (peak + _parabola_vertex(correlation[peak - 1 : peak + 2]))


def _block_means(values: FloatArray, block: int) -> FloatArray:
    """Means of consecutive samples; NaN where one of them is NaN."""
    return values[: len(values) // block * block].reshape(-1, block).mean(axis=1)


def _autocorrelation(values: FloatArray, n_lags: int) -> FloatArray:
    length = fft.next_fast_len(len(values) + n_lags, real=True)
    return fft.irfft(np.abs(fft.rfft(values, length)) ** 2, length)[:n_lags]


def _parabola_vertex(three: FloatArray) -> float:
    """Position of the maximum of a parabola through samples at -1, 0 and 1."""
    left, middle, right = three
    curvature = left - 2.0 * middle + right
    return 0.0 if curvature == 0.0 else float(0.5 * (left - right) / curvature)


@dataclass(frozen=True)
class StrideFrequencyTracker:
    """Tracks the stride frequency causally, one sample of the sagittal rate at a time.

    A stride ends when the low-passed rate rises above half its running root mean square after
    having been below zero: the swing of a thigh or shank is one large positive lobe, so this
    happens once a stride. The frequency is the inverse of an exponential average of stride
    times.

    Parameters
    ----------
    start_frequency_hz : float
        Value returned until the first stride has been detected.
    frequency_range_hz : tuple of (float, float)
        Strides outside are treated as pauses or disturbances and left out.
    low_pass_hz : float
        Cut-off of the first-order low-pass filter before the crossing detector; it delays all
        crossings by about the same time, so stride times stay right.
    rms_time_s : float
        Time constant of the running mean square.
    smoothing : float
        Weight of a new stride time in the average, in (0, 1].
    """

    start_frequency_hz: float = 0.9
    frequency_range_hz: tuple[float, float] = STRIDE_FREQUENCY_RANGE_HZ
    low_pass_hz: float = 3.0
    rms_time_s: float = 3.0
    smoothing: float = 0.3

    def start(self, sampling_rate_hz: float) -> Callable[[float], float]:
        """Start tracking a walk.

        Parameters
        ----------
        sampling_rate_hz : float
            Sampling rate.

        Returns
        -------
        callable
            ``step(sagittal_rate_rad_s) -> stride frequency in Hz``.
        """
        return _Following(self._first_state(), self._constants(sampling_rate_hz))

    def follow(self, sagittal_rate_rad_s: ArrayLike, sampling_rate_hz: float) -> FloatArray:
        """Track a whole recording, with the same results as sample by sample.

        Parameters
        ----------
        sagittal_rate_rad_s : array_like, shape (N,)
            Rate about the sagittal axis, rad/s, without missing samples.
        sampling_rate_hz : float
            Sampling rate.

        Returns
        -------
        ndarray, shape (N,)
            Stride frequency in Hz estimated up to each sample.
        """
        rate = np.ascontiguousarray(sagittal_rate_rad_s, dtype=float)
        return track_all(rate, self._first_state(), self._constants(sampling_rate_hz))

    def _first_state(self) -> TrackerState:
        return 0.0, 0.0, 1.0 / self.start_frequency_hz, np.inf, False, False

    def _constants(self, sampling_rate_hz: float) -> tuple[float, ...]:
        interval_s = 1.0 / sampling_rate_hz
        return (
            interval_s,
            float(1.0 - np.exp(-2.0 * np.pi * self.low_pass_hz * interval_s)),
            float(1.0 - np.exp(-interval_s / self.rms_time_s)),
            1.0 / self.frequency_range_hz[1],
            1.0 / self.frequency_range_hz[0],
            self.smoothing,
        )


@dataclass
class _Following:
    """State of a tracker; a class instead of a closure, so that it can be copied and pickled."""

    state: TrackerState
    constants: tuple[float, ...]

    def __call__(self, sagittal_rate_rad_s: float) -> float:
        self.state = track(self.state, sagittal_rate_rad_s, self.constants)
        return 1.0 / self.state[2]
