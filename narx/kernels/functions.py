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

    def _position(lanes: Any, index: Any) -> Any:
        if len(lanes) == 1:
            return index
        return (*index[:-1], slice(index[-1], index[-1] + len(lanes)))

    def load(lanes: Any, array: Any, index: Any) -> Any:
        """Read the numbers of all lanes, the only one's as a number."""
        return array[_position(lanes, index)].copy()

    def store(lanes: Any, array: Any, index: Any, value: Any) -> None:
        """Write the numbers of all lanes."""
        array[_position(lanes, index)] = value

    def splat(lanes: Any, value: Any) -> Any:
        """Return a number of each lane, the only one's as a number."""
        return value if len(lanes) == 1 else np.full(len(lanes), value)

    def where_less(x: Any, limit: Any, yes: Any, no: Any) -> Any:
        """Choose lane by lane: `yes` where x < limit, else `no`."""
        return np.where(np.less(x, limit), yes, no)[()]


__all__ = ["load", "magnitude", "sine_cosine", "splat", "store", "tanh", "where_less"]
