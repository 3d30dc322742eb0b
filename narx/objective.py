"""What training minimises, and what an optimizer has to say about its result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from narx.model import Narx
from narx.sequences import Batch

# what an optimizer reports as it goes: iteration, and numbers by name (cost, damping, ...)
Log = Callable[[int, dict[str, float]], None]


@dataclass(frozen=True)
class Objective:
    """What is minimised: the closed-loop error against the teacher.

    Parameters
    ----------
    axis_weights : tuple of three floats
        Of the squared errors of the sagittal, frontal and transverse axis.
    offset_free : bool
        Remove each sequence's mean error on each axis first: the mean angle is the start-up's
        business, not the network's.
    washout_s : float
        Time after a sequence's start that does not count, s.
    """

    axis_weights: tuple[float, float, float] = (1.0, 0.0, 0.0)
    offset_free: bool = False
    washout_s: float = 0.0

    def washout_samples(self, model: Narx) -> int:
        """Samples that do not count at a network's rate.

        Parameters
        ----------
        model : Narx
            Gives the sampling rate.

        Returns
        -------
        int
            Number of samples.
        """
        return round(self.washout_s * model.sampling_rate_hz)

    def mean_square(self, model: Narx, sequences: Batch) -> Tensor:
        """Mean squared error that counts, differentiable by the network's weights.

        Parameters
        ----------
        model : Narx
            Network.
        sequences : Batch
            What to run it on.

        Returns
        -------
        Tensor
            Scalar, rad^2.
        """
        angles, _ = model(sequences.rates_rad_s, sequences.state, sequences.posture_rad)
        counts = torch.isfinite(sequences.targets_rad)
        counts[:, : self.washout_samples(model)] = False
        error = torch.where(counts, angles - sequences.targets_rad.nan_to_num(), 0.0)
        if self.offset_free:
            mean = error.sum(dim=1, keepdim=True) / counts.sum(dim=1, keepdim=True).clamp(min=1)
            error = torch.where(counts, error - mean, 0.0)
        axes = torch.tensor(self.axis_weights, dtype=error.dtype)
        weights = sequences.weight[:, None, None] * axes * counts
        return (weights * error.square()).sum() / weights.sum()


@dataclass(frozen=True)
class FitReport:
    """What an optimizer has to say about its result.

    Parameters
    ----------
    code : str
        Why it stopped.
    iterations : int
        Of the kept restart.
    history : list of dict
        Numbers by name, one an iteration of the kept restart.
    restarts : dict
        Spread over restarts: how many, how many were dropped, quantiles of the validation error.
    """

    code: str
    iterations: int
    history: list[dict[str, float]]
    restarts: dict[str, float]


class Optimizer(Protocol):
    """Finds weights: Levenberg-Marquardt, LBFGS, Adam."""

    def fit(
        self,
        model: Narx,
        training: Batch,
        validation: Batch,
        objective: Objective,
        rng: np.random.Generator,
        log: Log,
    ) -> FitReport:
        """Set the weights of a network to the best found."""
        ...
