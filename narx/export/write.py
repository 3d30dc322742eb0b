"""Write a network in any export format; only verified files appear."""

import json
import os
import re
from contextlib import ExitStack
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
from narx.export.onnx_graph import assembled
from narx.export.verification import (
    SIGNALS,
    TOLERANCE_RAD,
    Runner,
    largest_difference_rad,
    refuse_above_tolerance,
)
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint
from narx.types import FloatArray

Format = Literal["torchscript", "torch_export", "onnx", "c"]
Precision = Literal["double", "float"]

# the source includes its header by name
_NOT_IN_AN_INCLUDE = re.compile(r'["\\\x00-\x1f\ud800-\udfff]')
_C_HEADER = re.compile(
    "assert|complex|ctype|errno|fenv|float|inttypes|iso646|limits|locale|math|setjmp|signal|"
    "std(align|arg|atomic|bit|bool|ckdint|def|int|io|lib|noreturn)|string|tgmath|threads|time|"
    "uchar|wchar|wctype",
    re.IGNORECASE,
)
_SUFFIX = {"torchscript": ".pt", "torch_export": ".pt2", "onnx": ".onnx", "c": ".c"}
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

    The export is compared with the package (`narx.export.verification`) before its file appears.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    path : path-like
        Output file: ``*.pt`` for ``torchscript``, ``*.pt2`` for ``torch_export``, ``*.onnx`` for
        ``onnx``, ``*.c`` for ``c``, which also writes a header.
    format : {"torchscript", "torch_export", "onnx", "c"}
        See docs/export.md.
    precision : {"double", "float"}, optional
        Type of all numbers; by default float in C, double elsewhere.
    verify : bool
        Whether to verify the export; if not, its identity states that it was not verified.

    Returns
    -------
    dict
        Identity of the file, as returned by `narx.export.read_identity`.

    Raises
    ------
    UserError
        If an option or the checkpoint is invalid, a requirement of the format is missing, the
        export differs from the package, or the file cannot be written. Then there is no file.
    """
    if not isinstance(checkpoint, Checkpoint):
        raise UserError(
            f"checkpoint is a {type(checkpoint).__name__}, expected a Checkpoint, e.g. pretrained()"
        )
    target = Path(path)
    if format not in get_args(Format):
        raise UserError(f"format is '{format}', expected one of {', '.join(get_args(Format))}")
    if precision is None:
        precision = "float" if format == "c" else "double"
    if precision not in get_args(Precision):
        raise UserError(
            f"precision is '{precision}', expected one of {', '.join(get_args(Precision))}"
        )
    if target.suffix != _SUFFIX[format]:
        raise UserError(
            f"output is '{target}', expected a name ending in {_SUFFIX[format]} for format={format}"
        )
    if format == "c" and _NOT_IN_AN_INCLUDE.search(target.name):
        raise UserError(
            f"output is {str(target)!r}, expected a name without quotes, backslashes and control "
            "characters for format=c"
        )
    if format == "c" and _C_HEADER.fullmatch(target.stem):
        raise UserError(
            f"output is '{target}': {target.stem}.h would hide the C library's header of that name"
        )
    if os.path.isdir(target):  # Path.is_dir raises for a name that is too long
        raise UserError(f"output: '{target}' is a folder")
    checkpoint.check()
    about = {**identity(checkpoint, format, precision), "verification": None}
    built = build(checkpoint, format, precision)
    if verify:
        run = runner(checkpoint, format, built)
        difference = largest_difference_rad(checkpoint, run, _NUMPY[precision])
        tolerance = TOLERANCE_RAD[precision]
        refuse_above_tolerance(difference, tolerance, format)
        about["verification"] = {
            "largest_difference_rad": difference,
            "tolerance_rad": tolerance,
            "signals": SIGNALS,
        }
    files = _stamped(built, format, target, json.dumps(about, allow_nan=False))
    try:
        # none appears before all are complete, and the requested one is the last
        with ExitStack() as complete:
            for name, content in files.items():
                temporary = complete.enter_context(atomic_path(target.with_name(name)))
                temporary.write_bytes(content)
    except OSError as error:
        raise UserError(f"output: '{target}' cannot be written: {error.strerror}") from error
    return about


# two sources for C, one file for the other formats
Built = dict[str, str] | bytes


def build(checkpoint: Checkpoint, export_format: str, precision: str) -> Built:
    """Translate a network, without checks and without an identity.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    export_format, precision : str
        As for `write`.

    Returns
    -------
    dict or bytes
        Two sources for C, one file for the other formats.
    """
    if export_format == "c":
        return c.build(checkpoint, precision)
    if export_format == "torchscript":
        return torchscript.build(checkpoint, _TORCH[precision])
    if export_format == "torch_export":
        return torch_export.build(checkpoint, _TORCH[precision])
    onnx.check_libraries()
    return assembled(checkpoint, _TORCH[precision])


def _stamped(built: Built, export_format: str, target: Path, about: str) -> dict[str, bytes]:
    """Content of the files by name, the requested file first."""
    if isinstance(built, dict):
        files = c.stamped(built, target.stem, about)
        return {name: content.encode() for name, content in files.items()}
    stamp = onnx.stamped if export_format == "onnx" else torchscript.stamped
    return {target.name: stamp(built, about)}


def runner(checkpoint: Checkpoint, export_format: str, built: Built) -> Runner:
    """Load a translated network to run it over recordings.

    Parameters
    ----------
    checkpoint : Checkpoint
        The network.
    export_format : str
        Its format.
    built : dict or bytes
        From `build`.

    Returns
    -------
    callable
        From inputs, times since the samples before and known start poses to angles; a graph is
        given blocks of random size.
    """
    if isinstance(built, dict):
        return c.loaded(c.stamped(built, "narx", ""))
    if export_format == "torchscript":
        script = torchscript.loaded(built)

        def run(rates: FloatArray, interval_s: FloatArray, start: FloatArray | None) -> FloatArray:
            known = None if start is None else torch.from_numpy(start)
            return np.asarray(script(torch.from_numpy(rates), torch.from_numpy(interval_s), known))

        return run
    graph = (torch_export if export_format == "torch_export" else onnx).loaded(built)

    def run_graph(
        rates: FloatArray, interval_s: FloatArray, start: FloatArray | None
    ) -> FloatArray:
        signals = torch.from_numpy(rates), torch.from_numpy(interval_s)
        poses = torch.zeros_like(signals[0][:, 0, :3]) if start is None else torch.from_numpy(start)
        flag = torch.full_like(poses[:, :1], 0.0 if start is None else 1.0)
        state = ClockedRecurrence(checkpoint).to(poses.dtype).start(poses, flag)
        blocks = []
        for rates_of_block, interval_s_of_block in zip(*_in_blocks(signals), strict=True):
            angles, state = graph(rates_of_block, interval_s_of_block, state)
            blocks.append(angles)
        return np.asarray(torch.cat(blocks, dim=1))

    return run_graph


def _in_blocks(signals: tuple[torch.Tensor, ...]) -> list[list[torch.Tensor]]:
    """Divide signals (B, N, ...) into blocks of random size, as a stream would give them."""
    rng, n_samples = np.random.default_rng(0), signals[0].shape[1]
    sizes: list[int] = []
    while sum(sizes) < n_samples:
        sizes.append(min(int(rng.integers(1, 1000)), n_samples - sum(sizes)))
    return [[block.contiguous() for block in part.split(sizes, dim=1)] for part in signals]
