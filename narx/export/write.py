"""One way to write a network in any format, and never a file that is not right."""

import json
import os
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import torch

import narx.export.c as c
import narx.export.onnx as onnx
import narx.export.torch_export as torch_export
import narx.export.torchscript as torchscript
from narx.errors import UserError
from narx.export.clocked import ClockedRecurrence
from narx.export.identity import identity
from narx.export.tracked import ExportedTracked
from narx.export.tracked_run import run_tracked
from narx.export.verification import (
    TOLERANCE_RAD,
    TRACKED_TOLERANCE_RAD,
    Runner,
    largest_difference_rad,
    refuse_above_tolerance,
    tracked_difference_rad,
)
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint
from narx.types import FloatArray

Format = Literal["torchscript", "torch_export", "onnx", "c"]
Precision = Literal["double", "float"]

_SUFFIX = {"torch_export": ".pt2", "c": ".c"}
_NUMPY: dict[str, type] = {"double": np.float64, "float": np.float32}
_TORCH = {"double": torch.float64, "float": torch.float32}


def write(
    checkpoint: Checkpoint,
    path: str | os.PathLike[str],
    format: Format = "torchscript",
    precision: Precision | None = None,
    verify: bool = True,
) -> dict[str, Any]:
    """Write a network for use where this package is not installed.

    The export is run against the package (`narx.export.verification`) before its file appears.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    path : path-like
        Where to; ``*.pt2`` for ``torch_export``, ``*.c`` for ``c``, which writes a header beside.
    format : {"torchscript", "torch_export", "onnx", "c"}
        See docs/export.md.
    precision : {"double", "float"}, optional
        Type of all numbers; by default float in C without a tracker, double elsewhere.
    verify : bool
        Whether to run it; without, the file says that it was not verified.

    Returns
    -------
    dict
        What the file says of itself, as `narx.export.read_identity` gives it back.

    Raises
    ------
    UserError
        If a choice or the checkpoint is not right, something is missing that the format needs, or
        the export differs from the package. Nothing is written then.
    """
    target = Path(path)
    if format not in get_args(Format):
        raise UserError(f"format is '{format}', expected one of {', '.join(get_args(Format))}")
    if precision is None:
        plain_c = format == "c" and checkpoint.tracker is None
        precision = "float" if plain_c else "double"
    if precision not in get_args(Precision):
        raise UserError(
            f"precision is '{precision}', expected one of {', '.join(get_args(Precision))}"
        )
    suffix = _SUFFIX.get(format)
    if suffix is not None and target.suffix != suffix:
        raise UserError(
            f"output is '{target}', expected a name that ends in {suffix} for format={format}"
        )
    checkpoint.check()
    tracked = checkpoint.tracker is not None
    if tracked and format != "c" and precision != "double":
        raise UserError(
            f"precision=float of a network with a tracker is for format=c; format={format} is "
            "float64, expected precision=double"
        )
    about = {**identity(checkpoint, format, precision), "verification": None}
    built = _build(checkpoint, format, precision)
    if verify:
        run = _runner(checkpoint, format, built)
        compare = tracked_difference_rad if tracked else largest_difference_rad
        difference = compare(checkpoint, run, _NUMPY[precision])
        tolerance = (TRACKED_TOLERANCE_RAD if tracked else TOLERANCE_RAD)[precision]
        refuse_above_tolerance(difference, tolerance, format)
        about["verification"] = {
            "largest_difference_rad": difference,
            "tolerance_rad": tolerance,
            "signals": "a walk and noise with losses, known and unknown start",
        }
    files = _stamped(built, format, target, json.dumps(about, allow_nan=False))
    # the file that was asked for comes last
    for name, content in reversed(files.items()):
        with atomic_path(target.with_name(name)) as temporary:
            temporary.write_bytes(content)
    return about


# of C two sources, of the others one file
_Built = dict[str, str] | bytes


def _build(checkpoint: Checkpoint, export_format: str, precision: str) -> _Built:
    if export_format == "c":
        return c.build(checkpoint, precision)
    if export_format == "torchscript":
        kind = torchscript.ScriptedNarx if checkpoint.tracker is None else ExportedTracked
        return torchscript.build(kind(checkpoint), _TORCH[precision])
    if export_format == "torch_export":
        return torch_export.build(checkpoint, _TORCH[precision])
    return onnx.build(checkpoint, _TORCH[precision])


def _stamped(built: _Built, export_format: str, target: Path, about: str) -> dict[str, bytes]:
    """Content of the files by their names, the one asked for first."""
    if isinstance(built, dict):
        files = c.stamped(built, target.stem, about)
        return {name: content.encode() for name, content in files.items()}
    stamp = onnx.stamped if export_format == "onnx" else torchscript.stamped
    return {target.name: stamp(built, about)}


def _runner(checkpoint: Checkpoint, export_format: str, built: _Built) -> Runner:
    def run(rates: FloatArray, interval_s: FloatArray, start: FloatArray | None) -> FloatArray:
        if isinstance(built, dict):
            intervals = interval_s if checkpoint.tracker is None else None
            return c.run(c.stamped(built, "narx", ""), rates, intervals, start)
        if checkpoint.tracker is not None:
            return run_tracked(checkpoint, export_format, built, rates, start)
        signals = torch.from_numpy(rates), torch.from_numpy(interval_s)
        if export_format == "torchscript":
            known = None if start is None else torch.from_numpy(start)
            return np.asarray(torchscript.run(built, *signals, known))
        poses = torch.zeros_like(signals[0][:, 0]) if start is None else torch.from_numpy(start)
        flag = torch.full_like(poses[:, :1], 0.0 if start is None else 1.0)
        state = ClockedRecurrence(checkpoint).start(poses, flag)
        module = torch_export if export_format == "torch_export" else onnx
        return np.asarray(module.run(built, *signals, state))

    return run
