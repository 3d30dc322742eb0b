"""Stopping rules of a solver, and their result codes."""

from dataclasses import dataclass
from enum import StrEnum

from narx.kernels import lm_step


class ResultCode(StrEnum):
    """Reason for stopping."""

    RUNNING = "running"
    GRADIENT = "gradient is small"
    STEP = "step is small"
    COST_CHANGE = "cost no longer falls"
    COST = "cost is low enough"
    EVALUATIONS = "all evaluations are used"
    DAMPING = "no step lowers the cost"
    NOT_FINITE = "cost is not finite"


# the compiled solver refers to these by number
CODES = {
    lm_step.RUNNING: ResultCode.RUNNING,
    lm_step.GRADIENT: ResultCode.GRADIENT,
    lm_step.STEP: ResultCode.STEP,
    lm_step.COST_CHANGE: ResultCode.COST_CHANGE,
    lm_step.COST: ResultCode.COST,
    lm_step.EVALUATIONS: ResultCode.EVALUATIONS,
    lm_step.DAMPING: ResultCode.DAMPING,
    lm_step.NOT_FINITE: ResultCode.NOT_FINITE,
}


@dataclass(frozen=True)
class Stopping:
    """Limits of a solver; zero switches a tolerance off.

    Parameters
    ----------
    max_evaluations : int
        Evaluations of residuals and derivatives after the first.
    gradient : float
        Largest entry of the gradient, relative to the cost.
    step : float
        Norm of an accepted step, relative to that of the weights.
    cost_change : float
        Decrease of the cost by an accepted step, relative.
    squares : float
        Sum of squared residuals at which to stop.
    """

    max_evaluations: int = 100
    gradient: float = 1e-12
    step: float = 1e-12
    cost_change: float = 0.0
    squares: float = 0.0
