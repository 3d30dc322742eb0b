"""The compiled loops of the network, if available: the only switch between numba and torch.

If numba cannot be loaded, is switched off, or has changed its internals, `AVAILABLE` is False and
the networks run in plain torch operations: the same results, far slower.
"""

import warnings

from narx.kernels.compiler import INTERPRETED, UNSUPPORTED

_reason = INTERPRETED or UNSUPPORTED
if not _reason:
    try:
        from narx.kernels import (
            axis_loop,
            axis_normal,
            coupled_loop,
            coupled_normal,
            gram,
            one_step,
        )
    except Exception as error:
        _reason = f"this release of numba is not supported: {error}"

AVAILABLE = not _reason

if not AVAILABLE:
    warnings.warn(
        f"narx: networks run by plain torch operations, hundreds of times slower ({_reason})",
        RuntimeWarning,
        stacklevel=2,
    )

__all__ = [
    "AVAILABLE",
    "axis_loop",
    "axis_normal",
    "coupled_loop",
    "coupled_normal",
    "gram",
    "one_step",
]
