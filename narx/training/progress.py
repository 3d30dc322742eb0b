"""State of an unfinished training on disk, from which an interrupted training continues."""

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

# time between two stored states of a part: short trainings store none, long ones lose at most this
INTERVAL_S = 10.0

State = dict[str, Any]


class Progress:
    """State of one training: optimiser, weights and logged numbers, by part.

    A part is a unit of training, such as a group of starts. The file is replaced atomically, and
    read with ``weights_only=True``.

    Parameters
    ----------
    path : pathlib.Path, optional
        File of the state; None stores nothing.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._parts = {} if path is None else _read(path)
        self._lock = threading.Lock()
        self._kept_s: dict[str, float] = {}
        self._begun_s = time.monotonic()

    def of(self, part: str) -> State | None:
        """Return the last stored state of a part.

        Parameters
        ----------
        part : str
            Name of the part.

        Returns
        -------
        dict or None
            State as given to `keep`, with arrays as tensors; None if there is none.
        """
        return self._parts.get(part)

    def keep(self, part: str, state: Callable[[], State]) -> None:
        """Store the state of a part, unless one was stored less than `INTERVAL_S` ago.

        Parameters
        ----------
        part : str
            Name of the part.
        state : callable
            Returns numbers, strings, arrays and tensors, in dictionaries and lists. It must include
            everything that cannot be reproduced from the training's seed.
        """
        now_s = time.monotonic()
        due = now_s - self._kept_s.get(part, self._begun_s) >= INTERVAL_S
        if self._path is None or not due:
            return
        with self._lock:  # parts may be trained in several threads
            self._kept_s[part] = now_s
            self._parts[part] = _copied(state())
            with atomic_path(self._path) as temporary:
                torch.save(self._parts, temporary)


def fingerprint(settings: Iterable[object], tensors: Iterable[Tensor]) -> str:
    """Compute a digest of everything on which the result of a training depends.

    Parameters
    ----------
    settings : iterable of object
        Included by their `repr`.
    tensors : iterable of Tensor
        Included by their content.

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
        return {}  # an unreadable state is ignored: the training starts again
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
