"""Training by gradients through the closed loop: torch's LBFGS and Adam."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import torch
from pydantic import Field
from torch import Tensor

from narx.errors import UserError
from narx.network.model import Narx
from narx.settings import check_fields
from narx.training.batch import Batch
from narx.training.initial_weights import typical_sizes
from narx.training.objective import FitReport, Log, Objective
from narx.training.optimizer import (
    Curriculum,
    IterationCount,
    NotNegative,
    Share,
    StartCount,
    spread_report,
    starts_of,
)
from narx.training.progress import Progress, State
from narx.training.restarts import Restarts
from narx.training.stages import Stage, closed_loop_fit, stages_of
from narx.types import FloatArray

# lower limit of the curvature of the cost at the start of a stage, deg^2 per squared typical size;
# directions with less curvature are not scaled up further
_LEAST_CURVATURE = 1.0

# largest number of evaluations of a line search
_MOST_LINE_SEARCH = 26

# maps weights to the cost in deg^2 and its gradient
_Cost = Callable[[FloatArray], tuple[float, FloatArray]]
# one step of torch's optimiser
_Step = Callable[[Callable[[], Tensor]], None]


@dataclass(frozen=True)
class _GradientOptimizer:
    restarts: StartCount = 4
    iterations: IterationCount = 100
    curriculum: Curriculum = ("open", "closed")
    prior_deg2: NotNegative = 1.0
    cost_change: Share = 1e-6
    device: str | None = None

    # iterations over which the cost must fall by more than `cost_change` each
    _patience = 10

    def __post_init__(self) -> None:
        check_fields(self, "optimizer")
        if self.device is not None:
            try:
                # .item(), since the device "meta" has no values
                torch.zeros(1, dtype=torch.float64, device=self.device).item()
            except (RuntimeError, AssertionError, TypeError) as error:
                reason = str(error).splitlines()[0]
                raise UserError(f"optimizer.device is '{self.device}': {reason}") from error

    def _stepper(self, parameter: Tensor) -> tuple[_Step, list[Any]]:
        """Return a step of torch's optimiser, and what of it has a state to keep."""
        raise NotImplementedError

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
        """Train from several starts and keep the best by its error on held-out samples.

        Parameters
        ----------
        model : Narx
            Network; its weights are set to the best found.
        training, validation : Batch
            Sequences; the second is used to choose among starts.
        objective : Objective
            Objective to minimise.
        rng : numpy.random.Generator
            Draws the starts.
        log : callable
            Called with the cost of a start, as ``restart_00/cost_deg2``, after each iteration.
        start : ndarray, shape (P,), optional
            Weights from which to continue in the last stage, instead of random starts.
        progress : Progress, optional
            State of this training where it was cut off, kept from then on.

        Returns
        -------
        FitReport
            History of the best restart.

        Raises
        ------
        UserError
            If no sample is scored, or no restart stayed finite.
        """
        starts, curriculum = starts_of(model, rng, self.restarts, self.curriculum, start)
        stages = stages_of(model, training, objective, curriculum, self.prior_deg2)
        chosen_by, unit_deg2 = closed_loop_fit(model, validation, objective, "held-out")
        free = np.flatnonzero(model.trainable.numpy())
        size = typical_sizes(model)[free]
        run = Restarts(log, Progress() if progress is None else progress)
        while len(run.ends) < len(starts):
            run.begin(starts[len(run.ends)])
            for number in range(run.stage, len(stages)):
                end = self._descend(stages[number], number, free, size, run)
                if not run.end_stage(end, model.structure):
                    break
            run.end()
        ends = run.ends
        squares = chosen_by.products(np.array(ends))[:, -1, -1]
        errors_deg = np.sqrt(squares * unit_deg2 / chosen_by.total_weight)
        finite = np.isfinite(errors_deg)
        if not finite.any():
            raise UserError(f"training: none of {len(starts)} restarts stayed finite")
        best = int(np.argmin(np.where(finite, errors_deg, np.inf)))
        with torch.no_grad():
            model.weights.copy_(torch.from_numpy(ends[best]))
        history = run.histories[best]
        n_last = sum(row["stage"] == len(stages) - 1 for row in history)
        code = "all iterations are used" if n_last >= self.iterations else "cost no longer falls"
        evaluations = int(sum(row["evaluations"] for one in run.histories for row in one))
        return FitReport(code, len(history), history, evaluations, spread_report(errors_deg))

    def _descend(
        self, stage: Stage, number: int, free: np.ndarray, size: FloatArray, run: Restarts
    ) -> FloatArray:
        """Minimise one stage; return the weights with the lowest cost."""
        cost = _by_torch(stage, self.device) if self.device else _compiled(stage)
        start, state = run.weights, run.descent
        basis = _basis(stage, start, free, size) if state is None else state["basis"].numpy()
        parameter = torch.zeros(len(free), dtype=torch.float64, requires_grad=True)
        step, stateful = self._stepper(parameter)
        kept, lowest = start, math.inf
        costs: list[float] = []
        if state is not None:
            with torch.no_grad():
                parameter.copy_(state["parameter"])
            for one, its_state in zip(stateful, state["stateful"], strict=True):
                one.load_state_dict(its_state)
            kept, costs = state["kept"].numpy(), list(state["costs"])
            lowest = costs[-1]
        latest: dict[str, float] = {}

        def closure() -> Tensor:
            nonlocal kept, lowest
            weights = start.copy()
            weights[free] += basis @ parameter.detach().numpy()
            value, by_weights = cost(weights)
            gradient = basis.T @ by_weights[free]
            if not (math.isfinite(value) and np.isfinite(gradient).all()):
                value, gradient = math.inf, np.zeros_like(gradient)
            if value < lowest:
                kept, lowest = weights, value
            if not latest:
                norm = float(np.linalg.norm(gradient))
                latest.update(stage=float(number), cost_deg2=value, gradient=norm, evaluations=0.0)
            latest["evaluations"] += 1.0
            parameter.grad = torch.from_numpy(self._scaled(gradient, value))
            return torch.tensor(value, dtype=torch.float64)

        def now() -> State:
            return {
                "basis": basis,
                "parameter": parameter,
                "stateful": [one.state_dict() for one in stateful],
                "kept": kept,
                "costs": costs,
            }

        while len(costs) < self.iterations and not self._settled(costs):
            latest.clear()
            step(closure)
            run.record(dict(latest))
            costs.append(lowest)
            run.keep(now)
        return kept

    def _settled(self, costs: list[float]) -> bool:
        if len(costs) <= self._patience:
            return False
        before, now = costs[-1 - self._patience], costs[-1]
        return before - now <= self._patience * self.cost_change * before

    def _scaled(self, gradient: FloatArray, cost: float) -> FloatArray:
        return gradient


@dataclass(frozen=True)
class Lbfgs(_GradientOptimizer):
    """Limited-memory BFGS with a strong Wolfe line search (`torch.optim.LBFGS`).

    Weights are scaled by their typical sizes and by the curvature of the cost at the start of
    each stage: unscaled, they differ in size by a factor of 10^4.

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Iterations per restart and stage.
    curriculum : sequence of {"open", int, "closed"}
        Stages (`narx.training.stages.stages_of`).
    prior_deg2 : float
        As `narx.training.LevenbergMarquardt`.
    cost_change : float
        A restart stops when ten iterations lower its cost by less than ten times this fraction.
    device : str, optional
        Device on which torch operations compute the cost, such as ``cuda``; by default the compiled
        loop on the CPU is used.
    history_size : int
        Number of updates stored by LBFGS.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    history_size: Annotated[int, Field(ge=1, le=1000)] = 20

    def _stepper(self, parameter: Tensor) -> tuple[_Step, list[Any]]:
        optimizer = torch.optim.LBFGS(
            [parameter],
            max_iter=1,
            # torch's default, 1.25 max_iter, leaves the line search no evaluation
            max_eval=_MOST_LINE_SEARCH,
            history_size=self.history_size,
            line_search_fn="strong_wolfe",
            tolerance_grad=0.0,
            tolerance_change=0.0,
        )
        return lambda closure: optimizer.step(closure) and None, [optimizer]


@dataclass(frozen=True)
class Adam(_GradientOptimizer):
    """Adam (`torch.optim.Adam`) with a step size that rises, then decays to almost zero.

    Weights are scaled as in `Lbfgs`. Adam minimises the logarithm of the cost, which has the same
    minimum: a loop that is not yet stable has a cost of thousands, after which Adam's running mean
    of squared gradients would keep all later steps small.

    Parameters
    ----------
    restarts : int
        Random starts.
    iterations : int
        Iterations per restart and stage.
    curriculum : sequence of {"open", int, "closed"}
        Stages (`narx.training.stages.stages_of`).
    prior_deg2 : float
        As `narx.training.LevenbergMarquardt`.
    cost_change : float
        As `Lbfgs`; zero by default, because convergence is reached in the last, smallest steps.
    device : str, optional
        As `Lbfgs`.
    learning_rate : float
        Largest step size, in scaled weights.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    restarts: StartCount = 2
    iterations: IterationCount = 800
    cost_change: Share = 0.0
    learning_rate: Annotated[float, Field(ge=1e-9, le=10)] = 0.03

    _patience = 10**9

    def _stepper(self, parameter: Tensor) -> tuple[_Step, list[Any]]:
        optimizer = torch.optim.Adam([parameter], lr=self.learning_rate, betas=(0.9, 0.99))
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimizer,
            self.learning_rate,
            total_steps=max(self.iterations, 1),
            pct_start=0.1,
            final_div_factor=1e3,
            cycle_momentum=False,
        )

        def step(closure: Callable[[], Tensor]) -> None:
            optimizer.step(closure)
            schedule.step()

        return step, [optimizer, schedule]

    def _scaled(self, gradient: FloatArray, cost: float) -> FloatArray:
        return gradient / max(cost, 1e-300)


def _compiled(stage: Stage) -> _Cost:
    """Cost and gradient by the compiled loop: the last row of a problem's products."""

    def cost(weights: FloatArray) -> tuple[float, FloatArray]:
        last = stage.problem.products(weights[None])[0, -1] * stage.mean_square
        return float(last[-1]), 2.0 * last[:-1]

    return cost


def _by_torch(stage: Stage, device: str) -> _Cost:
    """Cost and gradient by torch operations, on any device."""

    def cost(weights: FloatArray) -> tuple[float, FloatArray]:
        w = torch.from_numpy(weights).to(device).requires_grad_()
        value = stage.problem.residuals(w).square().sum() * stage.mean_square
        (gradient,) = torch.autograd.grad(value, w)
        return float(value.detach()), gradient.cpu().numpy()

    return cost


def _basis(stage: Stage, start: FloatArray, free: np.ndarray, size: FloatArray) -> FloatArray:
    """Directions (P_free, P_free) with equal curvature of the cost, in units of typical sizes."""
    products = stage.problem.products(start[None])[0] * stage.mean_square
    lower = np.tril(products)
    curvature = (lower + np.tril(lower, -1).T)[np.ix_(free, free)] * np.outer(size, size)
    if not np.isfinite(curvature).all():
        return np.diag(size)
    bends, directions = np.linalg.eigh(curvature)
    return size[:, None] * directions / np.sqrt(np.maximum(bends, _LEAST_CURVATURE))
