"""Sizes that a kernel sees at compile time: a length is part of a tuple's type."""


def length(n: int) -> tuple[int, ...]:
    """Return a tuple whose length tells a kernel a size at compile time.

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
