"""The tracker's numbers where times are compared: the same decisions in float32.

The package adds intervals up and compares their sum. In another precision the sum has other last
digits, so exports compare with a time between two samples instead.
"""

import math

import numpy as np

from narx.inference.tracker import PostureTracker
from narx.kernels import tracker as kernel
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
