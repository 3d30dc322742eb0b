"""Levenberg-Marquardt, for one start or many in parallel.

The solver combines a problem (`narx.training.least_squares`: open loop, several steps, closed loop,
coupled axes), damping, stopping rules and regularisation.
Each evaluation gives cost, gradient and Gauss-Newton matrix together, so an accepted step needs no
second pass; a step that does not lower the cost is never accepted.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from narx.kernels import lm_step
from narx.kernels.lm_step import RUNNING, damped_steps, decide
from narx.training.least_squares.problem import LeastSquaresProblem
from narx.training.least_squares.stopping import CODES, ResultCode, Stopping
from narx.types import FloatArray

_HISTORY = ("cost", "damping", "gradient")
# attributes that change from iteration to iteration
_STATE = (
    "weights", "products", "cost", "decay", "codes", "mu", "growth", "mu_unit", "n_evaluations",
)  # fmt: skip
# first mu, relative to the largest diagonal entry for the identity
_FIRST_MU = 1e-3
# smallest and largest mu; the solver stops beyond the largest
_MU_BOUNDS = (1e-18, 1e10)


@dataclass(frozen=True)
class Options:
    """Parts of the solver.

    Parameters
    ----------
    stopping : Stopping
        Limits.
    damping : {"identity", "diagonal"}
        ``JTJ + mu I`` (Levenberg) or ``JTJ + mu diag(JTJ)`` (Marquardt), with a mu that follows the
        ratio of the actual to the predicted decrease of the cost (Nielsen 1999).
    bayesian : bool
        Choose the weight decay by the evidence after every accepted step (MacKay 1992; Foresee and
        Hagan 1997, as MATLAB's trainbr), starting from zero.
    """

    stopping: Stopping = field(default_factory=Stopping)
    damping: Literal["identity", "diagonal"] = "identity"
    bayesian: bool = False


@dataclass(frozen=True)
class Result:
    """Results of R starts.

    Parameters
    ----------
    weights : ndarray, shape (R, P)
        Best weights.
    cost : ndarray, shape (R,)
        Half the sum of squared residuals at these weights, without regularisation.
    codes : list of ResultCode
        Reason for stopping of each start.
    n_evaluations : ndarray of int, shape (R,)
        Evaluations after the first.
    weight_decay : ndarray, shape (R,)
        Last weight decay.
    history : dict of str to ndarray, shape (evaluations + 1, R)
        ``cost`` (regularised, of the current weights), ``damping`` and ``gradient`` (largest
        entry) of every iteration, and the cost after the last; NaN after a start has stopped.
    """

    weights: FloatArray
    cost: FloatArray
    codes: list[ResultCode]
    n_evaluations: NDArray[np.int64]
    weight_decay: FloatArray
    history: dict[str, FloatArray]


def levenberg_marquardt(
    problem: LeastSquaresProblem,
    weights: ArrayLike,
    options: Options | None = None,
    *,
    trainable: ArrayLike | None = None,
    log: Callable[[FloatArray], None] | None = None,
    state: Mapping[str, Any] | None = None,
    keep: Callable[[Callable[[], dict[str, Any]]], None] | None = None,
) -> Result:
    """Minimise half a sum of squares.

    Parameters
    ----------
    problem : LeastSquaresProblem
        Residuals and their derivatives.
    weights : array_like, shape (P,) or (R, P)
        One start, or several that are trained independently in parallel.
    options : Options, optional
        Parts of the solver; defaults if not given.
    trainable : array_like of bool, shape (P,), optional
        Weights that may change; by default all (odd networks keep their biases at zero).
    log : callable, optional
        Called after each iteration with the starts' costs, NaN where one has stopped.
    state : mapping of str to object, optional
        State of an earlier call with the same arguments, from which to continue.
    keep : callable, optional
        Called after each iteration with a function that returns the state.

    Returns
    -------
    Result
        One row per start.
    """
    run = _Run(problem, np.atleast_2d(np.array(weights, dtype=np.float64)), options or Options())
    free = np.arange(problem.n_weights)
    run.free = free if trainable is None else free[np.asarray(trainable, dtype=bool)]
    if state is None:
        run.start()
    else:
        run.restore(state)
    for _ in range(len(run.history), run.options.stopping.max_evaluations):
        active = np.flatnonzero(run.codes == RUNNING)
        if not len(active):
            break
        run.iterate(active)
        if log is not None:
            log(np.where(np.isin(np.arange(len(run.cost)), active), run.cost, np.nan))
        if keep is not None:
            keep(run.state)
    return run.result()


class _Run:
    """State of a minimisation at the current weights."""

    free: NDArray[np.int64]

    def __init__(self, problem: LeastSquaresProblem, weights: FloatArray, options: Options) -> None:
        n = len(weights)
        self.problem, self.options, self.weights = problem, options, weights
        self.products = np.ascontiguousarray(problem.products(weights))
        self.decay = np.zeros(n)
        self.codes = np.full(n, RUNNING)
        self.mu, self.growth = np.full(n, _FIRST_MU), np.full(n, 2.0)
        self.diagonal = options.damping == "diagonal"
        self.mu_unit = np.ones(n) if self.diagonal else _largest_diagonal(self.products)
        self.n_evaluations = np.zeros(n, dtype=np.int64)
        self.history: list[FloatArray] = []
        stopping = options.stopping
        self.stopping = (
            stopping.gradient, stopping.step, stopping.cost_change, stopping.squares,
        )  # fmt: skip

    def start(self) -> None:
        self.cost = self._cost(self.products, self.weights, self.decay)
        self.codes[~np.isfinite(self.cost)] = lm_step.NOT_FINITE

    def state(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _STATE} | {"history": self.history}

    def restore(self, state: Mapping[str, Any]) -> None:
        for name in _STATE:
            setattr(self, name, state[name].numpy().copy())
        self.history = [row.numpy() for row in state["history"]]

    def iterate(self, active: NDArray[np.int64]) -> None:
        n = len(active)
        trial, predicted = np.empty((n, self.weights.shape[1])), np.empty(n)
        gradient = np.full(len(self.cost), np.nan)
        mu = self.mu * self.mu_unit
        damped_steps(
            active, self.products, self.weights, self.free, mu, self.decay, self.diagonal,
            trial, predicted, gradient,
        )  # fmt: skip
        self._record(mu, gradient)
        trial_products = np.ascontiguousarray(self.problem.products(trial))
        self.n_evaluations[active] += 1
        kept = np.empty(n, dtype=np.bool_)
        decide(
            active, trial, trial_products, predicted, gradient, self.free, self.decay,
            self.stopping, _MU_BOUNDS,
            self.weights, self.products, self.cost, self.mu, self.growth, self.codes, kept,
        )  # fmt: skip
        if self.options.bayesian and kept.any():
            self._choose_decay(active[kept])

    def result(self) -> Result:
        self.codes[self.codes == RUNNING] = lm_step.EVALUATIONS
        self._record(self.mu * self.mu_unit, np.full(len(self.cost), np.nan))
        history = np.array(self.history)
        return Result(
            self.weights,
            0.5 * self.products[:, -1, -1],
            [CODES[code] for code in self.codes],
            self.n_evaluations,
            self.decay,
            {name: history[:, i] for i, name in enumerate(_HISTORY)},
        )

    def _cost(self, products: FloatArray, weights: FloatArray, decay: FloatArray) -> FloatArray:
        cost = 0.5 * products[:, -1, -1]
        if self.options.bayesian:
            cost = cost + 0.5 * decay * (weights[:, self.free] ** 2).sum(axis=1)
        return cost

    def _choose_decay(self, chosen: NDArray[np.int64]) -> None:
        """Set the weight decay to maximise the evidence (Foresee and Hagan 1997)."""
        pick = np.ix_(chosen, self.free, self.free)
        matrix = self.products[pick]
        matrix = np.tril(matrix) + np.tril(matrix, -1).transpose(0, 2, 1)
        decay, n_free = self.decay[chosen], len(self.free)
        inverse = np.linalg.pinv(matrix + decay[:, None, None] * np.eye(n_free), hermitian=True)
        effective = n_free - decay * np.trace(inverse, axis1=1, axis2=2)
        squares = (self.weights[chosen][:, self.free] ** 2).sum(axis=1)
        errors = self.products[chosen, -1, -1]
        rest = np.maximum(self.problem.n_residuals - effective, 1.0)
        self.decay[chosen] = effective * errors / np.maximum(squares * rest, 1e-300)
        self.cost[chosen] = self._cost(
            self.products[chosen], self.weights[chosen], self.decay[chosen]
        )

    def _record(self, mu: FloatArray, gradient: FloatArray) -> None:
        row = np.array([self.cost, mu, gradient])
        # the cost after a start's last step is its last number
        row[:, self.n_evaluations < len(self.history)] = np.nan
        self.history.append(row)


def _largest_diagonal(products: FloatArray) -> FloatArray:
    """Largest diagonal entry of each start's JTJ, or 1."""
    largest = np.diagonal(products[:, :-1, :-1], axis1=1, axis2=2).max(axis=1)
    return np.where(np.isfinite(largest) & (largest > 0), largest, 1.0)
