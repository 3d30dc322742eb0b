"""How far a Levenberg-Marquardt step may go, and how it is computed."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from narx.kernels.lanes import INNER, JIT, njit
from narx.types import FloatArray


@dataclass(frozen=True)
class Damping:
    """Damping of the Gauss-Newton matrix, and what a step's success does to it.

    Parameters
    ----------
    scaling : {"identity", "diagonal"}
        ``JTJ + mu I`` (Levenberg) or ``JTJ + mu diag(JTJ)`` (Marquardt).
    policy : {"factor", "gain_ratio"}
        Multiply and divide by fixed factors (Marquardt 1963), or follow the ratio of the actual
        to the predicted decrease (Nielsen 1999).
    initial : float
        First mu, relative to the largest diagonal entry for the identity.
    increase, decrease : float
        Factors after a step that was not, or was, kept (policy ``factor``).
    smallest, largest : float
        Bounds of mu, relative as `initial`; beyond the largest the solver stops.
    """

    scaling: Literal["identity", "diagonal"] = "identity"
    policy: Literal["factor", "gain_ratio"] = "gain_ratio"
    initial: float = 1e-3
    increase: float = 10.0
    decrease: float = 0.1
    smallest: float = 1e-18
    largest: float = 1e10

    def scale(self, products: FloatArray) -> FloatArray:
        """Give the unit of mu for each start.

        Parameters
        ----------
        products : ndarray, shape (R, P + 1, P + 1)
            Products at the first weights.

        Returns
        -------
        ndarray, shape (R,)
            Largest diagonal entry of JTJ, or 1.
        """
        if self.scaling == "diagonal":
            return np.ones(len(products))
        diagonal = np.diagonal(products[:, :-1, :-1], axis1=1, axis2=2)
        largest = diagonal.max(axis=1)
        return np.where(np.isfinite(largest) & (largest > 0), largest, 1.0)


@njit(**INNER)
def adapt(
    mu: float, growth: float, kept: bool, gain: float, gain_ratio: bool, factors: Any
) -> tuple[float, float]:
    """Change mu after a step; returns mu and the factor of the next increase.

    `gain` is the actual over the predicted decrease; factors: increase, decrease, smallest mu.
    """
    increase, decrease, smallest = factors
    if not gain_ratio:
        return max(mu * (decrease if kept else increase), smallest), growth
    if not kept:
        return max(mu * growth, smallest), 2.0 * growth
    bend = 2.0 * gain - 1.0
    return max(mu * max(1.0 / 3.0, 1.0 - bend * bend * bend), smallest), 2.0


@njit(**JIT)
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
    condition: Any,
) -> None:
    """Solve (JTJ + decay I + damping) step = -gradient by Cholesky, start by start.

    active (A,) of the R starts; products (R, P + 1, P + 1), weights (R, P), free (F,) indices
    that may move, mu and decay (R,). trial (A, P) weights after the step, NaN where the matrix
    is not positive; predicted (A,) decrease of the quadratic model, gradient (R,) its largest
    entry, condition (A,) of the matrix as the factor's diagonal shows it.
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
        low, high = np.inf, 0.0
        for i in range(n):
            for j in range(i + 1):
                x = products[r, free[i], free[j]]
                if i == j:
                    x += decay[r] + mu[r] * (x if diagonal else 1.0)
                for k in range(j):
                    x -= factor[i, k] * factor[j, k]
                factor[i, j] = np.sqrt(x) if i == j else x / factor[j, j]
            positive = factor[i, i] > 0.0
            low, high = min(low, factor[i, i]) if positive else 0.0, max(high, factor[i, i])
        condition[at] = (high / low) ** 2
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


def step_by_qr(
    residuals: FloatArray,
    jacobian: FloatArray,
    weights: FloatArray,
    free: NDArray[np.int64],
    mu: float,
    decay: float,
    diagonal: bool,
) -> tuple[FloatArray, float]:
    """Solve for one step by QR of the augmented system, which does not square the condition.

    Parameters
    ----------
    residuals : ndarray, shape (N,)
        Residuals.
    jacobian : ndarray, shape (N, P)
        Their derivatives.
    weights : ndarray, shape (P,)
        Where they were taken.
    free : ndarray of int, shape (F,)
        Weights that may move.
    mu, decay : float
        Damping and weight decay.
    diagonal : bool
        Damp by the diagonal of JTJ instead of the identity.

    Returns
    -------
    step : ndarray, shape (P,)
        Least-squares solution of ``[J; sqrt(mu) D; sqrt(decay) I] s = -[r; 0; sqrt(decay) w]``.
    predicted : float
        Decrease of the quadratic model.
    """
    j = jacobian[:, free]
    scale = np.linalg.norm(j, axis=0) if diagonal else np.ones(len(free))
    blocks = [j, np.diag(np.sqrt(mu) * scale), np.sqrt(decay) * np.eye(len(free))]
    matrix = np.concatenate(blocks)
    wanted = -np.concatenate([residuals, np.zeros(len(free)), np.sqrt(decay) * weights[free]])
    q, r = np.linalg.qr(matrix)
    step = np.zeros_like(weights)
    try:
        step[free] = np.linalg.solve(r, q.T @ wanted)
    except np.linalg.LinAlgError:
        step[free] = np.nan
    s = step[free]
    # as in `damped_steps`: step' (damping step - gradient) / 2
    return step, float(0.5 * (mu * (scale * s) @ (scale * s) + (matrix.T @ wanted) @ s))
