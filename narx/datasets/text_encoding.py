"""Encodings of text files."""

import re
from pathlib import Path

from narx.errors import RecordingError


def decoded(path: Path, data: bytes) -> tuple[str, list[str]]:
    """Decode a text.

    Parameters
    ----------
    path : pathlib.Path
        The file, for messages.
    data : bytes
        All of it: UTF-8, UTF-16 or UTF-32, with or without byte order mark, or Windows 1252.

    Returns
    -------
    text : str
        Without a mark, and without the sign of the end of a file in DOS.
    notes : list of str
        The encoding, unless it is UTF-8.

    Raises
    ------
    RecordingError
        If it is none of these.
    """
    if data.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        encoding = "utf-32"
    elif data.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif data[1:200:2].count(0) > 40 and not data[0:200:2].count(0):
        encoding = "utf-16-le"
    elif data[0:200:2].count(0) > 40 and not data[1:200:2].count(0):
        encoding = "utf-16-be"
    else:
        encoding = "utf-8-sig"
    notes = [] if encoding == "utf-8-sig" else [encoding[:6].upper()]
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding != "utf-8-sig" or re.search(rb"[\x00-\x08\x0e-\x1f]", data):
            raise RecordingError(f"{path}: cannot be read as text ({error})") from None
        # a degree sign or a name with an accent in the code page of a Western Windows
        text, notes = data.decode("cp1252", errors="replace"), ["code page 1252"]
    if "\0" in text:
        raise RecordingError(f"{path}: cannot be read as text (a zero byte)")
    # a minus sign of typography
    return text.rstrip("\x1a").replace("\u2212", "-"), notes
