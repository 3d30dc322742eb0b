"""Checks before reading an input file."""

import os
import stat
from pathlib import Path

from narx.errors import RecordingError, UserError

# limit of what reading a single file may ask for; the environment variable raises it
LIMIT_VARIABLE = "NARX_MAX_MEMORY_MIB"
_LIMIT_MIB = 4096.0
# the square of a larger number, as of a damaged byte in an exponent, overflows
LARGEST_NUMBER = 1e100


def regular_file(path: str | os.PathLike[str]) -> Path:
    """Refuse a path that is not a readable file, before reading blocks or fills the memory.

    Parameters
    ----------
    path : path-like
        File to read.

    Returns
    -------
    pathlib.Path
        The same path.

    Raises
    ------
    RecordingError
        If the path does not exist, or is a folder, a pipe, a device, a loop of links, or has more
        than ``NARX_MAX_MEMORY_MIB`` (default 4096) MiB.
    """
    file = Path(path)
    try:
        status = file.stat()
    except FileNotFoundError:
        raise RecordingError(f"{file}: no such file") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise RecordingError(f"{file}: cannot be opened ({reason})") from None
    if not stat.S_ISREG(status.st_mode):
        raise RecordingError(f"{file}: is {_kind(status.st_mode)}, expected a file")
    check_memory(file, status.st_size)
    return file


def check_memory(path: Path, needed_bytes: float) -> None:
    """Refuse a file that asks for too much memory, before it is allocated.

    Parameters
    ----------
    path : pathlib.Path
        The file, for the message.
    needed_bytes : float
        What reading it takes.

    Raises
    ------
    RecordingError
        If that is more than ``NARX_MAX_MEMORY_MIB`` (default 4096) MiB.
    """
    limit = limit_mib()
    if needed_bytes > limit * 2**20:
        raise RecordingError(
            f"{path}: needs {needed_bytes / 2**20:.0f} MiB of memory, more than the limit of "
            f"{limit:g} MiB; set the environment variable {LIMIT_VARIABLE} to read it anyway"
        )


def is_bundle(path: Path) -> bool:
    """Tell whether a folder is one recording of a phone app, with a file per sensor.

    Parameters
    ----------
    path : pathlib.Path
        Any path.

    Returns
    -------
    bool
        True for a folder with the gyroscope's file.
    """
    try:
        return path.is_dir() and any(path.glob("Gyroscope*.csv"))
    except (OSError, ValueError):
        return False


def _kind(mode: int) -> str:
    if stat.S_ISDIR(mode):
        return "a folder"
    if stat.S_ISFIFO(mode):
        return "a pipe"
    return "a socket" if stat.S_ISSOCK(mode) else "a device"


def limit_mib() -> float:
    """Return the limit of the memory that reading a single file may take.

    Returns
    -------
    float
        MiB.

    Raises
    ------
    UserError
        If the environment variable is not a positive number.
    """
    value = os.environ.get(LIMIT_VARIABLE, str(_LIMIT_MIB))
    try:
        limit = float(value)
    except ValueError:
        limit = 0.0
    if not limit > 0:
        raise UserError(f"{LIMIT_VARIABLE} is '{value}', expected a positive number of MiB")
    return limit
