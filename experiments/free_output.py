"""Output never replaces what was read."""

from collections.abc import Iterable
from pathlib import Path

from narx.errors import UserError


def check_free(written: Iterable[Path], sources: Iterable[Path], what: str = "input") -> None:
    """Refuse output that would replace a folder, or a file that is read.

    Parameters
    ----------
    written : iterable of pathlib.Path
        Files that will be written.
    sources : iterable of pathlib.Path
        Files that are read.
    what : str
        What the sources are, for the message.

    Raises
    ------
    UserError
        If a file to write is a folder, or one of the sources.
    """
    sources = [source for source in sources if source.exists()]
    for path in written:
        if path.is_dir():
            raise UserError(f"output: '{path}' is a folder, expected another name")
        if path.exists() and any(path.samefile(source) for source in sources):
            raise UserError(f"output: '{path}' is also the {what}, expected another name")
