"""Gaps in a recording: short ones are interpolated, longer ones filled, the longest left."""

from typing import NamedTuple

import numpy as np

from narx.missing import finite_rows
from narx.recordings.bridging import bridged, can_fill
from narx.recordings.resampling import resample_vectors
from narx.types import BoolArray, FloatArray

# a few lost samples; a spline across a longer gap overshoots
SPLINE_GAP_S = 0.1
# a longer interval between neighbouring samples than so many usual ones is a gap
_USUAL = 1.5


class Gaps(NamedTuple):
    """Intervals between neighbouring samples, and what is done about them.

    Parameters
    ----------
    begins_s, lengths_s : ndarray, shape (N - 1,)
        Time of the sample before, and time to the next one, s.
    interpolated, filled, left : ndarray of bool, shape (N - 1,)
        Gaps that are interpolated by splines, filled by `narx.recordings.bridging`, or left.
    """

    begins_s: FloatArray
    lengths_s: FloatArray
    interpolated: BoolArray
    filled: BoolArray
    left: BoolArray


def gaps_of(time_s: FloatArray, values: FloatArray, max_gap_s: float) -> Gaps:
    """Find the gaps of a recording, and what `on_clock` does about them.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    values : ndarray, shape (N, K)
        Samples; a row with NaN is missing.
    max_gap_s : float
        Longest gap that is filled, s.

    Returns
    -------
    Gaps
        Between the samples that are there.
    """
    there = time_s[finite_rows(values)]
    lengths = np.diff(there)
    usual_s = float(np.median(lengths)) if len(lengths) else np.inf
    longer = lengths > _longest_splined_s(usual_s) + 1e-6
    filled = longer & (lengths <= max_gap_s + 1e-6) & can_fill(len(there), 1.0 / usual_s)
    return Gaps(
        there[:-1], lengths, (lengths > _USUAL * usual_s) & ~longer, filled, longer & ~filled
    )


def on_clock(
    time_s: FloatArray,
    values: FloatArray,
    clock_s: FloatArray,
    sampling_rate_hz: float,
    max_gap_s: float,
) -> FloatArray:
    """Resample to a uniform clock by cubic splines, and fill gaps that are too long for them.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    values : ndarray, shape (N, K)
        Samples; a row with NaN is missing.
    clock_s : ndarray, shape (M,)
        Ticks of the uniform clock, s.
    sampling_rate_hz : float
        Its rate.
    max_gap_s : float
        Longest gap that is filled, s.

    Returns
    -------
    ndarray, shape (M, K)
        Values at the ticks; NaN in gaps that are left.
    """
    spline_s = _longest_splined_s(float(np.median(np.diff(time_s))))
    splined = resample_vectors(time_s, values, clock_s, max_gap_s=spline_s)
    return bridged(splined, sampling_rate_hz, max_gap_s)


def _longest_splined_s(interval_s: float) -> float:
    """Longest gap that is interpolated; regular intervals are never gaps."""
    return max(SPLINE_GAP_S, _USUAL * interval_s)
