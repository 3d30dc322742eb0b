"""Training by Levenberg-Marquardt: many starts, a curriculum, the best on held-out samples."""

import threading
from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch

from narx.network.model import Narx
from narx.settings import check_fields
from narx.training.batch import Batch
from narx.training.least_squares.solver import Options
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import multi_start
from narx.training.objective import FitReport, Log, Objective
from narx.training.optimizer import (
    Curriculum,
    IterationCount,
    NotNegative,
    Share,
    StartCount,
    restart_tag,
    spread_report,
    starts_of,
)
from narx.training.progress import Progress
from narx.training.stages import closed_loop_fit, stages_of
from narx.types import FloatArray


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Levenberg-Marquardt with exact sensitivities.

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Evaluations per start and stage.
    curriculum : sequence of {"open", int, "closed"}
        Stages (`narx.training.stages.stages_of`).
    prior_deg2 : float
        Mean squared error, in deg^2, equivalent to a change of a weight of the leaky integrator by
        100 %; 0 for no prior.
    cost_change : float
        A start stops when a step lowers its cost by less than this share; 0 for never, as below.
    gradient : float
        A start stops when no entry of its gradient is larger than this share of its cost.
    step : float
        A start stops when a step changes its weights by less than this share of their norm.
    cost_deg2 : float
        A start ends a stage whose cost is as low as this, deg^2.
    damping : {"diagonal", "identity"}
        Marquardt's, in proportion to each weight's own curvature, or Levenberg's, equal for all:
        the weights of the first and second layer differ in size by orders of magnitude.
    bayesian : bool
        Bayesian regularisation (`narx.training.least_squares.solver.Options`) instead of the prior.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    restarts: StartCount = 16
    iterations: IterationCount = 100
    curriculum: Curriculum = ("open", "closed")
    prior_deg2: NotNegative = 1.0
    cost_change: Share = 1e-6
    gradient: NotNegative = 1e-12
    step: NotNegative = 1e-12
    cost_deg2: NotNegative = 0.0
    damping: Literal["diagonal", "identity"] = "diagonal"
    bayesian: bool = False

    def __post_init__(self) -> None:
        check_fields(self, "optimizer")

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
            Called with the cost of every start, as ``restart_00/cost_deg2``, after each
            iteration.
        start : ndarray, shape (P,), optional
            Weights from which to continue in the last stage, instead of random starts.
        progress : Progress, optional
            State of this training where it was cut off, kept from then on.

        Returns
        -------
        FitReport
            History of the best start and the spread of all.

        Raises
        ------
        UserError
            If no sample is scored, or no start stays finite.
        """
        options = Options(
            Stopping(self.iterations, self.gradient, self.step, self.cost_change),
            self.damping,
            self.bayesian,
        )
        prior = 0.0 if self.bayesian else self.prior_deg2
        starts, curriculum = starts_of(model, rng, self.restarts, self.curriculum, start)
        stages = stages_of(model, training, objective, curriculum, prior)
        chosen_by, unit_deg2 = closed_loop_fit(model, validation, objective, "held-out")
        done: Counter[int] = Counter()
        lock = threading.Lock()

        def live(first: int, cost: FloatArray, mean_square: float) -> None:
            with lock:  # groups of starts run in threads
                numbers = {
                    f"{restart_tag(first + i)}/cost_deg2": 2.0 * float(value) * mean_square
                    for i, value in enumerate(cost)
                    if np.isfinite(value)
                }
                log(done[first], numbers)
                done[first] += 1

        result = multi_start(
            stages,
            starts,
            chosen_by,
            options,
            structure=model.structure,
            trainable=model.trainable.numpy(),
            low_enough=self.cost_deg2,
            log=live,
            progress=progress,
        )
        with torch.no_grad():
            model.weights.copy_(torch.from_numpy(result.weights))
        history = result.history(stages)
        errors_deg = result.errors * unit_deg2**0.5
        evaluations = sum(
            int((of_group.n_evaluations + 1).sum())
            for groups in result.stages.values()
            for of_group in groups
        )
        return FitReport(
            str(result.code), len(history), history, evaluations, spread_report(errors_deg)
        )
