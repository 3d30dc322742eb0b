"""Cache on disk of trials that have been simulated or read, and calibrated."""

import contextlib
import functools
import hashlib
import inspect
import os
import pickle
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import pandas as pd
from filelock import FileLock

from narx.calibration.calibrate import CalibratedSegment, Mode
from narx.datasets.base import TrialSource
from narx.files import atomic_path, code_sha256
from narx.recordings.trial import Trial

T = TypeVar("T")

# all code on which a prepared trial depends; tests/narx/datasets/test_prepared.py checks that it is
# complete
ROOMS = (
    "errors.py", "files.py", "types.py", "missing.py", "method.py", "recursion.py", "kernels",
    "settings", "kinematics", "recordings", "simulation", "gait", "calibration", "datasets",
)  # fmt: skip
_NUMERICS = ("numpy", "scipy", "pandas", "numba")
# an older temporary file was left by a killed process
_ABANDONED_S = 3600.0


@dataclass(frozen=True)
class TrialStore:
    """Store of prepared trials, shared by all processes of a user.

    Parameters
    ----------
    folder : pathlib.Path
        Folder of the files.
    limit_bytes : float
        Size limit; the least recently used trials are deleted first.
    """

    folder: Path
    limit_bytes: float

    def get(self, key: str, make: Callable[[], T]) -> T:
        """Return the value stored under a key, or compute and store it.

        Parameters
        ----------
        key : str
            Letters and digits.
        make : callable
            Computes the value; other processes that need the same key wait.

        Returns
        -------
        object
            The value.
        """
        path = self.folder / f"{key}.pickle"
        with contextlib.suppress(LookupError):
            stored: T = self._read(path)
            return stored
        self.folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(self.folder / f"{key}.lock")
        with lock:
            with contextlib.suppress(LookupError):  # computed by the process that had the lock
                stored = self._read(path)
                return stored
            value = make()
            # if the disk is full, the result is only not cached
            with (
                contextlib.suppress(OSError),
                atomic_path(path) as temporary,
                temporary.open("wb") as stream,
            ):
                pickle.dump(value, stream, protocol=pickle.HIGHEST_PROTOCOL)
            self._trim()
            Path(lock.lock_file).unlink(missing_ok=True)
        return value

    def _read(self, path: Path) -> Any:
        try:
            with path.open("rb") as stream:
                value = pickle.load(stream)
            os.utime(path)
        except FileNotFoundError:
            raise LookupError(path) from None
        except Exception as error:  # a damaged pickle may raise any exception
            path.unlink(missing_ok=True)
            raise LookupError(path) from error
        return value

    def _trim(self) -> None:
        taken = 0.0
        found = []
        for path in self.folder.glob("*.pickle"):
            try:
                found.append((path.stat().st_mtime, path.stat().st_size, path))
            except FileNotFoundError:
                continue  # another process is trimming
        for changed_s, size, path in sorted(found, reverse=True):
            abandoned = path.name.startswith(".")
            if abandoned and time.time() - changed_s < _ABANDONED_S:
                continue
            taken += size
            if abandoned or taken > self.limit_bytes:
                path.unlink(missing_ok=True)


@functools.cache
def _preparing_code() -> str:
    package = Path(__file__).parents[1]
    return code_sha256((package / room for room in ROOMS), _NUMERICS)


class PreparedSource(TrialSource):
    """A source whose calibrated trials are cached in a store.

    Parameters
    ----------
    source : TrialSource
        Reads or simulates trials that are not in the store.
    options : str
        Everything besides the code on which its trials depend: options, digest of the recordings.
    store : TrialStore
        Stores the trials.
    """

    name: ClassVar[str] = "prepared"

    def __init__(self, source: TrialSource, options: str, store: TrialStore) -> None:
        self.name = source.name  # type: ignore[misc]  # messages are the source's own
        self._source = source
        self._store = store
        own_file = inspect.getsourcefile(type(source))
        own_code = "" if own_file is None else Path(own_file).read_text(encoding="utf-8")
        self._identity = "\0".join([_preparing_code(), own_code, options])

    def _list_trials(self) -> pd.DataFrame:
        return self._source.index()

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        return self._source.load(subject, condition, trial)

    def _load_calibrated(
        self, subject: str, condition: str, trial: str, mode: Mode
    ) -> tuple[Trial, dict[str, CalibratedSegment]]:
        names = "\0".join([self._identity, subject, condition, trial, mode])
        key = hashlib.sha256(names.encode()).hexdigest()
        return self._store.get(
            key, lambda: self._source.load_calibrated(subject, condition, trial, mode)
        )
