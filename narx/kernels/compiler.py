"""How the functions of this folder are compiled, and what stands in where numba cannot do it.

`compiled` is the package's only way to machine code. Without numba, or with `NUMBA_DISABLE_JIT`,
it leaves functions as they are, in plain Python: the same numbers, slowly. Explicit vectors
(`narx.kernels.lanes`) do not work then; `narx.kernels.loops` tells the networks.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

try:
    import numba

    # set by numba while it is loaded, out of a type checker's sight
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

# operation after operation as written
EXACT: dict[str, Any] = {"cache": True, "nogil": True}
EXACT_INNER: dict[str, Any] = {"nogil": True}

JIT: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",  # the check for division by zero would block vectorisation
    "fastmath": {"contract"},  # fused multiply-add, but NaN stays NaN and order stays order
}

# of what only kernels call: without an entry from Python, and kept in the cache of its callers
INNER: dict[str, Any] = {
    **JIT,
    "cache": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


def compiled(cache: bool = False, **options: Any) -> Callable[[Any], Any]:
    """Compile a function of this folder.

    Parameters
    ----------
    cache : bool
        Keep the machine code on disk.
    **options
        Of ``numba.njit``: `EXACT`, `JIT` or those of an inner function.

    Returns
    -------
    callable
        Decorator.
    """

    def decorate(function: Any) -> Any:
        if INTERPRETED:
            # as compiled code does, divide by zero without a word
            return np.errstate(all="ignore")(function) if cache else function
        dispatcher = numba.njit(**options)(function)
        if cache and _keep is not None:
            _keep(dispatcher)
        return dispatcher

    return decorate
