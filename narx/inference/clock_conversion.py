"""A recording's own sampling times beside a uniform clock, there and back."""

import numpy as np
from scipy.interpolate import make_interp_spline

from narx.errors import RecordingError
from narx.recordings.resampling import contiguous_pieces, resample_vectors
from narx.types import BoolArray, FloatArray


class ClockConversion:
    """Uniform clock of about a recording's median rate that begins and ends with it.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, increasing, regular or not, s.
    max_gap_s : float
        Longest interval between neighbouring samples that is interpolated across, unless the
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
        self._max_gap_s = max(max_gap_s, 1.5 * interval_s)
        self.clock_s = np.linspace(time_s[0], time_s[-1], intervals + 1)
        self.sampling_rate_hz = intervals / duration_s

    def to_clock(self, values: FloatArray) -> FloatArray:
        """Bring samples to the uniform clock.

        Parameters
        ----------
        values : ndarray, shape (N, K)
            At the sampling times; NaN where missing.

        Returns
        -------
        ndarray, shape (M, K)
            At the clock's ticks, by cubic splines; NaN in gaps.
        """
        return resample_vectors(self._time_s, values, self.clock_s, max_gap_s=self._max_gap_s)

    def to_samples(self, values: FloatArray, there: BoolArray) -> FloatArray:
        """Bring values on the uniform clock back to the sampling times.

        Parameters
        ----------
        values : ndarray, shape (M, K)
            At the clock's ticks; NaN where missing.
        there : ndarray of bool, shape (N,)
            Samples that want a value.

        Returns
        -------
        ndarray, shape (N, K)
            At the sampling times, by cubic splines; NaN at samples that want none, and at those
            too far from any other to have one.
        """
        clock, interval_s = self.clock_s, 1.0 / self.sampling_rate_hz
        result = np.full((len(self._time_s), values.shape[1]), np.nan)
        # a column that is missing throughout (an axis nobody knows) makes no gap in the others
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
