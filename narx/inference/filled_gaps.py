"""Uncertainty of the angles in and after gaps whose samples were estimated.

`narx.recordings.bridging` continues the rhythm of a walk; what the leg did otherwise is lost, and
the angles are off until the network has drawn them back.
"""

import numpy as np

from narx.recordings.gaps import gaps_of
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
    gaps = gaps_of(time_s, gyroscope_rad_s, max_gap_s)
    variance = np.zeros((len(clock_s), 3))
    for begin_s, length_s in zip(
        gaps.begins_s[gaps.filled], gaps.lengths_s[gaps.filled], strict=True
    ):
        # ten time constants later it is below a hundredth of a degree
        end_s = begin_s + length_s + 10.0 * _DECAY_S
        first, last = np.searchsorted(clock_s, (begin_s, end_s))
        since_s = clock_s[first:last] - begin_s
        within = np.minimum(_GROWTH_RAD_S * np.minimum(since_s, length_s)[:, None], _MOST_RAD)
        left = np.exp(-np.maximum(since_s - length_s, 0.0) / _DECAY_S)
        variance[first:last] += (within * left[:, None]) ** 2
    return np.asarray(np.sqrt(variance))
