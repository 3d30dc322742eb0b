"""Sizes passed to kernels as lengths: of tuples at compile time, of arrays at run time.

The length of a tuple is part of its type, so a kernel is compiled again for another one. The length
of an array is not, so the same machine code serves all; kernels read both by `len`.
"""

import numpy as np
from numpy.typing import NDArray


def length(n: int) -> tuple[int, ...]:
    """Return a tuple whose length encodes a size at compile time.

    Parameters
    ----------
    n : int
        The size.

    Returns
    -------
    tuple of int
        `n` zeros.
    """
    return (0,) * n


def run_time_length(n: int) -> NDArray[np.uint8]:
    """Return an array whose length encodes a size at run time.

    Parameters
    ----------
    n : int
        The size.

    Returns
    -------
    ndarray, shape (n,)
        Zeros.
    """
    return np.zeros(n, np.uint8)


SCALAR, VECTOR = length(1), length(8)
