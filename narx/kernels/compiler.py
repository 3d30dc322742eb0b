"""Compilation of this folder's functions, and the fallback where numba is unavailable.

`compiled` is the package's only use of the compiler. Without numba, or with `NUMBA_DISABLE_JIT`,
functions remain plain Python: the same results, but slower. Explicit vectors (`narx.kernels.lanes`)
do not work in that case, and `narx.kernels.loops` selects plain torch for the networks.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

try:
    import numba

    # set by numba at import, invisible to a type checker
    INTERPRETED = "NUMBA_DISABLE_JIT is set" if vars(numba.config)["DISABLE_JIT"] else ""
except Exception as error:  # numba refuses releases of numpy and Python that it does not support
    INTERPRETED = f"numba cannot be loaded: {error}"

try:
    from narx.kernels.cache import keep_on_disk
except Exception as error:
    _keep: Callable[[Any], None] | None = None
    UNSUPPORTED = f"this release of numba is not supported: {error}"
else:
    _keep, UNSUPPORTED = keep_on_disk, ""

# exactly the operations in the source
EXACT: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",  # the check for division by zero would block vectorisation
    "_nrt": True,  # count references to arrays, whatever the caller does
}
JIT: dict[str, Any] = {
    **EXACT,
    "fastmath": {"contract"},  # allow fused multiply-add, but keep NaN and the order of operations
}

# functions called only by kernels: no Python entry point, cached with their callers
_UNCALLED: dict[str, Any] = {"cache": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
INNER: dict[str, Any] = {**JIT, **_UNCALLED}
EXACT_INNER: dict[str, Any] = {**EXACT, **_UNCALLED}
# functions that make no arrays, only views of those that their callers hold: counting references
# to these takes longer than the rest of a tracked sample
VIEWS: dict[str, Any] = {**INNER, "_nrt": False}
EXACT_VIEWS: dict[str, Any] = {**EXACT_INNER, "_nrt": False}


def compiled(cache: bool = False, **options: Any) -> Callable[[Any], Any]:
    """Compile a function of this folder.

    Parameters
    ----------
    cache : bool
        Keep the machine code on disk.
    **options
        Options of ``numba.njit``: `EXACT`, `JIT` or those of an inner function.

    Returns
    -------
    callable
        Decorator.
    """

    def decorate(function: Any) -> Any:
        if INTERPRETED:
            # divide by zero silently, as compiled code does
            return np.errstate(all="ignore")(function) if cache else function
        dispatcher = numba.njit(**options)(function)
        if cache and _keep is not None:
            _keep(dispatcher)
        return dispatcher

    return decorate
