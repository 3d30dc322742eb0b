"""Arrays in a MATLAB file, with an error that names the file and the field."""

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from narx.errors import RecordingError
from narx.recordings.input_file import check_memory, limit_mib, regular_file
from narx.types import FloatArray

# of the format (MATLAB, "MAT-File Format", level 5)
_HEADER_BYTES, _COMPRESSED = 128, 15
_PIECE = 2**16
# doubles that are whole numbers are stored in a byte each
_MEMORY_PER_BYTE = 8


def read_mat(path: Path) -> dict[str, Any]:
    """Read the variables of a MATLAB 5 file.

    Parameters
    ----------
    path : pathlib.Path
        File to read.

    Returns
    -------
    dict of str to object
        Arrays, and structs as objects with attributes; MATLAB's own entries are left out.

    Raises
    ------
    RecordingError
        If the file is missing, cut off, not a MATLAB file, or needs too much memory.
    """
    _check_unpacked(regular_file(path))
    try:
        variables = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except Exception as error:  # the exception depends on the damage
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordingError(
            f"{path}: not a whole MATLAB file ({reason}); cut off? expected a version 5 .mat file"
        ) from None
    return {name: value for name, value in variables.items() if not name.startswith("__")}


def _check_unpacked(path: Path) -> None:
    """Unpack the compressed variables piece by piece, and refuse more than fits in memory."""
    limit = limit_mib() * 2**20 / _MEMORY_PER_BYTE
    unpacked = 0
    with path.open("rb") as stream:
        order = {b"IM": "<", b"MI": ">"}.get(stream.read(_HEADER_BYTES)[-2:])
        while order is not None and len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != _COMPRESSED:
                stream.seek(size, 1)
                continue
            unpacker, left = zlib.decompressobj(), size
            while left > 0 and (piece := stream.read(min(left, _PIECE))):
                left -= len(piece)
                while piece:
                    try:
                        unpacked += len(unpacker.decompress(piece, _PIECE))
                    except zlib.error:
                        return  # damaged: scipy says where
                    piece = unpacker.unconsumed_tail
                    if unpacked > limit:
                        check_memory(path, unpacked * _MEMORY_PER_BYTE)


def numeric_field(path: Path, variables: dict[str, Any], name: str) -> FloatArray:
    """Look up a numeric field, ``struct.field.field`` with dots.

    Parameters
    ----------
    path : pathlib.Path
        File that the variables are from, for the message.
    variables : dict
        As from `read_mat`.
    name : str
        Field to look up.

    Returns
    -------
    ndarray
        The field as float.

    Raises
    ------
    RecordingError
        If the field is missing or not numeric.
    """
    first, *rest = name.split(".")
    if first not in variables:
        raise RecordingError(f"{path}: no variable '{first}'; found {', '.join(variables)}")
    value = variables[first]
    for part in rest:
        if not hasattr(value, part):
            found = ", ".join(getattr(value, "_fieldnames", [])) or type(value).__name__
            raise RecordingError(f"{path}: no field '{name}' (at '{part}'); found {found}")
        value = getattr(value, part)
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise RecordingError(f"{path}: field '{name}' is not numeric") from None
