"""Objective of training, and the report of an optimizer."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
import torch
from pydantic import Field
from torch.nn.functional import pad

from narx.errors import UserError
from narx.network.model import Narx
from narx.settings import Seconds, check_fields
from narx.training.batch import Batch
from narx.training.progress import Progress
from narx.types import FloatArray

_NotNegative = Annotated[float, Field(ge=0)]

# progress reported by an optimizer: iteration, and numbers by name (cost, damping, ...)
Log = Callable[[int, dict[str, float]], None]

# the artificial return to rest: from about ten degrees, over this number of time constants
_REST_ANGLE_RAD = 0.2
_REST_TIME_CONSTANTS = 4.0


@dataclass(frozen=True)
class Objective:
    """Objective of training: the closed-loop error relative to the teacher.

    Parameters
    ----------
    axis_weights : tuple of three floats
        Weights of the squared errors of the sagittal, frontal and transverse axis.
    offset_free : bool, optional
        Remove each sequence's mean error on each axis first: the start-up finds the mean angle.
        For coupled axes alone, and by default.
    washout_s : float
        Time after a sequence's start that is not scored, s.
    rest_weight : float
        Weight of an artificial sequence relative to all others together: from a wrong angle and
        without motion, the network should return to its posture as exp(-rest_leak_rad_s t). Ten
        seconds of walking determine neither the rate of this leak nor even its sign: a pole
        outside the unit circle fits them equally well. 0 leaves the sequence out.
    rest_leak_rad_s : float
        Rate of this leak, rad/s.

    Raises
    ------
    UserError
        If a value is out of its range, or all axis weights are zero.
    """

    axis_weights: tuple[_NotNegative, _NotNegative, _NotNegative] = (1.0, 1.0, 0.0)
    offset_free: bool | None = None
    washout_s: Seconds = 0.0
    rest_weight: _NotNegative = 0.1
    # a slower return would need more samples than any training sequence has
    rest_leak_rad_s: Annotated[float, Field(ge=1e-3, le=100)] = 0.05

    def __post_init__(self) -> None:
        check_fields(self, "model.objective")
        if not any(self.axis_weights):
            raise UserError(
                f"model.objective.axis_weights is {list(self.axis_weights)}, expected one above 0"
            )

    def for_axes(self, coupled: bool) -> "Objective":
        """Return the objective of a network whose axes are coupled or not.

        Parameters
        ----------
        coupled : bool
            As the network's.

        Returns
        -------
        Objective
            With `offset_free` decided.

        Raises
        ------
        UserError
            If mean errors are to be removed, and the axes are not coupled.
        """
        if self.offset_free and not coupled:
            raise UserError(
                "model.objective.offset_free=true needs model.coupled=true; leave it out, or set "
                "model.objective.offset_free=false"
            )
        return replace(self, offset_free=coupled) if self.offset_free is None else self

    def washout_samples(self, model: Narx) -> int:
        """Number of samples in the washout at a network's rate.

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

    def with_rest(self, model: Narx, sequences: Batch) -> Batch:
        """Add the artificial return to rest to training sequences.

        Parameters
        ----------
        model : Narx
            Gives rate and scales.
        sequences : Batch
            Training sequences.

        Returns
        -------
        Batch
            Batch with one more row, and long enough for the return; unchanged if `rest_weight` is
            zero.
        """
        if self.rest_weight == 0:
            return sequences
        n = max(
            sequences.rates_rad_s.shape[1],
            round(_REST_TIME_CONSTANTS / self.rest_leak_rad_s * model.sampling_rate_hz),
        )
        time_s = np.arange(1, n + 1) / model.sampling_rate_hz
        angle = torch.full((3,), _REST_ANGLE_RAD, dtype=torch.float64)
        # by numpy: torch's threads give other last digits in one process of some hundred
        target = torch.from_numpy(_REST_ANGLE_RAD * np.exp(-self.rest_leak_rad_s * time_s))
        padding = (0, 0, 0, n - sequences.rates_rad_s.shape[1])
        axes = torch.tensor(self.axis_weights, dtype=torch.float64)
        counts = torch.isfinite(sequences.targets_rad) * sequences.weight[:, None, None]
        weight = self.rest_weight * (counts * axes).sum() / (axes.sum() * n)
        return Batch(
            torch.cat([pad(sequences.rates_rad_s, padding), torch.zeros(1, n, 3)]),
            torch.cat(
                [
                    pad(sequences.targets_rad, padding, value=math.nan),
                    target[None, :, None].expand(1, n, 3),
                ]
            ),
            torch.cat([sequences.state, model.initial_state(angle)[None]]),
            torch.cat([sequences.posture_rad, torch.zeros(1, 3)]),
            torch.cat([sequences.weight, weight[None]]),
        )


@dataclass(frozen=True)
class FitReport:
    """Report of an optimizer on its result.

    Parameters
    ----------
    code : str
        Reason for stopping.
    iterations : int
        Iterations of the best restart.
    history : list of dict
        Numbers by name, one entry per iteration of the best restart.
    evaluations : int
        Evaluations of the cost, over all restarts.
    restarts : dict
        Spread over restarts: their number, the number dropped, quantiles of the validation error.
    """

    code: str
    iterations: int
    history: list[dict[str, float]]
    evaluations: int
    restarts: dict[str, float]


@runtime_checkable
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
        start: FloatArray | None = None,
        progress: Progress | None = None,
    ) -> FitReport:
        """Set the weights of a network to the best found.

        Parameters
        ----------
        model : Narx
            Network.
        training, validation : Batch
            Sequences; the second is used to choose among starts.
        objective : Objective
            Objective to minimise.
        rng : numpy.random.Generator
            Draws the starts.
        log : callable
            Called with iteration and numbers by name: ``restart_00/cost_deg2``.
        start : ndarray, shape (P,), optional
            Weights from which to continue, instead of random starts.
        progress : Progress, optional
            State of this training where it was cut off, kept from then on; not given to an
            optimizer that takes none, which then begins anew.

        Returns
        -------
        FitReport
            Report of the optimizer.
        """
        ...
