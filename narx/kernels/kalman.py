"""Kalman update by one number at a time, in compiled code.

`work` holds intermediate results: the rows DIRECTION, of the measurement, and PRODUCT.
"""

from typing import Any

from narx.kernels.compiler import EXACT_INNER, compiled

DIRECTION, PRODUCT = 0, 1


@compiled(**EXACT_INNER)
def spread(covariance: Any, work: Any) -> float:
    """Fill work[PRODUCT] with covariance . direction; return the variance of direction . x."""
    n, total = len(covariance), 0.0
    for j in range(n):
        work[PRODUCT, j] = 0.0
    for i in range(n):
        share = work[DIRECTION, i]
        if share != 0.0:
            for j in range(n):
                work[PRODUCT, j] += share * covariance[i, j]
    for i in range(n):
        total += work[PRODUCT, i] * work[DIRECTION, i]
    return total


@compiled(**EXACT_INNER)
def _update(x: Any, covariance: Any, work: Any, total: float, residual: float) -> None:
    n = len(x)
    for i in range(n):
        gain = work[PRODUCT, i] / total
        x[i] += gain * residual
        for j in range(n):
            covariance[i, j] -= gain * work[PRODUCT, j]


@compiled(**EXACT_INNER)
def measure(x: Any, covariance: Any, work: Any, variance: float, residual: float) -> None:
    """Kalman update by one number: `residual` = measured - direction . x."""
    _update(x, covariance, work, spread(covariance, work) + variance, residual)


@compiled(**EXACT_INNER)
def measure_state(
    x: Any, covariance: Any, at: int, work: Any, variance: float, residual: float
) -> None:
    """Kalman update by one number: `residual` = measured - x[at]."""
    for i in range(len(x)):
        work[PRODUCT, i] = covariance[at, i]
    _update(x, covariance, work, covariance[at, at] + variance, residual)
