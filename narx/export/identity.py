"""Identity of an exported file: its description in the file, and how it is read back."""

import json
import math
import re
import zipfile
from pathlib import Path
from typing import Any

import torch

import narx
from narx.errors import UserError
from narx.export.clocked import ClockedRecurrence
from narx.inference.checkpoint import Checkpoint
from narx.kernels.limits import FORCE_LIMIT_M_S2
from narx.method import RATE_LIMIT_RAD_S, longest_gap_s

PACKAGE_NAME = "narx-orientation"
# pattern of the identity in a C header
_DEFINITION = re.compile(r'^#define NARX_IDENTITY ("(?:[^"\\]|\\.)*")$', re.MULTILINE)
_UNREADABLE = ValueError, KeyError, OSError, StopIteration, RecursionError, zipfile.BadZipFile
_NOTHING: tuple[None, None, None] = (None, None, None)


def identity(checkpoint: Checkpoint, export_format: str, precision: str) -> dict[str, Any]:
    """Describe an export.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network that is exported.
    export_format : str
        Its format.
    precision : {"double", "float"}
        Type of its numbers.

    Returns
    -------
    dict
        Plain numbers, strings, lists and dictionaries; unknown values are None.
    """
    rate_hz = float(checkpoint.model.sampling_rate_hz)
    return {
        "package": PACKAGE_NAME,
        "version": narx.__version__,
        "checkpoint_sha256": checkpoint.sha256,
        "format": export_format,
        "precision": precision,
        "sampling_rate_hz": rate_hz,
        "axes": ["sagittal", "frontal", "transverse"],
        "axis_rates": {
            "unit": "rad/s",
            "limit": RATE_LIMIT_RAD_S,
            "force_limit_m_s2": FORCE_LIMIT_M_S2,
            "right_leg": "(-y, -x, z) of a gyroscope with x forward, y left, z up",
            "left_leg": "(-y, x, -z) of a gyroscope with x forward, y left, z up",
            "bias": "removed before",
        },
        "angles": {"unit": "rad", "positive": "flexion, abduction, internal rotation"},
        "longest_bridged_gap_s": longest_gap_s(1.0 / rate_hz),
        "start_up_s": checkpoint.start_up.duration_s,
        "washout_s": checkpoint.washout_s,
        "error_std_rad": _known(checkpoint.error_std_rad),
        "start_std_rad": _known(checkpoint.start_std_rad),
        **_states(checkpoint),
    }


def _states(checkpoint: Checkpoint) -> dict[str, Any]:
    clocked, one = ClockedRecurrence(checkpoint), torch.ones(1)
    known = clocked.start(torch.zeros(3), one)
    # where the start angles go
    moved = [(clocked.start(pose, one) != known).nonzero().flatten() for pose in torch.eye(3)]
    states: dict[str, Any] = {
        "inputs": ["axis rates", "axis rates, then specific force x, y, z in m/s^2"][
            clocked.n_inputs > 3
        ],
        "start_state": clocked.start(torch.zeros(3), 0.0 * one).tolist(),
        "known_start": {"state": known.tolist(), "angles_at": [at.tolist() for at in moved]},
    }
    if checkpoint.tracker is not None:
        states["standard_deviation"] = {"factors": list(checkpoint.tracker.std_scale)}
    return states


def _known(stds: tuple[float, ...] | None) -> list[float | None]:
    return [None if std is None or math.isnan(std) else float(std) for std in stds or _NOTHING]


def read_identity(path: str | Path) -> dict[str, Any]:
    """Read the identity of an exported file.

    Parameters
    ----------
    path : path-like
        Any file written by `narx.export.write`; for C the source or the header.

    Returns
    -------
    dict
        As `identity`, with ``verification``.

    Raises
    ------
    UserError
        If the file does not exist or is not an export.
    """
    file = Path(path)
    if not file.is_file():
        raise UserError(f"export: no file '{path}'")
    try:
        text = _text_of(file)
        content = json.loads(text)
    except _UNREADABLE as error:
        raise UserError(f"export: '{path}' was not written by narx.export.write") from error
    if not isinstance(content, dict) or content.get("package") != PACKAGE_NAME:
        raise UserError(f"export: '{path}' is the export of another program")
    return content


def _text_of(file: Path) -> str:
    if file.suffix in (".c", ".h"):
        found = _DEFINITION.search(file.with_suffix(".h").read_text(encoding="utf-8"))
        if found is None:
            raise ValueError("no NARX_IDENTITY")
        return str(json.loads(found.group(1)))
    if zipfile.is_zipfile(file):
        with zipfile.ZipFile(file) as archive:
            name = next(n for n in archive.namelist() if n.endswith("extra/narx.json"))
            return archive.read(name).decode()
    from narx.export.onnx import read_metadata

    return read_metadata(file)
