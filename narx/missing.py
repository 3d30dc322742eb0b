"""Which samples are missing."""

import numpy as np

from narx.types import BoolArray, FloatArray


def finite_rows(values: FloatArray) -> BoolArray:
    """Return the samples whose values are all finite.

    Parameters
    ----------
    values : ndarray, shape (N, C)
        Samples of a few channels, C of at least 1.

    Returns
    -------
    ndarray of bool, shape (N,)
        True where no value is NaN or infinite.
    """
    finite = np.isfinite(values)
    # column by column: a reduction over a short last axis takes eight times as long
    rows: BoolArray = finite[:, 0].copy()
    for column in range(1, finite.shape[1]):
        rows &= finite[:, column]
    return rows
