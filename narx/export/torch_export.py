"""torch.export: the sequence graph for AOTInductor, ExecuTorch and similar runtimes."""

import io

import torch
from torch import Tensor

from narx.export.graph import GraphRunner, program
from narx.export.torchscript import IDENTITY_FILE
from narx.inference.checkpoint import Checkpoint


def build(checkpoint: Checkpoint, dtype: torch.dtype) -> bytes:
    """Trace a network with its start-up.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.
    dtype : torch.dtype
        Type of all numbers.

    Returns
    -------
    bytes
        Content of the file, for `narx.export.torchscript.stamped`.
    """
    buffer = io.BytesIO()
    torch.export.save(program(checkpoint, dtype), buffer, extra_files={IDENTITY_FILE: ""})
    return buffer.getvalue()


def loaded(data: bytes) -> GraphRunner:
    """Load a file to run it over recordings.

    Parameters
    ----------
    data : bytes
        From `build`.

    Returns
    -------
    callable
        As `narx.export.graph.GraphRunner`.
    """
    module = torch.export.load(io.BytesIO(data)).module()

    def run(axis_rates: Tensor, interval_s: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        with torch.no_grad():
            angles, new_state, *_ = module(axis_rates, interval_s, state)
        return angles, new_state

    return run
