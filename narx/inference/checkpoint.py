"""A trained network on disk: weights, how to run it, and where it comes from."""

import io
import math
import os
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch

from narx.errors import UserError
from narx.files import atomic_path
from narx.inference.narx_method import AxisScaling, NarxMethod
from narx.inference.start_up import StartUp
from narx.inference.washout import WASHOUT_S
from narx.network.model import Narx


@dataclass(frozen=True)
class Checkpoint:
    """All that running a network needs, and its history for people.

    Parameters
    ----------
    model : Narx
        Trained network.
    start_up : StartUp
        How it starts.
    axis_scaling : {"training", "own"}
        How untrained axes are normalised.
    error_std_rad : tuple of three floats, optional
        Standard deviation of the error per axis, rad; None where it is not known.
    start_std_rad : tuple of three floats, optional
        The same during the start-up; None or NaN where it is not known apart.
    history : dict
        Plain numbers and strings: configuration, training report, stability, environment.
    washout_s : float, optional
        Time constant with which a lasting deviation from the posture is taken off, s; None
        leaves it.
    """

    model: Narx
    start_up: StartUp = field(default_factory=StartUp)
    axis_scaling: AxisScaling = "training"
    error_std_rad: tuple[float, float, float] | None = None
    start_std_rad: tuple[float, float, float] | None = None
    history: dict[str, Any] = field(default_factory=dict)
    washout_s: float | None = WASHOUT_S

    def method(self, smoothing: bool = False) -> NarxMethod:
        """Return the network as an orientation method.

        Parameters
        ----------
        smoothing : bool
            Run backwards as well, over whole recordings (`narx.inference.smoothing`).

        Returns
        -------
        NarxMethod
            Ready to estimate.
        """
        std, start_std = (
            None if std is None else np.array(std)
            for std in (self.error_std_rad, self.start_std_rad)
        )
        return NarxMethod(
            self.model,
            self.start_up,
            self.axis_scaling,
            std,
            start_std,
            self.washout_s,
            smoothing,
        )


def save(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write a checkpoint in one piece.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to write.
    path : path-like
        Where to, usually ``*.pt``.
    """
    content = {
        "model": checkpoint.model.to_config(),
        "weights": checkpoint.model.weights.detach().clone(),
        "start_up": asdict(checkpoint.start_up),
        "axis_scaling": checkpoint.axis_scaling,
        "error_std_rad": checkpoint.error_std_rad,
        "start_std_rad": checkpoint.start_std_rad,
        "washout_s": checkpoint.washout_s,
        "history": checkpoint.history,
    }
    # in memory first: torch names the inside of the file after the path, here a random one, and
    # the same checkpoint is to be the same file
    buffer = io.BytesIO()
    torch.save(content, buffer)
    with atomic_path(path) as temporary:
        temporary.write_bytes(buffer.getvalue())


def load(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint.

    Parameters
    ----------
    path : path-like
        What `save` wrote.

    Returns
    -------
    Checkpoint
        The same network.

    Raises
    ------
    UserError
        If the file is not there, or not such a checkpoint.
    """
    if not Path(path).is_file():
        raise UserError(f"checkpoint: no file '{path}'")
    try:
        content = torch.load(path, weights_only=True)
        model = Narx.from_config(content["model"])
        with torch.no_grad():
            model.weights.copy_(content["weights"])
        checkpoint = Checkpoint(
            model,
            # a file from before there was a choice averaged at the end
            StartUp(**{"averaging_begin_s": math.inf} | content["start_up"]),
            content["axis_scaling"],
            content["error_std_rad"],
            # a file from before there were these runs as it did
            content.get("start_std_rad"),
            content["history"],
            content.get("washout_s"),
        )
        checkpoint.method()  # a file whose network cannot run is refused here, by its name
        return checkpoint
    except Exception as error:  # what the unpickler makes of a foreign file has no end of forms
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UserError(
            f"checkpoint: '{path}' is not a network that this version saved: {reason}"
        ) from error
