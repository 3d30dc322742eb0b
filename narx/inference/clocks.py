"""Conversions between a recording's own clock, a uniform clock and that of the network.

A trained recurrence is valid for one sampling interval. Instead of changing its weights, the
recording is resampled to the network's clock and the angles back to that of the recording. Both
conversions use the integral of the rate, so there is no aliasing and no rotation is lost.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import make_interp_spline

from narx.errors import RecordingError
from narx.recordings.gaps import on_clock
from narx.recordings.resampling import contiguous_pieces
from narx.types import BoolArray, FloatArray, IntArray


class ClockConversion:
    """Uniform clock with about a recording's median rate and the same start and end.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, increasing, regular or not, s.
    max_gap_s : float
        Longest interval between neighbouring samples that is interpolated, unless the
        recording's regular interval is longer.
    where : str
        Name of the recording, for messages.

    Attributes
    ----------
    clock_s : ndarray, shape (M,)
        The uniform clock, s.
    sampling_rate_hz : float
        Its rate.

    Raises
    ------
    RecordingError
        If there are fewer than two samples.
    """

    def __init__(self, time_s: FloatArray, max_gap_s: float, where: str) -> None:
        if len(time_s) < 2:
            raise RecordingError(f"{where}: {len(time_s)} samples, expected at least 2")
        interval_s = float(np.median(np.diff(time_s)))
        duration_s = float(time_s[-1] - time_s[0])
        intervals = max(1, round(duration_s / interval_s))
        self._time_s = time_s
        self._max_gap_s = max_gap_s
        self.clock_s = np.linspace(time_s[0], time_s[-1], intervals + 1)
        self.sampling_rate_hz = intervals / duration_s

    def to_clock(self, values: FloatArray) -> FloatArray:
        """Resample to the uniform clock.

        Parameters
        ----------
        values : ndarray, shape (N, K)
            Values at the sampling times; NaN where missing.

        Returns
        -------
        ndarray, shape (M, K)
            Values at the clock's ticks (`narx.recordings.gaps.on_clock`); NaN in long gaps.
        """
        return on_clock(self._time_s, values, self.clock_s, self.sampling_rate_hz, self._max_gap_s)

    def nearest_ticks(self) -> IntArray:
        """Find the tick of the uniform clock that is nearest to each sampling time.

        Returns
        -------
        ndarray of int, shape (N,)
            Indices of `clock_s`.
        """
        return np.round((self._time_s - self.clock_s[0]) * self.sampling_rate_hz).astype(int)

    def to_samples(self, values: FloatArray, there: BoolArray) -> FloatArray:
        """Resample values on the uniform clock at the sampling times.

        Parameters
        ----------
        values : ndarray, shape (M, K)
            Values at the clock's ticks; NaN where missing.
        there : ndarray of bool, shape (N,)
            Samples to compute.

        Returns
        -------
        ndarray, shape (N, K)
            Values at the sampling times, by cubic splines; NaN at the other samples, and at those
            too far from any other.
        """
        clock, interval_s = self.clock_s, 1.0 / self.sampling_rate_hz
        result = np.full((len(self._time_s), values.shape[1]), np.nan)
        # a column that is entirely missing (an unobserved axis) is not a gap in the other columns
        known = np.flatnonzero(np.isfinite(values).any(axis=0))
        complete = np.isfinite(values[:, known]).all(axis=1) & bool(known.size)
        for piece in contiguous_pieces(clock, complete, 1.5 * interval_s):
            # a piece's first sample may lie before its first tick, and the last after the last
            first, last = clock[piece[0]] - interval_s, clock[piece[-1]] + interval_s
            inside = there & (self._time_s > first) & (self._time_s < last)
            if piece.size < 2 or not inside.any():
                continue
            spline = make_interp_spline(
                clock[piece] - first, values[np.ix_(piece, known)], k=3 if piece.size > 3 else 1
            )
            result[np.ix_(inside, known)] = spline(self._time_s[inside] - first)
        return result


class RateConversion:
    """Conversion between a recording's sampling rate and the network's.

    Parameters
    ----------
    rates_rad_s : ndarray, shape (N, C)
        Angular rates on the recording's clock, no NaN.
    recording_rate_hz : float
        Sampling rate of the recording.
    network_rate_hz : float
        Sampling rate of the network.
    """

    def __init__(
        self, rates_rad_s: FloatArray, recording_rate_hz: float, network_rate_hz: float
    ) -> None:
        rates = np.asarray(rates_rad_s, dtype=np.float64)
        half_s = 0.5 / network_rate_hz
        self._time_s = np.arange(len(rates)) / recording_rate_hz
        self._integral = np.zeros(rates.shape)
        self._network_time_s = np.empty(0)
        self._network_integral = self.network_rates_rad_s = np.empty_like(rates)
        if not len(rates):
            return
        self._integral[1:] = cumulative_trapezoid(rates, dx=1.0 / recording_rate_hz, axis=0)
        n_network = int(np.floor(self._time_s[-1] * network_rate_hz + 1e-9)) + 1
        self._network_time_s = np.arange(n_network) / network_rate_hz
        # the rate is constant beyond the ends of the recording
        time_s = np.concatenate([[-half_s], self._time_s, [self._time_s[-1] + half_s]])
        integral = np.concatenate(
            [-half_s * rates[:1], self._integral, self._integral[-1:] + half_s * rates[-1:]]
        )
        self._network_integral = _interpolate(self._network_time_s, time_s, integral)
        # mean rate from half a tick before to half a tick after: no rotation is lost, and the input
        # of the network, which acts like the trapezoidal rule, is not half a sample late
        edges_s = (np.arange(n_network + 1, dtype=np.float64) - 0.5) / network_rate_hz
        between = _interpolate(edges_s, time_s, integral)
        self.network_rates_rad_s = np.diff(between, axis=0) * network_rate_hz

    def to_recording(self, angles_rad: FloatArray) -> FloatArray:
        """Convert the network's angles to the recording's clock.

        Parameters
        ----------
        angles_rad : ndarray, shape (N_network, C)
            Angles at the network's ticks.

        Returns
        -------
        ndarray, shape (N, C)
            Angles at the recording's samples: the recording's own integral plus the slow
            difference between network and integral, interpolated.
        """
        if not len(angles_rad):
            return np.empty_like(self._integral)
        slow = angles_rad - self._network_integral
        return self._integral + _interpolate(self._time_s, self._network_time_s, slow)


def _interpolate(wanted_s: FloatArray, time_s: FloatArray, values: FloatArray) -> FloatArray:
    return np.stack(
        [np.interp(wanted_s, time_s, values[:, c]) for c in range(values.shape[1])], axis=1
    )
