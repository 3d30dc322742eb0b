"""Hyperbolic tangent, sine and cosine of single numbers: polynomials, or numpy's if interpreted."""

from typing import Any

import numpy as np

from narx.kernels import loops

if loops.AVAILABLE:
    from narx.kernels.euler import sine_cosine
    from narx.kernels.tanh import rational_tanh as tanh
else:
    tanh = np.tanh

    def sine_cosine(x: Any, exact: Any) -> Any:
        """Sine and cosine by numpy."""
        return np.sin(x), np.cos(x)


__all__ = ["sine_cosine", "tanh"]
