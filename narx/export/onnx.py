"""ONNX: the step as a graph, state in and state out, for onnxruntime and its like."""

import importlib.util
import json
import logging
import os
import warnings

import torch

from narx.errors import UserError
from narx.export.module import description, exported, graph
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint

_LIBRARIES = ("onnx", "onnxscript")


def write(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write the step of a network as an ONNX graph in float64.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    path : path-like
        Where to, usually ``*.onnx``.

    Raises
    ------
    UserError
        If a library is not installed.

    Notes
    -----
    Inputs ``axis_rates`` and ``state``, outputs ``angles`` and ``new_state``, as
    `narx.export.module.graph`. The file's metadata hold
    `narx.export.module.description` under the key ``narx``, as JSON.
    """
    missing = [name for name in _LIBRARIES if importlib.util.find_spec(name) is None]
    if missing:
        raise UserError(
            f"format=onnx needs {' and '.join(missing)}, not installed; "
            "pip install 'narx-orientation[onnx]'"
        )
    narx = exported(checkpoint)
    # operators of packages that are not there do not matter here
    logging.getLogger("torch.onnx._internal.exporter._registration").setLevel(logging.ERROR)
    with torch.no_grad(), warnings.catch_warnings():
        # torch's exporter uses what torch itself deprecates
        warnings.simplefilter("ignore")
        program = torch.onnx.export(
            graph(narx).eval(),
            (torch.zeros(narx.n_inputs, dtype=torch.float64), narx.start()),
            input_names=["axis_rates", "state"],
            output_names=["angles", "new_state"],
            dynamo=True,
            verbose=False,
        )
    assert program is not None
    program.model.metadata_props["narx"] = json.dumps(description(narx))
    with atomic_path(path) as temporary:
        program.save(temporary, external_data=False)
