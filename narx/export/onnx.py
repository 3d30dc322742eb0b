"""ONNX: whole sequences of many sensors for onnxruntime and similar runtimes."""

import importlib.util
from pathlib import Path

import torch
from torch import Tensor

from narx.errors import UserError
from narx.export.graph import INPUTS, OUTPUTS, GraphRunner

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


def stamped(data: bytes, identity: str) -> bytes:
    """Write the identity into the metadata.

    Parameters
    ----------
    data : bytes
        From `narx.export.onnx_graph.assembled`.
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


def loaded(data: bytes) -> GraphRunner:
    """Load a file to run it over recordings.

    Parameters
    ----------
    data : bytes
        From `narx.export.onnx_graph.assembled`.

    Returns
    -------
    callable
        As `narx.export.graph.GraphRunner`.
    """
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # onnxruntime warns about unused constants left by the exporter
    session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])

    def run(*inputs: Tensor) -> tuple[Tensor, Tensor]:
        feed = {name: value.numpy() for name, value in zip(INPUTS, inputs, strict=True)}
        angles, new_state = (torch.from_numpy(part) for part in session.run(OUTPUTS[:2], feed))
        return angles, new_state

    return run


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
