"""ONNX: the sequence graph for onnxruntime and similar runtimes."""

import importlib.util
import logging
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from narx.errors import UserError
from narx.export.graph import INPUTS, OUTPUTS, program
from narx.inference.checkpoint import Checkpoint

IDENTITY_KEY = "narx"
_LIBRARIES = ("onnx", "onnxscript", "onnxruntime")


def check_libraries() -> None:
    """Check that the required libraries are installed.

    Raises
    ------
    UserError
        If one is not installed.
    """
    missing = [name for name in _LIBRARIES if importlib.util.find_spec(name) is None]
    if missing:
        raise UserError(
            f"format=onnx needs {' and '.join(missing)}, not installed; "
            "pip install 'narx-orientation[onnx]'"
        )


def build(checkpoint: Checkpoint, dtype: torch.dtype) -> bytes:
    """Translate a network with its start-up.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    dtype : torch.dtype
        Type of all numbers.

    Returns
    -------
    bytes
        Content of the file, for `stamped`.

    Raises
    ------
    UserError
        If a library is not installed.
    """
    check_libraries()
    # warnings about operators of packages that are not installed do not matter here
    for name in ("_registration", "_core"):
        logging.getLogger(f"torch.onnx._internal.exporter.{name}").setLevel(logging.ERROR)
    with torch.no_grad(), warnings.catch_warnings():
        # torch's exporter uses functions that torch itself deprecates
        warnings.simplefilter("ignore")
        translated = torch.onnx.export(
            program(checkpoint, dtype),
            input_names=list(INPUTS),
            output_names=list(OUTPUTS),
            dynamo=True,
            verbose=False,
        )
    assert translated is not None
    _strip(translated.model)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "narx.onnx"
        translated.save(path, external_data=False)
        return path.read_bytes()


def stamped(data: bytes, identity: str) -> bytes:
    """Write the identity into the metadata.

    Parameters
    ----------
    data : bytes
        From `build`.
    identity : str
        Identity, stored under the key ``narx``.

    Returns
    -------
    bytes
        File with the same graph.
    """
    import onnx

    model = onnx.load_from_string(data)
    onnx.helper.set_model_props(model, {IDENTITY_KEY: identity})
    return bytes(model.SerializeToString())


def _strip(model: Any) -> None:
    """Remove the exporter's notes about its sources."""
    import onnx_ir

    model.metadata_props.clear()
    model.graph.metadata_props.clear()
    for node in onnx_ir.traversal.RecursiveGraphIterator(model.graph):
        node.metadata_props.clear()
        node.doc_string = None
        for value in (*node.inputs, *node.outputs):
            if value is not None:
                value.metadata_props.clear()
        for attribute in node.attributes.values():
            if attribute.type == onnx_ir.AttributeType.GRAPH:
                attribute.value.metadata_props.clear()


def run(data: bytes, axis_rates: Tensor, interval_s: Tensor, state: Tensor) -> Tensor:
    """Load a file and run it over recordings.

    Parameters
    ----------
    data : bytes
        From `build`.
    axis_rates, interval_s, state : Tensor
        As for `narx.export.graph.SequenceGraph`.

    Returns
    -------
    Tensor, shape (B, N, 3)
        Angles, rad.
    """
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # onnxruntime warns about unused constants left by the exporter
    session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    feed = dict(zip(INPUTS, (axis_rates.numpy(), interval_s.numpy(), state.numpy()), strict=True))
    angles: np.ndarray = session.run(["angles"], feed)[0]
    return torch.from_numpy(angles)


def read_metadata(path: Path) -> str:
    """Read the identity from the metadata.

    Parameters
    ----------
    path : pathlib.Path
        File.

    Returns
    -------
    str
        The identity.

    Raises
    ------
    UserError
        If a library is not installed.
    ValueError
        If the file is not an ONNX model.
    KeyError
        If it has no such metadata.
    """
    check_libraries()
    import onnx

    try:
        model = onnx.load(str(path), load_external_data=False)
    except Exception as error:  # protobuf raises its own error classes
        raise ValueError("not an ONNX model") from error
    return {entry.key: entry.value for entry in model.metadata_props}[IDENTITY_KEY]
