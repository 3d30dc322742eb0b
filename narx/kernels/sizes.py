"""Sizes known to a kernel at compile time: a length is part of a tuple's type."""


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


SCALAR, VECTOR = length(1), length(8)
