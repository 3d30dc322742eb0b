"""Kalman update by one number at a time, in compiled code."""

from typing import Any

from narx.kernels.compiler import EXACT_INNER, compiled


@compiled(**EXACT_INNER)
def spread(covariance: Any, direction: Any, product: Any) -> float:
    """Fill `product` with covariance . direction; return the variance of direction . x."""
    total = 0.0
    product[:] = 0.0
    for i in range(len(direction)):
        if direction[i] != 0.0:
            for j in range(len(direction)):
                product[j] += direction[i] * covariance[i, j]
    for i in range(len(direction)):
        total += product[i] * direction[i]
    return total


@compiled(**EXACT_INNER)
def measure(x: Any, covariance: Any, work: Any, variance: float, residual: float) -> None:
    """Kalman update by one number: `residual` = measured - direction . x, in work[0]."""
    n, product = len(x), work[1]
    total = spread(covariance, work[0], product) + variance
    for i in range(n):
        gain = product[i] / total
        x[i] += gain * residual
        for j in range(n):
            covariance[i, j] -= gain * product[j]
