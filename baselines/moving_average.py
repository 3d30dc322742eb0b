"""A centred moving average whose window is a duration, not a number of samples."""

import numpy as np
from numpy.typing import ArrayLike

from narx.types import FloatArray


def centred_moving_average(
    values: ArrayLike, window_s: float, sampling_rate_hz: float
) -> FloatArray:
    """Average a signal over a window centred on each sample.

    Parameters
    ----------
    values : array_like, shape (N, ...)
        Samples, none missing.
    window_s : float
        Length of the window, s.
    sampling_rate_hz : float
        Sampling rate.

    Returns
    -------
    ndarray, shape (N, ...)
        Integral over the window of the straight lines between samples, divided by its length.
        A window of an even number of intervals thus gives its two end samples half a weight
        each. At the ends of the recording the window is truncated.
    """
    series = np.asarray(values, dtype=float)
    if len(series) < 2:
        return series.copy()
    # subtract a constant, so that the running sum stays small
    middle = series.mean(axis=0)
    series = series - middle
    panels = 0.5 * (series[1:] + series[:-1])
    integral = np.concatenate([np.zeros_like(series[:1]), np.cumsum(panels, axis=0)])
    place = np.arange(len(series), dtype=float)
    half = 0.5 * window_s * sampling_rate_hz
    begin = np.maximum(place - half, 0.0)
    end = np.minimum(place + half, len(series) - 1.0)
    length = (end - begin).reshape(-1, *[1] * (series.ndim - 1))
    return middle + (_at(integral, series, end) - _at(integral, series, begin)) / length


def _at(integral: FloatArray, series: FloatArray, place: FloatArray) -> FloatArray:
    """Evaluate the running integral between samples, where it is a parabola."""
    whole = np.minimum(place.astype(int), len(series) - 2)
    part = (place - whole).reshape(-1, *[1] * (series.ndim - 1))
    slope = series[whole + 1] - series[whole]
    return integral[whole] + part * (series[whole] + 0.5 * part * slope)
