"""All uses of numba beyond its stable interface, in one place.

A numba release may move any of these names. This file then fails to import, and
`narx.kernels.loops` makes the package work without the compiled loops.
"""

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.imputils import lower_builtin
from numba.core.serialize import dumps
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, overload, register_model

__all__ = [
    "AbstractTemplate",
    "CompileResultCacheImpl",
    "FunctionCache",
    "cgutils",
    "dumps",
    "infer_global",
    "intrinsic",
    "ir",
    "lower_builtin",
    "models",
    "overload",
    "register_model",
    "set_cache",
    "signature",
    "types",
]


def set_cache(dispatcher: Any, cache: FunctionCache) -> None:
    """Make a compiled function use `cache` for its machine code.

    Parameters
    ----------
    dispatcher : numba dispatcher
        Result of ``numba.njit`` for a function.
    cache : FunctionCache
        Its cache.
    """
    dispatcher._cache = cache
