"""torch.export: the step as a graph of operations, for AOTInductor, ExecuTorch and their like."""

import json
import os
from pathlib import Path

import torch

from narx.errors import UserError
from narx.export.module import description, exported, graph
from narx.files import atomic_path
from narx.inference.checkpoint import Checkpoint


def exported_step(checkpoint: Checkpoint) -> torch.export.ExportedProgram:
    """Trace the step of a network with its start-up.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.

    Returns
    -------
    torch.export.ExportedProgram
        ``(inputs (3,) or aided (6,), state) -> (angles (3,), state)`` in float64, as
        `narx.export.module.graph`.
    """
    narx = exported(checkpoint)
    example = (torch.zeros(narx.n_inputs, dtype=torch.float64), narx.start())
    with torch.no_grad():
        return torch.export.export(graph(narx).eval(), example)


def write(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write the step of a network as an exported program.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    path : path-like
        Where to, ``*.pt2``.

    Raises
    ------
    UserError
        If the name does not end in ``.pt2``, as torch wants it.

    Notes
    -----
    The file also holds ``narx.json`` (`narx.export.module.description`): give
    ``torch.export.load`` the argument ``extra_files={"narx.json": ""}``.
    """
    if Path(path).suffix != ".pt2":
        raise UserError(
            f"output is '{path}', expected a name that ends in .pt2 for format=torch_export"
        )
    program = exported_step(checkpoint)
    extra = {"narx.json": json.dumps(description(exported(checkpoint)))}
    with atomic_path(path) as temporary:
        torch.export.save(program, temporary, extra_files=extra)
