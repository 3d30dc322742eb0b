"""How far a training has come, on disk, so that one that was cut off goes on from there."""

import hashlib
import threading
import time
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import torch
from torch import Tensor

from narx.files import atomic_path

# between two states of a part: short trainings write nothing, long ones lose no more than this
INTERVAL_S = 10.0

State = dict[str, Any]


class Progress:
    """State of one training: optimiser, weights and what was logged, by part.

    A part is what is trained at a time, such as a group of starts. The file is replaced in one
    piece, and read with ``weights_only=True``.

    Parameters
    ----------
    path : pathlib.Path, optional
        File of the state; None keeps nothing.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._parts = {} if path is None else _read(path)
        self._lock = threading.Lock()
        self._kept_s: dict[str, float] = {}
        self._begun_s = time.monotonic()

    def of(self, part: str) -> State | None:
        """Return the state of a part when the training was cut off.

        Parameters
        ----------
        part : str
            Name of the part.

        Returns
        -------
        dict or None
            As given to `keep`, arrays as tensors; None if there is none.
        """
        return self._parts.get(part)

    def keep(self, part: str, state: Callable[[], State]) -> None:
        """Write the state of a part, unless one was written less than `INTERVAL_S` ago.

        Parameters
        ----------
        part : str
            Name of the part.
        state : callable
            Returns numbers, strings, arrays and tensors, in dictionaries and lists. What is
            not to be drawn again from the training's seed must be among them.
        """
        now_s = time.monotonic()
        due = now_s - self._kept_s.get(part, self._begun_s) >= INTERVAL_S
        if self._path is None or not due:
            return
        with self._lock:  # parts may be trained in threads
            self._kept_s[part] = now_s
            self._parts[part] = _copied(state())
            with atomic_path(self._path) as temporary:
                torch.save(self._parts, temporary)


def fingerprint(settings: Iterable[object], tensors: Iterable[Tensor]) -> str:
    """Digest what the result of a training depends on.

    Parameters
    ----------
    settings : iterable of object
        By their `repr`.
    tensors : iterable of Tensor
        By their content.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for setting in settings:
        digest.update(f"{setting!r}\0".encode())
    for tensor in tensors:
        digest.update(f"{tuple(tensor.shape)}\0".encode())
        digest.update(np.ascontiguousarray(tensor.detach().numpy()).data)
    return digest.hexdigest()


def _read(path: Path) -> dict[str, State]:
    try:
        parts: dict[str, State] = torch.load(path, weights_only=True)
    except FileNotFoundError:
        return {}
    except (OSError, EOFError, RuntimeError, UnpicklingError, zipfile.BadZipFile):
        return {}  # a damaged disk costs the time since the start, not the training
    return parts


def _copied(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return torch.tensor(value)
    if isinstance(value, Tensor):
        return value.detach().clone()
    if isinstance(value, dict):
        return {key: _copied(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_copied(one) for one in value)
    return value
