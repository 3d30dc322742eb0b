"""Orientation from successive rotation vectors."""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, compiled


@compiled(**EXACT)
def compose_turns(start: Any, turns: Any) -> Any:
    """Orientations w, x, y, z, shape (N + 1, 4), after each of N body-fixed rotation vectors."""
    out = np.empty((len(turns) + 1, 4))
    # by elements: assigning or unpacking a row takes seconds to compile
    for part in range(4):
        out[0, part] = start[part]
    for k in range(len(turns)):
        x, y, z = turns[k, 0], turns[k, 1], turns[k, 2]
        angle = np.sqrt(x * x + y * y + z * z)
        # sin(angle / 2) / angle, by its series where the quotient would lose precision
        scale = np.sin(0.5 * angle) / angle if angle > 1e-6 else 0.5 - angle * angle / 48.0
        c, x, y, z = np.cos(0.5 * angle), scale * x, scale * y, scale * z
        w0, x0, y0, z0 = out[k, 0], out[k, 1], out[k, 2], out[k, 3]
        w = w0 * c - x0 * x - y0 * y - z0 * z
        i = w0 * x + x0 * c + y0 * z - z0 * y
        j = w0 * y - x0 * z + y0 * c + z0 * x
        q = w0 * z + x0 * y - y0 * x + z0 * c
        norm = np.sqrt(w * w + i * i + j * j + q * q)
        out[k + 1, 0], out[k + 1, 1] = w / norm, i / norm
        out[k + 1, 2], out[k + 1, 3] = j / norm, q / norm
    return out
