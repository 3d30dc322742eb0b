"""A trained network on disk: weights, settings for running it, and its history."""

import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch

from narx.errors import UserError
from narx.files import atomic_path
from narx.inference.checkpoint_archive import MAX_BYTES, check_plain, digest, from_file, to_bytes
from narx.inference.checkpoint_format import opened, sealed
from narx.inference.narx_method import AxisScaling, NarxMethod
from narx.inference.start_up import StartUp
from narx.inference.tracked_method import TrackedNarxMethod
from narx.inference.tracker import PostureTracker
from narx.inference.tracking import Tracking
from narx.inference.washout import WASHOUT_S
from narx.network.model import Narx
from narx.network.structure import NarxStructure
from narx.recordings.stamps import checked_rate_hz
from narx.settings import Flag


@dataclass(frozen=True)
class Checkpoint:
    """Everything needed to run a network, and its history.

    Parameters
    ----------
    model : Narx
        Trained network.
    start_up : StartUp
        Start-up of the network.
    axis_scaling : {"training", "own"}
        Normalisation of untrained axes.
    error_std_rad : tuple of three floats, optional
        Standard deviation of the error per axis, rad; None if unknown.
    start_std_rad : tuple of three floats, optional
        The same during the start-up; None or NaN if not known separately.
    history : dict
        Plain numbers and strings: configuration, training report, stability, environment.
    washout_s : float, optional
        Time constant with which a constant deviation from the posture is removed, s; None for no
        washout.
    tracker : PostureTracker, optional
        Estimates posture and gyroscope bias while the network runs; None for start-up and washout.
    """

    model: Narx
    start_up: StartUp = field(default_factory=StartUp)
    axis_scaling: AxisScaling = "training"
    error_std_rad: tuple[float, float, float] | None = None
    start_std_rad: tuple[float, float, float] | None = None
    history: dict[str, Any] = field(default_factory=dict)
    washout_s: float | None = WASHOUT_S
    tracker: PostureTracker | None = None

    def method(self, smoothing: Flag = False) -> NarxMethod:
        """Return the network as an orientation method.

        Parameters
        ----------
        smoothing : bool
            Average a forward and a backward pass, over whole recordings
            (`narx.inference.smoothing`).

        Returns
        -------
        NarxMethod
            The method.
        """
        if self.tracker is not None:
            return TrackedNarxMethod(self.model, self.tracker, smoothing)
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

    @property
    def sha256(self) -> str:
        """Hash of the whole content: 64 hexadecimal digits."""
        return digest(_content(self))

    def check(self) -> None:
        """Refuse a network that cannot run.

        Raises
        ------
        UserError
            If a number is not finite or has the wrong sign, or an option is unknown.
        """
        model = self.model
        if not isinstance(model, Narx):
            raise UserError(f"model is a {type(model).__name__}, expected a Narx")
        checked_rate_hz(model.sampling_rate_hz, "sampling_rate_hz")
        scales = vars(model.normalisation)
        for name, value in scales.items():
            if "offset" not in name:
                _positive(name, value)
            elif not np.isfinite(value):
                raise UserError(f"{name} is {value}, expected a finite number")
        if not bool(torch.isfinite(model.weights).all()):
            raise UserError("a weight of the network is not finite")
        for name, value in asdict(self.start_up).items():
            _positive(f"start_up.{name}", value, zero=True)
        for name in ("error_std_rad", "start_std_rad"):
            stds = getattr(self, name)
            if stds is not None and len(stds) != 3:
                raise UserError(f"{name} has {len(stds)} values, expected three")
            for std in stds or ():
                if not np.isnan(std):  # NaN: the error of this axis is unknown
                    _positive(name, std)
        if not isinstance(self.history, dict):
            raise UserError(f"history is a {type(self.history).__name__}, expected a dictionary")
        self.method()
        if self.tracker is not None:
            Tracking(self.tracker, model, None)


def save(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write a checkpoint atomically.

    Parameters
    ----------
    checkpoint : Checkpoint
        Checkpoint to write.
    path : path-like
        Destination, usually ``*.pt``.

    Raises
    ------
    UserError
        If it is no network that can run (`Checkpoint.check`), its history has other than plain
        data, or the file cannot be written.
    """
    if not isinstance(checkpoint, Checkpoint):
        raise UserError(f"checkpoint is a {type(checkpoint).__name__}, expected a Checkpoint")
    checkpoint.check()
    content = _content(checkpoint)
    try:
        check_plain(content)
    except ValueError as error:
        raise UserError(f"checkpoint.history: {error}, expected plain data") from error
    packed = to_bytes(sealed(content))
    if len(packed) > MAX_BYTES:
        raise UserError(f"checkpoint has {len(packed)} bytes, expected at most {MAX_BYTES}")
    try:
        with atomic_path(path) as temporary:
            temporary.write_bytes(packed)
    except (OSError, ValueError) as error:  # the latter for a zero byte
        reason = getattr(error, "strerror", None) or error
        raise UserError(f"checkpoint: '{path}' cannot be written: {reason}") from error


def load(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a checkpoint.

    Parameters
    ----------
    path : path-like
        File written by `save` of this version or an earlier one.

    Returns
    -------
    Checkpoint
        The same network.

    Raises
    ------
    UserError
        If the file is missing or damaged, or contains a network that cannot run.
    """
    try:
        there = Path(path).is_file()
    except OSError:  # a name that is too long
        there = False
    if not there:
        raise UserError(f"checkpoint: no file '{str(path)[:200]}'")
    try:
        checkpoint = _from_content(opened(from_file(path)))
        checkpoint.check()
    except KeyError as error:
        raise _refused(path, f"its field {error} is missing") from error
    except (UserError, ValueError, TypeError, ArithmeticError, OSError) as error:
        raise _refused(path, str(error).splitlines()[0]) from error
    return checkpoint


def _refused(path: str | os.PathLike[str], reason: str) -> UserError:
    return UserError(f"checkpoint: '{path}' is not a network that this version can run: {reason}")


def _content(checkpoint: Checkpoint) -> dict[str, Any]:
    return {
        "model": checkpoint.model.to_config(),
        "weights": checkpoint.model.weights.detach().clone(),
        "start_up": asdict(checkpoint.start_up),
        "axis_scaling": checkpoint.axis_scaling,
        "error_std_rad": checkpoint.error_std_rad,
        "start_std_rad": checkpoint.start_std_rad,
        "washout_s": checkpoint.washout_s,
        "history": checkpoint.history,
        "tracker": None if checkpoint.tracker is None else asdict(checkpoint.tracker),
    }


def _from_content(content: dict[str, Any]) -> Checkpoint:
    unknown = set(content) - {entry.name for entry in fields(Checkpoint)} - {"weights"}
    if unknown:
        raise ValueError(f"its field '{min(unknown)}' is unknown")
    weights = content.pop("weights")
    # checked before the model is created, because the file may request a model of any size
    n_weights = NarxStructure(**content["model"]["structure"]).n_weights
    if not isinstance(weights, torch.Tensor) or weights.dtype != torch.float64:
        raise ValueError("its weights are not a float64 tensor")
    if weights.shape != (n_weights,):
        raise ValueError(
            f"its weights have the shape {tuple(weights.shape)}, expected ({n_weights},)"
        )
    model = Narx.from_config(content.pop("model"))
    with torch.no_grad():
        model.weights.copy_(weights)
    # missing fields raise an error here, instead of being replaced by defaults
    start_up = content["start_up"]
    absent = [entry.name for entry in fields(StartUp) if entry.name not in start_up]
    if absent:
        raise KeyError(absent[0])
    rest = {
        name: content[name]
        for name in ("axis_scaling", "error_std_rad", "start_std_rad", "history", "washout_s")
    }
    tracker = content["tracker"]
    if tracker is not None:
        absent = [entry.name for entry in fields(PostureTracker) if entry.name not in tracker]
        if absent:
            raise KeyError(absent[0])
        rest["tracker"] = PostureTracker(**tracker)
    return Checkpoint(model, StartUp(**start_up), **rest)


def _positive(name: str, value: Any, zero: bool = False) -> None:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (number and np.isfinite(value) and (value > 0 or (zero and value == 0))):
        raise UserError(f"{name} is {value}, expected a number {'from' if zero else 'above'} zero")
