"""Strides of a recording, each normalised to 0-100 % of its gait cycle."""

import numpy as np

from narx.types import FloatArray

POINTS = 101
# a stride longer than this many median strides spans a pause or a missed contact
LONGEST_TO_MEDIAN = 1.5


def normalised_strides(
    time_s: FloatArray, values: FloatArray, contacts_s: FloatArray, points: int = POINTS
) -> FloatArray:
    """Cut a signal at foot contacts and resample every stride to the same number of points.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, increasing, s.
    values : ndarray, shape (N, C)
        Signal; NaN where missing.
    contacts_s : ndarray, shape (S + 1,)
        Times at which the same foot touches the ground, increasing, s.
    points : int
        Points from one contact (0 %) to the next (100 %), both included.

    Returns
    -------
    ndarray, shape (S, points, C)
        Linear interpolation between the two samples adjacent to each point. All values of a stride
        are NaN if one of its samples is missing, if it extends beyond the signal, or if it lasts
        more than 1.5 times the median stride; so the strides of several signals stay aligned.
    """
    contacts = np.asarray(contacts_s, dtype=float)
    n_strides = max(0, len(contacts) - 1)
    strides = np.full((n_strides, points, values.shape[1]), np.nan)
    durations = np.diff(contacts)
    if not n_strides or len(time_s) < 2:
        return strides
    longest = LONGEST_TO_MEDIAN * float(np.median(durations))
    for k in range(n_strides):
        if contacts[k] < time_s[0] or contacts[k + 1] > time_s[-1] or durations[k] > longest:
            continue
        first = np.searchsorted(time_s, contacts[k], side="right") - 1
        last = np.searchsorted(time_s, contacts[k + 1], side="left") + 1
        inside = values[first:last]
        if not np.isfinite(inside).all():
            continue
        at = np.linspace(contacts[k], contacts[k + 1], points)
        for column in range(values.shape[1]):
            strides[k, :, column] = np.interp(at, time_s[first:last], inside[:, column])
    return strides
