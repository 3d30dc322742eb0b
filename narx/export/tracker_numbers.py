"""The tracker's numbers and matrices for exports: the same decisions and accuracy in float32.

The package adds intervals up and compares their sum. In another precision the sum has other last
digits, so exports compare with a time between two samples instead.
"""

import math

import numpy as np

from narx.inference.tracker import PostureTracker
from narx.kernels import tracker_layout as kernel
from narx.network.model import Narx
from narx.types import FloatArray


def between_samples(time_s: float, interval_s: float, *, above: bool) -> float:
    """Move a time that sums of intervals are compared with to the middle between two of them.

    Parameters
    ----------
    time_s : float
        What the package compares with.
    interval_s : float
        Sampling interval, s.
    above : bool
        Whether a sum that is equal counts as below (compared with ``>``) or not (``>=``, ``<``).

    Returns
    -------
    float
        s; sums in float64 lie on the same side of it as of `time_s`.
    """
    sums = np.cumsum(np.full(math.ceil(time_s / interval_s) + 2, interval_s))
    reached = sums > time_s if above else sums >= time_s
    return float((np.argmax(reached) + 0.5) * interval_s)


def exported_numbers(tracker: PostureTracker, model: Narx) -> FloatArray:
    """Return the parameters for an export.

    Parameters
    ----------
    tracker : PostureTracker
        Of the checkpoint.
    model : Narx
        Its network.

    Returns
    -------
    ndarray, shape (PARAMETERS,)
        As `narx.inference.tracker.PostureTracker.numbers`.
    """
    numbers = tracker.numbers(model)
    interval_s = float(numbers[kernel.INTERVAL])
    # once idle for this long or set to it after a gap, the leg does not walk
    numbers[kernel.IDLE_MOST] = between_samples(tracker.idle_s, interval_s, above=False)
    return numbers


def relative(covariance: np.ndarray) -> np.ndarray:
    """Turn a covariance into that of the angles relative to the posture.

    Parameters
    ----------
    covariance : ndarray, shape (n, n)
        Of the states in `narx.kernels.tracker`.

    Returns
    -------
    ndarray, shape (n, n)
        The first three states less the three of the posture.
    """
    turned = np.eye(len(covariance))
    turned[:3, kernel.CENTRE : kernel.CENTRE + 3] = -np.eye(3)
    return np.asarray(turned @ covariance @ turned.T)


def changes(n_states: int, interval_s: float) -> np.ndarray:
    """Return what changes the relative states from sample to sample, apart from its factors.

    Parameters
    ----------
    n_states : int
        Of the tracker.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    ndarray, shape (8, n_states, n_states)
        For the leak, 1, the turn rate, the lean, the vertical force, the turn rate of the velocity,
        the force that the frontal angle turns, and 1: the state itself.
    """
    parts = np.zeros((8, n_states, n_states))
    for axis in range(3):
        parts[0, axis, axis] = -1.0
        parts[1, axis, kernel.BIAS + axis] = -interval_s
    parts[3, 1, kernel.LEAN] = 1.0
    for angle in (0, kernel.CENTRE):
        parts[2, 0, angle + 1], parts[2, 1, angle] = -1.0, 1.0
        if n_states == kernel.AIDED_STATES:
            parts[4, kernel.VELOCITY, angle] = -interval_s
            parts[6, kernel.VELOCITY + 1, angle + 1] = interval_s
    if n_states == kernel.AIDED_STATES:
        ahead, aside = kernel.VELOCITY, kernel.VELOCITY + 1
        parts[5, ahead, aside], parts[5, aside, ahead] = interval_s, -interval_s
    parts[7] = np.eye(n_states)
    return parts


def posture_growth(axis: int, n_states: int) -> np.ndarray:
    """Return how the covariance grows with the variance of a posture.

    Parameters
    ----------
    axis : int
        Of the posture.
    n_states : int
        Of the tracker.

    Returns
    -------
    ndarray, shape (n_states, n_states)
        By a variance of one.
    """
    row = np.zeros(n_states)
    row[axis], row[kernel.CENTRE + axis] = -1.0, 1.0
    return np.outer(row, row)


def upper_part(interval_s: float) -> float:
    """Round an interval so that its multiples are exact in float32.

    Parameters
    ----------
    interval_s : float
        s.

    Returns
    -------
    float
        s; multiples up to 4096 are exact.
    """
    mantissa, exponent = np.frexp(interval_s)
    return float(np.ldexp(np.floor(mantissa * 4096.0), exponent - 12))
