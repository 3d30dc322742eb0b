"""Kalman update by one number at a time.

Arrays end with the sensors side by side: x (n, W), covariance (n, n, W). `work` (rows, n, W) holds
intermediate results: the rows DIRECTION, of the measurement, and PRODUCT.
"""

from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled
from narx.kernels.functions import load, store
from narx.kernels.sizes import SCALAR
from narx.kernels.tracker_layout import DIRECTION, PRODUCT


@compiled(**EXACT_VIEWS)
def spread(covariance: Any, work: Any, lane: int) -> float:
    """Fill work[PRODUCT] of one sensor with covariance . direction.

    Returns the variance of direction . x.
    """
    n, total = len(covariance), 0.0
    for j in range(n):
        work[PRODUCT, j, lane] = 0.0
    for i in range(n):
        share = work[DIRECTION, i, lane]
        if share != 0.0:
            for j in range(n):
                work[PRODUCT, j, lane] += share * covariance[i, j, lane]
    for i in range(n):
        total += work[PRODUCT, i, lane] * work[DIRECTION, i, lane]
    return total


@compiled(**EXACT_VIEWS)
def _update(
    x: Any, covariance: Any, work: Any, total: Any, residual: Any, share: Any, lane: int, lanes: Any
) -> None:
    """Update lanes from `lane` on; share is 1, or 0 where there is no measurement."""
    n = len(x)
    for i in range(n):
        gain = share * load(lanes, work, (PRODUCT, i, lane)) / total
        store(lanes, x, (i, lane), load(lanes, x, (i, lane)) + gain * residual)
        for j in range(n):
            taken = gain * load(lanes, work, (PRODUCT, j, lane))
            left = load(lanes, covariance, (i, j, lane)) - taken
            store(lanes, covariance, (i, j, lane), left)


@compiled(**EXACT_VIEWS)
def measure(
    x: Any, covariance: Any, work: Any, variance: float, residual: float, lane: int
) -> None:
    """Update one sensor by one number: `residual` = measured - direction . x."""
    total = spread(covariance, work, lane) + variance
    _update(x, covariance, work, total, residual, 1.0, lane, SCALAR)


@compiled(**EXACT_VIEWS)
def measure_state(
    x: Any, covariance: Any, at: int, work: Any, variance: float, residual: Any, share: Any,
    lanes: Any,
) -> None:  # fmt: skip
    """Update the sensors with a share of 1, not 0, by a number: `residual` = measured - x[at]."""
    for i in range(len(x)):
        store(lanes, work, (PRODUCT, i, 0), load(lanes, covariance, (at, i, 0)))
    total = load(lanes, covariance, (at, at, 0)) + variance
    _update(x, covariance, work, total, residual, share, 0, lanes)
