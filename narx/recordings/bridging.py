"""Fill gaps in a periodic signal by an autoregressive model of the signal itself.

Janssen, Veldhuis and Vries: Adaptive interpolation of discrete-time signals that can be modeled as
autoregressive processes, IEEE Trans Acoust Speech Signal Process 34:317, 1986. The missing samples
are those with the smallest sum of squared prediction errors, and model and samples are estimated in
turn. With an order of more than a stride the model continues the rhythm of a walk, which a spline
cannot.
"""

import numpy as np
from scipy.linalg import solve, solve_toeplitz, toeplitz

from narx.missing import finite_rows
from narx.types import BoolArray, FloatArray

# a little more than one stride of normal walking
_ORDER_S = 1.2
# the lags of the model have about this rate: a higher one only adds noise
_MODEL_HZ = 100.0
_ROUNDS = 3
# share of white noise in the model, for a well-conditioned solution
_RIDGE = 1e-4
# samples needed in relation to the order of the model
_MIN_ORDERS = 3


def bridged(values: FloatArray, sampling_rate_hz: float, max_gap_s: float) -> FloatArray:
    """Fill the gaps of a signal up to a length.

    Parameters
    ----------
    values : ndarray, shape (N, K)
        Samples on a uniform clock; a row with NaN is missing.
    sampling_rate_hz : float
        Samples per second.
    max_gap_s : float
        Longest interval between neighbouring samples that is filled.

    Returns
    -------
    ndarray, shape (N, K)
        The values, NaN in longer gaps, at the ends, and if there are too few samples for a model.
    """
    there = finite_rows(values)
    gaps = _gaps(there, max_gap_s * sampling_rate_hz)
    if not gaps or not can_fill(int(there.sum()), sampling_rate_hz):
        return values
    order, stride = _order(sampling_rate_hz)
    filled = values.copy()
    wanted = np.zeros(len(values), dtype=bool)
    for start, stop in gaps:
        wanted[start:stop] = True
    for first in range(stride):
        own = slice(first, None, stride)
        for axis in range(values.shape[1]):
            complete = _completed(values[own, axis], there[own], wanted[own], order)
            filled[own, axis] = np.where(wanted[own], complete, filled[own, axis])
    return filled


def can_fill(n_samples: int, sampling_rate_hz: float) -> bool:
    """Tell whether there are enough samples for a model.

    Parameters
    ----------
    n_samples : int
        Samples that are there.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    bool
        Whether `bridged` fills gaps.
    """
    order, stride = _order(sampling_rate_hz)
    return n_samples >= _MIN_ORDERS * order * stride


def _order(sampling_rate_hz: float) -> tuple[int, int]:
    """Order of the model, and how many interleaved sequences have one each."""
    # interleaved, so that the order does not grow with the rate
    stride = max(1, round(sampling_rate_hz / _MODEL_HZ))
    return round(_ORDER_S * sampling_rate_hz / stride), stride


def _gaps(there: BoolArray, most: float) -> list[tuple[int, int]]:
    """Start and end (exclusive) of the gaps of at most so many intervals."""
    known = np.flatnonzero(there)
    steps = np.diff(known)
    short = np.flatnonzero((steps > 1) & (steps <= most + 1e-6))
    return [(int(known[k]) + 1, int(known[k + 1])) for k in short]


def _completed(signal: FloatArray, there: BoolArray, wanted: BoolArray, order: int) -> FloatArray:
    """Return one axis with estimates in place of the wanted samples."""
    mean = float(signal[there].mean())
    # further missing samples are assumed to be at the mean
    x = np.where(there, signal - mean, 0.0)
    if not np.any(x):
        return x + mean
    edges = np.flatnonzero(np.diff(np.r_[False, wanted, False].astype(int)))
    for _ in range(_ROUNDS):
        errors = _prediction_errors(x, order)
        # correlation of the prediction error's weights: the gradient of its sum of squares
        weights = np.correlate(errors, errors, "full")
        padded = np.pad(x, order)
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            around = padded[start : stop + 2 * order].copy()
            around[order:-order] = 0.0
            from_known = np.convolve(around, weights, "valid")
            column = np.zeros(stop - start)
            inside = weights[order : order + len(column)]
            column[: len(inside)] = inside
            padded[start + order : stop + order] = solve(
                toeplitz(column), -from_known, assume_a="pos"
            )
        x = padded[order:-order]
    return x + mean


def _prediction_errors(x: FloatArray, order: int) -> FloatArray:
    """Coefficients of the filter whose output is the error of linear prediction (Yule-Walker)."""
    n_fft = 1 << (2 * len(x) - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(x, n_fft)) ** 2
    correlation = np.fft.irfft(spectrum, n_fft)[: order + 1]
    correlation[0] *= 1.0 + _RIDGE
    return np.r_[1.0, -solve_toeplitz(correlation[:order], correlation[1:])]
