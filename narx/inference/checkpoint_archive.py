"""Plain data in torch's file format, read without running code or large allocations from the file.

``torch.load(weights_only=True)`` runs no code from the file, but a small file can still make it
allocate gigabytes, by a compressed record or a call of ``bytearray``. The archive is therefore
checked before torch unpacks it.
"""

import hashlib
import io
import json
import os
import pickletools
import zipfile
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

# a checkpoint has about ten kilobytes
MAX_BYTES = 16 * 2**20
_MAX_ITEMS = 100_000
# names in a pickle of dictionaries, lists, strings, numbers and float64 tensors
_NAMES = {"torch._utils _rebuild_tensor_v2", "torch DoubleStorage", "collections OrderedDict"}


def to_bytes(content: dict[str, Any]) -> bytes:
    """Pack plain data.

    Parameters
    ----------
    content : dict
        Numbers, strings, lists, dictionaries and float64 tensors.

    Returns
    -------
    bytes
        Archive; equal contents give equal bytes.
    """
    # in memory, since torch stores the path of a file in its content
    buffer = io.BytesIO()
    torch.save(content, buffer)
    return buffer.getvalue()


def from_file(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Unpack plain data.

    Parameters
    ----------
    path : path-like
        File with the output of `to_bytes`.

    Returns
    -------
    dict
        The content.

    Raises
    ------
    ValueError
        If the file is damaged, too large, or has other content.
    """
    size = Path(path).stat().st_size
    if size > MAX_BYTES:
        raise ValueError(f"it has {size} bytes, expected at most {MAX_BYTES}")
    data = Path(path).read_bytes()
    _check_archive(data)
    try:
        content = torch.load(io.BytesIO(data), weights_only=True)
    except Exception as error:  # any exception; its messages advise unsafe loading
        raise ValueError("its pickle is damaged") from error
    if not isinstance(content, dict):
        raise ValueError(f"it holds a {type(content).__name__}, expected a dictionary")
    check_plain(content)
    return content


def digest(content: dict[str, Any]) -> str:
    """Hash the content, independently of its packing.

    Parameters
    ----------
    content : dict
        Plain data.

    Returns
    -------
    str
        SHA-256 of its JSON with sorted keys: 64 hexadecimal digits.
    """
    text = json.dumps(content, sort_keys=True, default=Tensor.tolist)
    return hashlib.sha256(text.encode()).hexdigest()


def _check_archive(data: bytes) -> None:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            records = archive.infolist()
            if any(record.compress_type != zipfile.ZIP_STORED for record in records):
                raise ValueError("it is compressed")
            if sum(record.file_size for record in records) > len(data):
                raise ValueError("its records are longer than the file")
            damaged = archive.testzip()
            if damaged is not None:
                raise ValueError(f"the checksum of '{damaged}' in it is wrong")
            pickles = [r for r in records if r.filename.endswith("/data.pkl")]
            if len(pickles) != 1:
                raise ValueError(f"it holds {len(pickles)} pickles, expected one")
            _check_pickle(archive.read(pickles[0]))
    except (zipfile.BadZipFile, zipfile.LargeZipFile, OSError, EOFError) as error:
        raise ValueError("it is not an archive, or a damaged one") from error
    except (NotImplementedError, RuntimeError) as error:  # encrypted, or of an unknown type
        raise ValueError("it is an archive of a different type") from error


def _check_pickle(data: bytes) -> None:
    try:
        for opcode, argument, _ in pickletools.genops(data):
            if "GLOBAL" in opcode.name and argument not in _NAMES:
                raise ValueError("it holds more than numbers, strings and tensors")
            if opcode.name in ("INST", "OBJ", "NEWOBJ", "NEWOBJ_EX", "BUILD", "EXT1", "EXT2"):
                raise ValueError("it holds more than numbers, strings and tensors")
    except ValueError:
        raise
    except Exception as error:
        raise ValueError("its pickle is damaged") from error


def check_plain(content: dict[str, Any]) -> None:
    """Refuse objects, and shared nested data that are small in the file but huge when traversed.

    Parameters
    ----------
    content : dict
        Content to pack, or as unpacked.

    Raises
    ------
    ValueError
        If there is other than numbers, strings, lists, dictionaries and tensors, or too much of it.
    """
    left, pending = _MAX_ITEMS, [content]
    while pending:
        value: Any = pending.pop()
        left -= value.numel() if isinstance(value, Tensor) else 1
        if left < 0:
            raise ValueError(f"it holds more than {_MAX_ITEMS} values")
        if isinstance(value, dict):
            if not all(isinstance(key, str) for key in value):
                raise ValueError("a key in it is not a string")
            pending.extend(value.values())
        elif isinstance(value, list | tuple):
            pending.extend(value)
        elif not (value is None or isinstance(value, str | int | float | bool | Tensor)):
            raise ValueError(f"it holds a {type(value).__name__}")
