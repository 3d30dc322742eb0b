"""Uncertainty of the angles in and after gaps whose samples were estimated.

`narx.recordings.bridging` continues the rhythm of a walk; what the leg did otherwise is lost, and
the angles are off until the network has drawn them back.
"""

import numpy as np

from narx.inference.clocks import SPLINE_GAP_S
from narx.missing import finite_rows
from narx.types import FloatArray

# RMS of the error after gaps of 0.2 to 1 s in four front pockets and on thigh and shank of
# `neura_sample`: sagittal, frontal, transverse (turns included)
_GROWTH_RAD_S = np.radians([12.0, 8.0, 90.0])
_MOST_RAD = np.radians([7.0, 5.0, 90.0])
# half of the error is left after five seconds
_DECAY_S = 7.0


def filled_gap_std_rad(
    time_s: FloatArray, gyroscope_rad_s: FloatArray, clock_s: FloatArray, max_gap_s: float
) -> FloatArray:
    """Standard deviation that filling the gaps adds to the angles.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    gyroscope_rad_s : ndarray, shape (N, 3)
        Samples; NaN where missing.
    clock_s : ndarray, shape (M,)
        Times at which it is wanted, increasing, s.
    max_gap_s : float
        Longest gap that was filled, s.

    Returns
    -------
    ndarray, shape (M, 3)
        rad, about the clinical axes; zero before the first gap. Variances of several gaps add up.
    """
    there = time_s[finite_rows(gyroscope_rad_s)]
    gaps_s = np.diff(there)
    variance = np.zeros((len(clock_s), 3))
    longest_spline_s = max(SPLINE_GAP_S, 1.5 * float(np.median(gaps_s))) if len(gaps_s) else 0.0
    for k in np.flatnonzero((gaps_s > longest_spline_s + 1e-6) & (gaps_s <= max_gap_s)):
        # ten time constants later it is below a thousandth of a degree
        first, last = np.searchsorted(clock_s, (there[k], there[k + 1] + 10.0 * _DECAY_S))
        since_s = clock_s[first:last] - there[k]
        within = np.minimum(_GROWTH_RAD_S * np.minimum(since_s, gaps_s[k])[:, None], _MOST_RAD)
        left = np.exp(-np.maximum(since_s - gaps_s[k], 0.0) / _DECAY_S)
        variance[first:last] += (within * left[:, None]) ** 2
    return np.asarray(np.sqrt(variance))
