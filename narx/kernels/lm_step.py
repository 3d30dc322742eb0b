"""One Levenberg-Marquardt iteration for many starts: the damped steps, and their acceptance.

Compiled, since with one start the overhead of numpy on tiny arrays would otherwise take as long as
running the whole recording.
"""

from typing import Any

import numpy as np

from narx.kernels.compiler import INNER, JIT, compiled

# reasons for stopping a start (or none); named in `narx.training.least_squares.stopping`
RUNNING, GRADIENT, STEP, COST_CHANGE, COST, EVALUATIONS, DAMPING, NOT_FINITE = range(8)
_TINY = float(np.finfo(float).tiny)


@compiled(**INNER)
def adapt(mu: float, growth: float, kept: bool, gain: float, least: float) -> tuple[float, float]:
    """Change mu after a step (Nielsen 1999); returns mu and the factor of the next increase.

    `gain` is the actual over the predicted decrease, `least` the smallest mu.
    """
    if not kept:
        return max(mu * growth, least), 2.0 * growth
    bend = 2.0 * gain - 1.0
    return max(mu * max(1.0 / 3.0, 1.0 - bend * bend * bend), least), 2.0


@compiled(**JIT)
def damped_steps(
    active: Any,
    products: Any,
    weights: Any,
    free: Any,
    mu: Any,
    decay: Any,
    diagonal: bool,
    trial: Any,
    predicted: Any,
    gradient: Any,
) -> None:
    """Solve (JTJ + decay I + damping) step = -gradient by Cholesky, start by start.

    active (A,) of the R starts; products (R, P + 1, P + 1), weights (R, P), free (F,) indices of
    trainable weights, mu and decay (R,). trial (A, P) weights after the step, NaN where the matrix
    is not positive; predicted (A,) decrease of the quadratic model, gradient (R,) its largest
    entry.
    """
    n, n_weights = len(free), weights.shape[1]
    factor = np.empty((n, n))
    g = np.empty(n)
    s = np.empty(n)
    for at in range(len(active)):
        r = active[at]
        largest = 0.0
        for i in range(n):
            a = free[i]
            g[i] = products[r, n_weights, a] + decay[r] * weights[r, a]
            largest = max(largest, abs(g[i]))
        gradient[r] = largest
        for i in range(n):
            for j in range(i + 1):
                x = products[r, free[i], free[j]]
                if i == j:
                    x += decay[r] + mu[r] * (x if diagonal else 1.0)
                for k in range(j):
                    x -= factor[i, k] * factor[j, k]
                factor[i, j] = np.sqrt(x) if i == j else x / factor[j, j]
        for i in range(n):
            x = -g[i]
            for k in range(i):
                x -= factor[i, k] * s[k]
            s[i] = x / factor[i, i]
        for i in range(n - 1, -1, -1):
            x = s[i]
            for k in range(i + 1, n):
                x -= factor[k, i] * s[k]
            s[i] = x / factor[i, i]
        decrease = 0.0
        for i in range(n_weights):
            trial[at, i] = weights[r, i]
        for i in range(n):
            a = free[i]
            trial[at, a] += s[i]
            scale = mu[r]
            if diagonal:
                scale *= products[r, a, a]
            # L(0) - L(step) = step' (damping step - gradient) / 2
            decrease += 0.5 * s[i] * (scale * s[i] - g[i])
        predicted[at] = decrease


@compiled(**JIT)
def decide(
    active: Any,
    trial: Any,
    trial_products: Any,
    predicted: Any,
    gradient: Any,
    free: Any,
    decay: Any,
    stopping: Any,
    damping: Any,
    weights: Any,
    products: Any,
    cost: Any,
    mu: Any,
    growth: Any,
    codes: Any,
    kept: Any,
) -> None:
    """Accept or reject the trial weights of the active starts, and update their state in place.

    active (A,) of the R starts; trial (A, P), trial_products (A, P + 1, P + 1), predicted (A,)
    decrease; gradient (R,) at the previous weights, free (F,) trainable weights, decay (R,).
    stopping: limits of gradient, step, cost change and sum of squares; damping: smallest and
    largest mu. weights (R, P), products (R, P + 1, P + 1), cost, mu, growth and codes (R,) are
    changed; kept (A,) is set.
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
        mu[r], growth[r] = adapt(mu[r], growth[r], kept[at], gain, damping[0])
        code = RUNNING
        if mu[r] > damping[1]:
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
