"""Run the exported files of a network with a tracker step by step, for verification."""

import io
import warnings
from typing import Any

import numpy as np
import torch

from narx.export.tracked import ExportedTracked
from narx.inference.checkpoint import Checkpoint
from narx.types import FloatArray


def run_tracked(
    checkpoint: Checkpoint,
    export_format: str,
    data: bytes,
    inputs: FloatArray,
    start: FloatArray | None,
) -> FloatArray:
    """Load a file and run it over recordings.

    Parameters
    ----------
    checkpoint : Checkpoint
        The exported network, which gives the initial state.
    export_format : {"torchscript", "torch_export", "onnx"}
        Format of the file.
    data : bytes
        Content of the file.
    inputs : ndarray, shape (B, N, 3 or 6)
        Inputs of the step.
    start : ndarray, shape (B, 3), or None
        Known start poses, rad.

    Returns
    -------
    ndarray, shape (B, N, 3)
        Angles, rad.
    """
    step = _step(export_format, data)
    narx = ExportedTracked(checkpoint)
    angles = np.empty((*inputs.shape[:2], 3))
    with torch.no_grad():
        for sensor in range(len(inputs)):
            state = narx.start(None if start is None else torch.from_numpy(start[sensor]))
            for k, sample in enumerate(torch.from_numpy(inputs[sensor])):
                one, state = step(sample, state)
                angles[sensor, k] = one.numpy()
    return angles


def _step(export_format: str, data: bytes) -> Any:
    if export_format == "torchscript":
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="`torch.jit.*` is deprecated")
            return torch.jit.load(io.BytesIO(data)).step
    if export_format == "torch_export":
        return torch.export.load(io.BytesIO(data)).module()
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])

    def step(sample: torch.Tensor, state: torch.Tensor) -> list[torch.Tensor]:
        feed = {"axis_rates": sample.numpy(), "state": state.numpy()}
        return [torch.from_numpy(np.asarray(part)) for part in session.run(None, feed)]

    return step
