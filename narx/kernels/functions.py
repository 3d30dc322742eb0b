"""Hyperbolic tangent, sine, cosine and vectors; of single numbers by numpy if interpreted."""

from typing import Any

import numpy as np

from narx.kernels import loops

if loops.AVAILABLE:
    from narx.kernels.euler import sine_cosine
    from narx.kernels.lanes import load, magnitude, splat, store, where_less
    from narx.kernels.tanh import rational_tanh as tanh
else:
    tanh, magnitude = np.tanh, np.abs

    def sine_cosine(x: Any, exact: Any) -> Any:
        """Sine and cosine by numpy."""
        return np.sin(x), np.cos(x)

    def load(lanes: Any, array: Any, index: Any) -> Any:
        """Read the number of the only lane."""
        return array[index]

    def store(lanes: Any, array: Any, index: Any, value: Any) -> None:
        """Write the number of the only lane."""
        array[index] = value

    def splat(lanes: Any, value: Any) -> Any:
        """Return the number of the only lane."""
        return value

    def where_less(x: Any, limit: Any, yes: Any, no: Any) -> Any:
        """Return `yes` where x < limit, else `no`."""
        return yes if x < limit else no


__all__ = ["load", "magnitude", "sine_cosine", "splat", "store", "tanh", "where_less"]
