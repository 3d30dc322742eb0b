"""Cache of machine code on disk that is never stale and never causes errors.

Numba checks the file of the function it loads, not the files of the functions it calls, so machine
code would be stale after a change to a helper. Here the stamp of every kernel is a digest of this
whole folder, which imports nothing from the rest of the package. If the cache cannot be read,
kernels are compiled again; if it cannot be written, they are compiled in memory.
"""

import functools
import hashlib
import logging
import pickle
import warnings
from pathlib import Path
from typing import Any

from narx.kernels.numba_internals import (
    CompileResultCacheImpl,
    FunctionCache,
    dumps,
    set_cache,
)

_FOLDER = Path(__file__).resolve().parent
_LOG = logging.getLogger(__name__)


@functools.cache
def sources_digest() -> str:
    """Digest of the sources of all kernels.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for path in sorted(_FOLDER.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


@functools.cache
def _warn_of_no_cache() -> None:
    warnings.warn(
        "narx: no writable folder for compiled code, so it is compiled in memory, in "
        "every process again (up to a minute); set the environment variable NUMBA_CACHE_DIR to a "
        "writable folder",
        RuntimeWarning,
        stacklevel=2,
    )


@functools.cache
def _announce_compiling() -> None:
    _LOG.info("compiling loops for this processor, up to half a minute; later runs load them")


class _StampedAndSealed(CompileResultCacheImpl):
    """Numba's cache of one function, with a stamp and a checksum of the machine code."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.locator.get_source_stamp = sources_digest

    def reduce(self, data: Any) -> Any:
        payload = dumps(super().reduce(data))
        return hashlib.sha256(payload).digest(), payload

    def rebuild(self, target_context: Any, reduced_data: Any) -> Any:
        checksum, payload = reduced_data
        if hashlib.sha256(payload).digest() != checksum:
            raise pickle.UnpicklingError("the checksum does not match")
        return super().rebuild(target_context, pickle.loads(payload))


class _KernelCache(FunctionCache):
    """A cache whose failures cost time, not results."""

    _impl_class = _StampedAndSealed

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # a damaged pickle may raise any exception
            found = None
            try:
                self.flush()
            except OSError:
                self.disable()
        if found is None:
            _announce_compiling()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError:  # disk full, or folder no longer writable
            self.disable()
            _warn_of_no_cache()


def keep_on_disk(dispatcher: Any) -> None:
    """Cache a compiled function on disk, if there is a writable folder.

    Parameters
    ----------
    dispatcher : numba dispatcher
        Result of ``numba.njit`` for a function of this folder.

    Raises
    ------
    ValueError
        If the function is defined elsewhere, where `sources_digest` would miss a change.
    """
    function = dispatcher.py_func
    if Path(function.__code__.co_filename).resolve().parent != _FOLDER:
        raise ValueError(f"{function.__qualname__}: compiled functions belong in {_FOLDER}")
    try:
        cache = _KernelCache(function)
    except RuntimeError:  # numba has found no folder
        _warn_of_no_cache()
    else:
        set_cache(dispatcher, cache)
