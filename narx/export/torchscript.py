"""TorchScript: one file that any process with torch loads, in Python or C++."""

import io
import os
import warnings

import torch

from narx.export.module import exported
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint


def scripted(checkpoint: Checkpoint) -> torch.jit.ScriptModule:
    """Compile a network with its start-up.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.

    Returns
    -------
    torch.jit.ScriptModule
        With `start`, `step` and a call over a whole recording, as
        `narx.export.module.exported`.
    """
    with warnings.catch_warnings():
        # newer torch would rather have torch.export, which holds no loop over samples
        warnings.filterwarnings("ignore", message="`torch.jit.*` is deprecated")
        return torch.jit.script(exported(checkpoint).eval())


def write(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write a network as TorchScript.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    path : path-like
        Where to, usually ``*.pt``.
    """
    module = scripted(checkpoint)
    content = io.BytesIO()  # torch refuses file names without a suffix
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="`torch.jit.*` is deprecated")
        torch.jit.save(module, content)
    with atomic_path(path) as temporary:
        temporary.write_bytes(content.getvalue())
