"""The closed loop in C, if there is a compiler: a benchmark for the engine."""

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from narx.types import FloatArray

Work = Callable[[], Any]

_POINTER = ctypes.POINTER(ctypes.c_double)


class CompiledC:
    """The recurrence in C, compiled for this machine.

    Parameters
    ----------
    folder : Path
        Folder for the library.
    """

    def __init__(self, folder: Path) -> None:
        library = folder / "speed_peer.so"
        source = Path(__file__).with_name("peer.c")
        command = [
            "gcc",
            "-O3",
            "-march=native",
            "-shared",
            "-fPIC",
            "-o",
            str(library),
            str(source),
        ]
        subprocess.run(command, check=True, capture_output=True)
        self._library = ctypes.CDLL(str(library))

    @staticmethod
    def available() -> bool:
        """Return whether there is a compiler.

        Returns
        -------
        bool
            True if gcc is on the path.
        """
        return shutil.which("gcc") is not None

    def closed_loop_products(self, w: FloatArray, v: FloatArray, target: FloatArray) -> Work:
        """Accumulate the normal equations of the closed loop.

        Parameters
        ----------
        w : ndarray, shape (19,)
            Weights.
        v, target : ndarray, shape (N,)
            Input and target.

        Returns
        -------
        callable
            Returns products (24, 24), row 19 belongs to the residuals.
        """
        products = np.zeros((24, 24))
        arguments = [_pointer(w), _pointer(v), _pointer(target), ctypes.c_long(len(v))]

        def work() -> FloatArray:
            self._library.closed_loop_products(*arguments, _pointer(products))
            return products

        return work

    def rollout(self, w: FloatArray, v: FloatArray) -> Work:
        """Run channels.

        Parameters
        ----------
        w : ndarray, shape (19,)
            Weights.
        v : ndarray, shape (channels, N)
            Inputs.

        Returns
        -------
        callable
            Returns the outputs.
        """
        outputs = np.empty_like(v)
        n_channels, n = (ctypes.c_long(size) for size in v.shape)

        def one() -> FloatArray:
            self._library.rollout(_pointer(w), _pointer(v), n, _pointer(outputs))
            return outputs

        def many() -> FloatArray:
            arguments = _pointer(w), _pointer(v), n_channels, n, _pointer(outputs)
            self._library.rollout_many(*arguments)
            return outputs

        return one if len(v) == 1 else many


def _pointer(array: FloatArray) -> Any:
    return array.ctypes.data_as(_POINTER)
