"""Files that are either complete or absent, digests of files, and safe names of files."""

import functools
import hashlib
import os
import re
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib import metadata
from pathlib import Path

# longest name derived from data, in bytes; prefix and suffix keep the total below 255
_LONGEST_BYTES = 180
# suffix of the temporary files next to the files being written
_TEMPORARY = ".narx-"
# device names that are reserved on Windows, with any suffix
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\.|$)", re.IGNORECASE)


def safe_name(text: str, longest: int = 60) -> str:
    """Convert a name from a file, a folder or a configuration to one that is safe in a path.

    Parameters
    ----------
    text : str
        Any text.
    longest : int
        Largest number of letters; a longer name is cut, and its last eight are a hash of the rest.

    Returns
    -------
    str
        Letters, digits, blanks and ``_ - + .``; no dot or blank at either end, no reserved name,
        at most `longest` letters and 180 bytes, never empty. A safe name is returned unchanged.
    """
    kept = re.sub(r"[^\w +.-]", "_", text).strip(". ")
    if len(kept) > longest or len(os.fsencode(kept)) > _LONGEST_BYTES:
        digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:7]
        kept = kept[: longest - 8]
        while len(os.fsencode(kept)) > _LONGEST_BYTES - 8:
            kept = kept[:-1]
        kept = f"{kept}-{digest}"
    if _RESERVED.match(kept):
        kept = f"_{kept}"
    return kept or "unnamed"


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` if the block succeeds.

    Parameters
    ----------
    path : path-like
        Final name. Its folder is created. The temporary name keeps the suffix, because
        writers (matplotlib, numpy) choose the format by it.

    Yields
    ------
    pathlib.Path
        Path to write to. It is removed if the block raises, so no partial file remains.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=_TEMPORARY, suffix=target.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp creates a private file; set the permissions of any other new file
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def remove_temporaries(folder: str | os.PathLike[str], unused_s: float = 0.0) -> None:
    """Remove temporary files of `atomic_path` left by killed processes.

    Parameters
    ----------
    folder : path-like
        Folder to search, with all its subfolders.
    unused_s : float
        Only files that have not changed for this time are removed, s; 0 if no other process
        writes to the folder.
    """
    for path in Path(folder).rglob(f"{_TEMPORARY}*"):
        # another process may have finished or removed it
        with suppress(FileNotFoundError):
            if time.time() - path.stat().st_mtime >= unused_s:
                path.unlink()


def sha256_of(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file's content.

    Parameters
    ----------
    path : path-like
        File to read.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def files_sha256(folder: str | os.PathLike[str], files: Iterable[Path]) -> str:
    """Digest names and contents of files below a folder.

    Parameters
    ----------
    folder : path-like
        Folder that the names are relative to.
    files : iterable of pathlib.Path
        Files to read; what is no file is left out.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    root = Path(folder)
    for path in files:
        if path.is_file():
            status = path.stat()
            content = _sha256_once(path.resolve(), status.st_size, status.st_mtime_ns)
            digest.update(f"{path.relative_to(root).as_posix()}\0{content}\0".encode())
    return digest.hexdigest()


@functools.cache
def _sha256_once(path: Path, size: int, mtime_ns: int) -> str:
    # cached, since the jobs of a sweep digest the same large files
    return sha256_of(path)


def code_sha256(paths: Iterable[Path], packages: Iterable[str]) -> str:
    """Digest source code and the versions of the packages that it uses.

    Parameters
    ----------
    paths : iterable of pathlib.Path
        Files, and folders that are read recursively, linked ones too: ``*.py``, and
        ``*.pt`` for the network included in the package.
    packages : iterable of str
        Installed distributions.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for top in paths:
        for path in [top] if top.is_file() else sorted(_files_below(top)):
            if path.suffix in (".py", ".pt"):
                digest.update(path.relative_to(top.parent).as_posix().encode() + b"\0")
                digest.update(path.read_bytes() + b"\0")
    for name in packages:
        digest.update(f"{name} {metadata.version(name)}\0".encode())
    return digest.hexdigest()


def _files_below(folder: Path) -> Iterator[Path]:
    for parent, _, names in os.walk(folder, followlinks=True):
        yield from (Path(parent, name) for name in names)
