"""Keep numba's cache true: any change of any kernel recompiles them all.

Numba looks at the file of the function it loads, not at the files of what that function calls,
so a changed helper would leave stale machine code behind. Here the stamp of each cached kernel
is a digest of this whole folder.
"""

import functools
import hashlib
from pathlib import Path
from typing import Any

from numba.core import caching

_FOLDER = Path(__file__).resolve().parent
# its name has lost its underscore
_LOCATORS: Any = getattr(caching, "CacheImpl", None) or getattr(caching, "_CacheImpl")  # noqa: B009


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


class _KernelLocator:
    """Where numba would put the cache of a kernel, but stamped by the whole folder."""

    def __init__(self, usual: Any) -> None:
        self._usual = usual

    def __getattr__(self, name: str) -> Any:
        return getattr(self._usual, name)

    def get_source_stamp(self) -> str:
        return sources_digest()

    @classmethod
    def from_function(cls, function: Any, file: str) -> Any:
        if Path(file).resolve().parent != _FOLDER:
            return None
        for locator in _LOCATORS._locator_classes:
            if locator is not cls:
                usual = locator.from_function(function, file)
                if usual is not None:
                    return cls(usual)
        return None


def stamp_by_folder() -> None:
    """Let numba ask `_KernelLocator` first; other packages' functions are left alone."""
    locators = _LOCATORS._locator_classes
    if _KernelLocator not in locators:
        locators.insert(0, _KernelLocator)
