"""What a trial step means: is it kept, how is damping changed, does the start stop?

Compiled, since with one start the solver would otherwise spend as long on arrays of one number
as on the whole recording.
"""

from typing import Any

import numpy as np

from narx.kernels.lanes import JIT, njit
from narx.training.least_squares.damping import adapt
from narx.training.least_squares.stopping import ResultCode

# the compiled part knows codes by number
CODES = tuple(ResultCode)
RUNNING, GRADIENT, STEP, COST_CHANGE, COST, DAMPING = (
    CODES.index(code)
    for code in (
        ResultCode.RUNNING,
        ResultCode.GRADIENT,
        ResultCode.STEP,
        ResultCode.COST_CHANGE,
        ResultCode.COST,
        ResultCode.DAMPING,
    )
)
_TINY = float(np.finfo(float).tiny)


@njit(**JIT)
def decide(
    active: Any,
    trial: Any,
    trial_products: Any,
    predicted: Any,
    gradient: Any,
    free: Any,
    decay: Any,
    stopping: Any,
    gain_ratio: bool,
    damping: Any,
    weights: Any,
    products: Any,
    cost: Any,
    mu: Any,
    growth: Any,
    codes: Any,
    kept: Any,
) -> None:
    """Judge the trial weights of the active starts and change what is known of them in place.

    active (A,) of the R starts; trial (A, P), trial_products (A, P + 1, P + 1), predicted (A,)
    decrease; gradient (R,) at the weights before, free (F,) weights that move, decay (R,).
    stopping: limits of gradient, step, cost change and sum of squares; damping: as `adapt` takes
    them, and the largest. weights (R, P), products (R, P + 1, P + 1), cost, mu, growth and codes
    (R,) are changed; kept (A,) is set.
    """
    n_weights = weights.shape[1]
    for at in range(len(active)):
        r = active[at]
        old = cost[r]
        new = 0.5 * trial_products[at, n_weights, n_weights]
        if decay[r] > 0.0:
            squares = 0.0
            for i in range(len(free)):
                squares += trial[at, free[i]] ** 2
            new += 0.5 * decay[r] * squares
        kept[at] = new < old
        gain = (old - new) / predicted[at]
        mu[r], growth[r] = adapt(mu[r], growth[r], kept[at], gain, gain_ratio, damping[:3])
        code = RUNNING
        if mu[r] > damping[3]:
            code = DAMPING
        if kept[at]:
            size = reach = 0.0
            for i in range(n_weights):
                size += (trial[at, i] - weights[r, i]) ** 2
                reach += weights[r, i] ** 2
                weights[r, i] = trial[at, i]
            for i in range(n_weights + 1):
                for j in range(i + 1):
                    products[r, i, j] = trial_products[at, i, j]
            cost[r] = new
            if stopping[2] > 0.0 and old - new <= stopping[2] * old:
                code = COST_CHANGE
            if stopping[1] > 0.0 and size <= stopping[1] ** 2 * reach:
                code = STEP
        if stopping[3] > 0.0 and products[r, n_weights, n_weights] <= stopping[3]:
            code = COST
        if stopping[0] > 0.0 and gradient[r] <= stopping[0] * max(old, _TINY):
            code = GRADIENT
        codes[r] = code
