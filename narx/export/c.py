"""C: one ISO C99 file and its header, for a microcontroller or any other language."""

import ctypes
import json
import math
import re
import shutil
import subprocess
import tempfile
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev, polynomial

import narx
from narx.errors import UserError
from narx.export.c_values import tracked_values
from narx.export.recurrence import refuse_own_scaling, samples_in_movement
from narx.inference.checkpoint import Checkpoint
from narx.inference.washout import washout_gain
from narx.kernels.clock import ON_TICK
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S
from narx.method import RATE_LIMIT_RAD_S, longest_gap_s
from narx.types import FloatArray

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC")
# in C, numbers and functions of a type have the same suffix
_SUFFIX = {"double": "", "float": "f"}
# neurons whose weights differ by less than this share of the largest are merged: the difference
# cancels to first order when the first layer is averaged with the weights of the second layer
_SAME = 1e-3
# range of the short series; the library's functions are used beyond it
_SINE_LIMIT_RAD, _TANH_LIMIT = 1.2, 0.12


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
    tracked = checkpoint.tracker is not None
    values_of, template = (tracked_values, "template_tracked") if tracked else (_values, "template")
    values = values_of(checkpoint, _SUFFIX[precision]) | {
        "title": f"NARX orientation network at {checkpoint.model.sampling_rate_hz:g} Hz",
        "version": narx.__version__,
        "sha256": checkpoint.sha256,
        "real": precision,
        "short_series": str(int(precision == "float")),
    }
    folder = resources.files("narx.export")
    return {
        suffix: Template(
            (folder / f"{template}{suffix}").read_text(encoding="utf-8")
        ).safe_substitute(values)
        for suffix in (".c", ".h")
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


def run(
    files: dict[str, str],
    axis_rates: FloatArray,
    interval_s: FloatArray | None,
    start: FloatArray | None,
) -> FloatArray:
    """Compile and run the code over recordings.

    Parameters
    ----------
    files : dict of str to str
        From `stamped`.
    axis_rates : ndarray, shape (B, N, 3)
        Gyroscope, rad/s, in the precision of the code.
    interval_s : ndarray, shape (B, N), or None
        Times since the previous samples, s; None to use ``narx_step``, which assumes the nominal
        interval.
    start : ndarray, shape (B, 3), or None
        Known start poses, rad.

    Returns
    -------
    ndarray, shape (B, N, 3)
        Angles, rad.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            (Path(folder) / name).write_text(content, encoding="utf-8")
        source = next(name for name in files if name.endswith(".c"))
        command = [compiler(), *FLAGS, source, "-o", "narx.so", "-lm"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        library = ctypes.CDLL(str(Path(folder) / "narx.so"))
    if interval_s is None:
        return _run_steps(library, axis_rates, start)
    real = ctypes.c_float if axis_rates.dtype == np.float32 else ctypes.c_double
    library.narx_step_after.argtypes = [ctypes.c_void_p, real, ctypes.c_void_p, ctypes.c_void_p]
    library.narx_start.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    angles = np.empty_like(axis_rates)
    for sensor in range(len(axis_rates)):
        # larger than any state
        state = ctypes.create_string_buffer(1 << 16)
        pose = None if start is None else np.ascontiguousarray(start[sensor], axis_rates.dtype)
        library.narx_start(state, None if pose is None else pose.ctypes.data)
        for k, interval in enumerate(interval_s[sensor]):
            library.narx_step_after(
                state, interval, axis_rates[sensor, k].ctypes.data, angles[sensor, k].ctypes.data
            )
    return angles


def _run_steps(library: ctypes.CDLL, inputs: FloatArray, start: FloatArray | None) -> FloatArray:
    library.narx_step.argtypes = [ctypes.c_void_p] * 3
    library.narx_start.argtypes = [ctypes.c_void_p] * 2
    angles = np.empty((*inputs.shape[:2], 3), inputs.dtype)
    for sensor in range(len(inputs)):
        state = ctypes.create_string_buffer(1 << 16)
        pose = None if start is None else np.ascontiguousarray(start[sensor], inputs.dtype)
        library.narx_start(state, None if pose is None else pose.ctypes.data)
        for sample, row in zip(inputs[sensor], angles[sensor], strict=True):
            library.narx_step(state, sample.ctypes.data, row.ctypes.data)
    return angles


def _values(checkpoint: Checkpoint, suffix: str) -> dict[str, str]:
    def number(value: float) -> str:
        return f"{float(value)!r}{suffix}"

    def row(values: FloatArray) -> str:
        return ", ".join(number(value) for value in values)

    refuse_own_scaling(checkpoint)
    model, start_up = checkpoint.model, checkpoint.start_up
    interval_s = 1.0 / model.sampling_rate_hz
    w1, b1, w2, b2 = merged_neurons(*physical_weights(checkpoint))
    numbers = {
        "sampling_rate_hz": model.sampling_rate_hz,
        "interval_s": interval_s,
        "half_interval_s": 0.5 * interval_s,
        "rate_limit_rad_s": RATE_LIMIT_RAD_S,
        "max_gap_s": longest_gap_s(interval_s),
        "on_tick": ON_TICK,
        "leak_rad_s": start_up.leak_rad_s,
        "settling_gain": start_up.settling_gain,
        "settling_s": start_up.settling_s,
        "averaged_from_s": start_up.averaged_from_s,
        "averaging_s": start_up.averaging_s,
        "pi_per_averaging": math.pi / start_up.averaging_s if start_up.averaging_s else 0.0,
        "movement_gain": interval_s / (MOVEMENT_TIME_CONSTANT_S + interval_s),
        "movement_square": MOVEMENT_RAD_S**2,
        "washout_gain": washout_gain(checkpoint.washout_s, interval_s),
        "smallest_cos_frontal": COS_FRONTAL_MIN,
        "b2": b2,
        "sine_limit": _SINE_LIMIT_RAD,
        "tanh_square": _TANH_LIMIT**2,
        "t1": -1 / 3,
        "t2": 2 / 15,
        **{f"s{i}": c for i, c in enumerate(_even_series(np.sinc, 1 / math.pi))},
        **{f"c{i}": c for i, c in enumerate(_even_series(np.cos, 1.0))},
    }
    structure = model.structure
    counts = {
        "moving_samples": samples_in_movement(start_up, interval_s),
        "coupled": int(model.coupled),
        "hidden": len(w2),
        "past_inputs": structure.n_input_state,
        "output_lags": structure.output_lags,
        "n_state": structure.n_state,
        "biases": int(bool(b1.any() or b2)),
    }
    return {
        **{name: number(value) for name, value in numbers.items()},
        **{name: str(count) for name, count in counts.items()},
        "w1": ",\n".join(f"    {{{row(values)}}}" for values in w1),
        "b1": row(b1),
        "w2": row(w2),
        "f": suffix,
    }


def _even_series(function: Any, unit: float) -> FloatArray:
    """Coefficients of ``function(unit x)`` in powers of x^2, for the range of the short series."""
    half = 0.5 * _SINE_LIMIT_RAD**2
    interpolate: Any = chebyshev.chebinterpolate
    series = interpolate(lambda t: function(unit * np.sqrt(half * (1.0 + t))), 3)
    in_t = chebyshev.cheb2poly(series)
    result = np.zeros(1)
    for coefficient in in_t[::-1]:
        result = polynomial.polyadd(polynomial.polymul(result, [-1.0, 1.0 / half]), [coefficient])
    return np.asarray(result)[:4]


def physical_weights(
    checkpoint: Checkpoint,
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Fold the normalisation into the weights.

    Parameters
    ----------
    checkpoint : Checkpoint
        Trained network.

    Returns
    -------
    w1 : ndarray, shape (hidden, features)
        Weights for rates in rad/s and deviations in rad.
    b1 : ndarray, shape (hidden,)
        Biases.
    w2 : ndarray, shape (hidden,)
        Weights for a deviation in rad.
    b2 : float
        Bias of the deviation, rad.
    """
    structure, scaled = checkpoint.model.structure, checkpoint.model.normalisation
    weights = checkpoint.model.weights.detach().numpy()
    w1 = weights[structure.w1].reshape(structure.hidden, structure.n_features).copy()
    b1, w2 = weights[structure.b1].copy(), weights[structure.w2] * scaled.angle_scale_rad
    n_rates = structure.n_input_features
    for columns, offset, scale in (
        (slice(0, n_rates), scaled.rate_offset_rad_s, scaled.rate_scale_rad_s),
        (slice(n_rates, None), scaled.angle_offset_rad, scaled.angle_scale_rad),
    ):
        w1[:, columns] /= scale
        b1 -= offset * w1[:, columns].sum(axis=1)
    b2 = weights[structure.b2] * scaled.angle_scale_rad + scaled.angle_offset_rad
    return w1, b1, w2, float(b2)


def merged_neurons(
    w1: FloatArray, b1: FloatArray, w2: FloatArray, b2: float
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Merge neurons with equal weights.

    Parameters
    ----------
    w1, b1, w2, b2 : ndarray and float
        From `physical_weights`.

    Returns
    -------
    w1, b1, w2, b2 : ndarray and float
        Weights of an equivalent network.
    """
    layer = np.column_stack([w1, b1])
    groups: list[list[int]] = []
    for j, neuron in enumerate(layer):
        for group in groups:
            first = layer[group[0]]
            close = np.abs(neuron - first) <= _SAME * np.abs(first) + 1e-12 * np.abs(first).max()
            if close.all() and w2[group[0]] * w2[j] > 0:
                group.append(j)
                break
        else:
            groups.append([j])
    merged = np.stack([np.average(layer[group], axis=0, weights=w2[group]) for group in groups])
    return merged[:, :-1], merged[:, -1], np.array([w2[group].sum() for group in groups]), b2
