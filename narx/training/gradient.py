"""Training by gradients through the closed loop: torch's LBFGS and Adam."""

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from narx.errors import UserError
from narx.network.model import Narx
from narx.training.batch import Batch
from narx.training.initial_weights import random_weights
from narx.training.objective import FitReport, Log, Objective

# one optimiser step on a network: takes the closure that computes cost and gradient
_Stepper = Callable[[Callable[[], Tensor]], None]


@dataclass(frozen=True)
class _GradientOptimizer:
    restarts: int = 4
    iterations: int = 100
    gradient_clip: float = 1.0

    def _stepper(self, model: Narx) -> _Stepper:
        raise NotImplementedError

    def fit(
        self,
        model: Narx,
        training: Batch,
        validation: Batch,
        objective: Objective,
        rng: np.random.Generator,
        log: Log,
    ) -> FitReport:
        """Train from several starts and keep the best by its error on held-back samples.

        Parameters
        ----------
        model : Narx
            Network; its weights are set to the best found.
        training, validation : Batch
            Sequences; the second chooses.
        objective : Objective
            What is minimised.
        rng : numpy.random.Generator
            Draws the starts.
        log : callable
            Told cost and gradient of every iteration, restart after restart.

        Returns
        -------
        FitReport
            History of the kept restart.

        Raises
        ------
        UserError
            If no restart stayed finite.
        """
        errors: list[float] = []
        best: tuple[float, Tensor, list[dict[str, float]]] | None = None
        for _ in range(self.restarts):
            candidate = copy.deepcopy(model)
            with torch.no_grad():
                candidate.weights.copy_(torch.from_numpy(random_weights(candidate, rng)))
            history = self._descend(candidate, training, objective, log)
            with torch.no_grad():
                error = math.sqrt(float(objective.mean_square(candidate, validation)))
            errors.append(error)
            if math.isfinite(error) and (best is None or error < best[0]):
                best = error, candidate.weights.detach().clone(), history
        if best is None:
            raise UserError(f"training: none of {self.restarts} restarts stayed finite")
        with torch.no_grad():
            model.weights.copy_(best[1])
        finite = np.array([error for error in errors if math.isfinite(error)])
        return FitReport(
            "iterations",
            len(best[2]),
            best[2],
            {
                "restarts": float(self.restarts),
                "dropped": float(self.restarts - len(finite)),
                "validation_rmse_best_deg": float(np.rad2deg(finite.min())),
                "validation_rmse_median_deg": float(np.rad2deg(np.median(finite))),
                "validation_rmse_worst_deg": float(np.rad2deg(finite.max())),
            },
        )

    def _descend(
        self, model: Narx, training: Batch, objective: Objective, log: Log
    ) -> list[dict[str, float]]:
        step, trainable = self._stepper(model), model.trainable
        history: list[dict[str, float]] = []
        kept, lowest = model.weights.detach().clone(), math.inf
        for iteration in range(self.iterations):
            latest: dict[str, float] = {}

            def closure(latest: dict[str, float] = latest) -> Tensor:
                nonlocal kept, lowest
                model.zero_grad()
                cost = objective.mean_square(model, training)
                cost.backward()
                gradient = model.weights.grad
                assert gradient is not None
                gradient[~trainable] = 0.0
                if not torch.isfinite(gradient).all():
                    gradient.zero_()
                norm = float(torch.nn.utils.clip_grad_norm_([model.weights], self.gradient_clip))
                value = float(cost.detach())
                if value < lowest:
                    kept, lowest = model.weights.detach().clone(), value
                if not latest:
                    latest |= {"cost": value, "gradient": norm}
                return cost

            step(closure)
            history.append(latest)
            log(iteration, latest)
        with torch.no_grad():
            model.weights.copy_(kept)
        return history


@dataclass(frozen=True)
class Lbfgs(_GradientOptimizer):
    """Limited-memory BFGS with a strong Wolfe line search (`torch.optim.LBFGS`).

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Per restart.
    gradient_clip : float
        Largest norm of the gradient; the closed loop's can be huge far from a solution.
    history_size : int
        Updates that LBFGS remembers.
    """

    history_size: int = 20

    def _stepper(self, model: Narx) -> _Stepper:
        optimizer = torch.optim.LBFGS(
            [model.weights],
            max_iter=1,
            history_size=self.history_size,
            line_search_fn="strong_wolfe",
        )
        return lambda closure: optimizer.step(closure) and None


@dataclass(frozen=True)
class Adam(_GradientOptimizer):
    """Adam (`torch.optim.Adam`).

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Per restart.
    gradient_clip : float
        Largest norm of the gradient.
    learning_rate : float
        Step size.
    """

    learning_rate: float = 3e-3

    def _stepper(self, model: Narx) -> _Stepper:
        optimizer = torch.optim.Adam([model.weights], lr=self.learning_rate)
        return lambda closure: optimizer.step(closure) and None
