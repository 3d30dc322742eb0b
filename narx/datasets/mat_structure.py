"""Structure of a MATLAB 5 file, checked before scipy reads it.

scipy's compiled reader takes the type of a data element as an index without a check, so that a
damaged type ends the process. Source of the format: MATLAB, "MAT-File Format", level 5.
"""

import mmap
import struct
import zlib
from pathlib import Path

from narx.recordings.input_file import check_memory, limit_mib

_HEADER_BYTES, _TAG_BYTES = 128, 8
_MATRIX, _COMPRESSED = 14, 15
_TYPES = frozenset({1, 2, 3, 4, 5, 6, 7, 9, 12, 13, _MATRIX, _COMPRESSED, 16, 17, 18})
_DEEPEST = 32
_PIECE = 2**16
# doubles that are whole numbers are stored in a byte each
_MEMORY_PER_BYTE = 8


def check_structure(path: Path) -> None:
    """Check types and sizes of all data elements; files of other versions are left alone.

    Parameters
    ----------
    path : pathlib.Path
        Existing file.

    Raises
    ------
    ValueError
        If the file is damaged; says where.
    RecordingError
        If it unpacks to more than fits in memory.
    """
    with path.open("rb") as stream:
        header = stream.read(_HEADER_BYTES)
        if len(header) < _HEADER_BYTES or 0 in header[:4]:  # empty, or version 4
            return
        order = {b"IM": "<", b"MI": ">"}.get(header[-2:])
        if order is None:
            raise ValueError("no byte order in the header")
        if struct.unpack(f"{order}H", header[124:126])[0] != 0x100:  # HDF5
            return
        if not stream.read(1):
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
            unpacked = 0
            for kind, begin, end in _elements(content, _HEADER_BYTES, len(content), order):
                if kind == _COMPRESSED:
                    variable = _unpacked(path, content, begin, end, unpacked)
                    unpacked += len(variable)
                    _walk(variable, 0, len(variable), order)
                elif kind == _MATRIX:
                    _walk(content, begin, end, order)


def _elements(
    content: bytes | mmap.mmap, begin: int, end: int, order: str
) -> list[tuple[int, int, int]]:
    """Type, begin and end of the elements in a part of a file."""
    found = []
    while begin + _TAG_BYTES <= end:
        kind, size = struct.unpack_from(f"{order}II", content, begin)
        at = begin + _TAG_BYTES
        if kind >> 16:  # a small element: size, type and data share eight bytes
            kind, size, at = kind & 0xFFFF, kind >> 16, begin + 4
            if size > 4:
                raise ValueError(f"small data element of {size} bytes at byte {begin}")
        if kind not in _TYPES:
            raise ValueError(f"data element of unknown type {kind} at byte {begin}")
        if at + size > end:
            raise ValueError(
                f"data element of {size} bytes at byte {begin} is longer than its file"
            )
        found.append((kind, at, at + size))
        small = at == begin + 4
        padded = size if kind == _COMPRESSED else -(-size // 8) * 8
        begin = begin + _TAG_BYTES if small else at + padded
    return found


def _walk(content: bytes | mmap.mmap, begin: int, end: int, order: str, depth: int = 0) -> None:
    if depth > _DEEPEST:
        raise ValueError(f"variables nested more than {_DEEPEST} deep")
    for kind, first, last in _elements(content, begin, end, order):
        if kind == _COMPRESSED:
            raise ValueError(f"compressed data element within a variable at byte {first}")
        if kind == _MATRIX:
            _walk(content, first, last, order, depth + 1)


def _unpacked(path: Path, content: mmap.mmap, begin: int, end: int, before: int) -> bytes:
    """Unpack a variable, after its size has been found to fit in memory piece by piece."""
    limit = limit_mib() * 2**20 / _MEMORY_PER_BYTE
    unpacker, size = zlib.decompressobj(), before
    for at in range(begin, end, _PIECE):
        piece = content[at : min(at + _PIECE, end)]
        while piece:
            size += len(unpacker.decompress(piece, _PIECE))
            piece = unpacker.unconsumed_tail
            if size > limit:
                check_memory(path, size * _MEMORY_PER_BYTE)
    return zlib.decompress(content[begin:end])
