"""C: one ISO C99 file and its header, for a microcontroller or any other language."""

import math
import os
import re
from importlib import resources
from pathlib import Path
from string import Template
from typing import Literal, get_args

import numpy as np

from narx.errors import UserError
from narx.export.c_values import network_values, number, tracked_values
from narx.export.recurrence import ExportedNarx
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint
from narx.inference.washout import washout_gain
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S

Precision = Literal["double", "float"]

# a number's suffix and a function's are the same letter in C
_SUFFIX = {"double": "", "float": "f"}


def sources(
    checkpoint: Checkpoint, header_name: str, precision: Precision = "double"
) -> tuple[str, str]:
    """Write a network with its start-up as C.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    header_name : str
        Name under which the C file includes its header.
    precision : {"double", "float"}
        Type of all numbers.

    Returns
    -------
    source, header : str
        Content of the two files.

    Raises
    ------
    UserError
        If the precision is unknown.
    """
    if precision not in get_args(Precision):
        raise UserError(
            f"precision is '{precision}', expected one of {', '.join(get_args(Precision))}"
        )
    tracked = checkpoint.tracker is not None
    values_of, template = (tracked_values, "template_tracked") if tracked else (_values, "template")
    values = values_of(checkpoint, _SUFFIX[precision]) | {
        "title": f"NARX orientation network at {checkpoint.model.sampling_rate_hz:g} Hz",
        "real": precision,
        "header": header_name,
        "guard": re.sub(r"\W", "_", f"NARX_{header_name}").upper(),
    }
    folder = resources.files("narx.export")
    source, header = (
        Template((folder / name).read_text(encoding="utf-8")).substitute(values)
        for name in (f"{template}.c", f"{template}.h")
    )
    return source, header


def _values(checkpoint: Checkpoint, suffix: str) -> dict[str, str]:
    narx = ExportedNarx(checkpoint)
    model, start_up = checkpoint.model, checkpoint.start_up
    structure, scaled = model.structure, model.normalisation
    interval_s = 1.0 / narx.sampling_rate_hz
    # as the package adds time up, so that rounding in `float` cannot move the hand-over
    enough = math.ceil(max(start_up.duration_s, 0.0) / interval_s) + 2
    moving_s = np.cumsum([0.0] + [interval_s] * enough)
    moving_samples = int(np.argmax(moving_s >= start_up.duration_s))
    numbers = {
        "interval_s": interval_s,
        "leak_rad_s": start_up.leak_rad_s,
        "settling_gain": start_up.settling_gain,
        "settling_s": start_up.settling_s,
        "averaged_from_s": start_up.averaged_from_s,
        "averaging_s": start_up.averaging_s,
        "movement_time_constant_s": MOVEMENT_TIME_CONSTANT_S,
        "movement_square": MOVEMENT_RAD_S**2,
        "washout_gain": washout_gain(checkpoint.washout_s, interval_s),
        "rate_offset": scaled.rate_offset_rad_s,
        "rate_scale": scaled.rate_scale_rad_s,
        "angle_offset": scaled.angle_offset_rad,
        "angle_scale": scaled.angle_scale_rad,
    }
    counts = {
        "moving_samples": moving_samples,
        "coupled": int(model.coupled),
        "output_lags": structure.output_lags,
        "n_state": structure.n_state,
    }
    return {
        **network_values(checkpoint, suffix),
        **{name: number(value, suffix) for name, value in numbers.items()},
        **{name: str(count) for name, count in counts.items()},
    }


def write(
    checkpoint: Checkpoint, path: str | os.PathLike[str], precision: Precision = "double"
) -> None:
    """Write a network as a C file, and its header beside it.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    path : path-like
        Where to, ``*.c``; the header has the same name with ``.h``.
    precision : {"double", "float"}
        Type of all numbers.

    Raises
    ------
    UserError
        If the name does not end in ``.c``, or the precision is unknown.
    """
    target = Path(path)
    if target.suffix != ".c":
        raise UserError(f"output is '{target}', expected a name that ends in .c for format=c")
    beside = target.with_suffix(".h")
    source, header = sources(checkpoint, beside.name, precision)
    with atomic_path(beside) as temporary:
        temporary.write_text(header, encoding="utf-8")
    with atomic_path(target) as temporary:
        temporary.write_text(source, encoding="utf-8")
