"""C: one ISO C99 file and its header, for a microcontroller or any other language."""

import ctypes
import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from string import Template

import numpy as np

import narx
from narx.errors import UserError
from narx.export.c_values import values_of
from narx.inference.checkpoint import Checkpoint
from narx.types import FloatArray

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC")


def build(checkpoint: Checkpoint, precision: str) -> dict[str, str]:
    """Write a network with its start-up as C.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    precision : {"double", "float"}
        Type of all numbers.

    Returns
    -------
    dict of str to str
        Source and header by their suffixes, for `stamped`.
    """
    kind = "start_up" if checkpoint.tracker is None else "tracked"
    values = values_of(checkpoint, precision) | {
        "title": f"NARX orientation network at {checkpoint.model.sampling_rate_hz:g} Hz",
        "version": narx.__version__,
        "sha256": checkpoint.sha256,
    }

    def filled(name: str, **more: str) -> str:
        text = (resources.files("narx.export") / name).read_text(encoding="utf-8")
        return Template(text).safe_substitute(values, **more)

    covariance = filled("covariance_tracked.c") if kind == "tracked" else ""
    recurrence = filled(f"recurrence_{kind}.c", covariance=covariance)
    return {
        ".c": filled("template.c", recurrence=recurrence),
        ".h": filled("template.h", fields=filled(f"recurrence_{kind}.h")),
    }


def stamped(sources: dict[str, str], name: str, identity: str) -> dict[str, str]:
    """Insert the file names and the identity into the sources.

    Parameters
    ----------
    sources : dict of str to str
        From `build`.
    name : str
        Name of the files, without suffix.
    identity : str
        Identity for the header (`narx.export.identity`).

    Returns
    -------
    dict of str to str
        Content by file name.
    """
    values = {
        "header": f"{name}.h",
        "guard": re.sub(r"\W", "_", f"NARX_{name}_H").upper(),
        "identity": json.dumps(identity),
    }
    return {
        f"{name}{suffix}": Template(source).substitute(values) for suffix, source in sources.items()
    }


def compiler() -> str:
    """Find a C compiler.

    Returns
    -------
    str
        Its path.

    Raises
    ------
    UserError
        If there is none.
    """
    for name in COMPILERS:
        found = shutil.which(name)
        if found:
            return found
    raise UserError(
        f"format=c is compiled for verification; no C compiler ({', '.join(COMPILERS)}) was found: "
        "install one, or write unchecked with verify=false"
    )


def loaded(files: dict[str, str]) -> Callable[..., FloatArray]:
    """Compile the code to run it over recordings.

    Parameters
    ----------
    files : dict of str to str
        From `stamped`.

    Returns
    -------
    callable
        From inputs (B, N, 3 or 6) as ``narx_step_after`` takes them, in the precision of the code,
        times since the samples before (B, N), s, and known start poses (B, 3) or None to angles
        (B, N, 3), rad.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (Path(folder) / name).write_text(content, encoding="utf-8")
        source = next(name for name in files if name.endswith(".c"))
        command = [compiler(), *FLAGS, source, "-o", "narx.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        library = ctypes.CDLL(str(Path(folder) / "narx.so"))
    library.narx_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]

    def run(inputs: FloatArray, interval_s: FloatArray, start: FloatArray | None) -> FloatArray:
        real = ctypes.c_float if inputs.dtype == np.float32 else ctypes.c_double
        library.narx_step_after.argtypes = [ctypes.c_void_p, real, ctypes.c_void_p, ctypes.c_void_p]
        inputs = np.ascontiguousarray(inputs)
        angles = np.empty((*inputs.shape[:2], 3), inputs.dtype)
        for sensor in range(len(inputs)):
            # more than any state needs
            state = ctypes.create_string_buffer(1 << 16)
            pose = None if start is None else np.ascontiguousarray(start[sensor], inputs.dtype)
            library.narx_start(state, None if pose is None else pose.ctypes.data)
            into, out = inputs[sensor].ctypes.data, angles[sensor].ctypes.data
            for k, interval in enumerate(interval_s[sensor].tolist()):
                library.narx_step_after(
                    state, interval, into + k * inputs.strides[1], out + k * angles.strides[1]
                )
        return angles

    return run
