"""How far a Levenberg-Marquardt step may go, and how it is computed."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from narx.kernels.lanes import JIT, njit
from narx.least_squares.problem import FloatArray


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

    def update(
        self, mu: FloatArray, growth: FloatArray, kept: NDArray[np.bool_], gain: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Change mu after a step.

        Parameters
        ----------
        mu : ndarray, shape (R,)
            Damping of the step, relative.
        growth : ndarray, shape (R,)
            Factor of the next increase (policy ``gain_ratio``).
        kept : ndarray of bool, shape (R,)
            Whether the step was kept.
        gain : ndarray, shape (R,)
            Actual over predicted decrease.

        Returns
        -------
        mu, growth : ndarray, shape (R,)
            For the next step.
        """
        if self.policy == "factor":
            mu = mu * np.where(kept, self.decrease, self.increase)
        else:
            shrink = np.maximum(1.0 / 3.0, 1.0 - (2.0 * np.where(kept, gain, 1.0) - 1.0) ** 3)
            mu, growth = (
                mu * np.where(kept, shrink, growth),
                np.where(kept, 2.0, 2.0 * growth),
            )
        return np.maximum(mu, self.smallest), growth


@njit(**JIT)
def damped_steps(
    products: Any,
    weights: Any,
    free: Any,
    mu: Any,
    decay: Any,
    diagonal: bool,
    steps: Any,
    predicted: Any,
    gradient: Any,
    condition: Any,
) -> None:
    """Solve (JTJ + decay I + damping) step = -gradient by Cholesky, start by start.

    products (R, P + 1, P + 1), weights (R, P), free (F,) indices that may move, mu and decay
    (R,). steps (R, P) are zero where not free and NaN where the matrix is not positive;
    predicted (R,) decrease of the quadratic model, gradient (R,) its largest entry, condition
    (R,) of the matrix as the factor's diagonal shows it.
    """
    n, n_weights = len(free), weights.shape[1]
    factor = np.empty((n, n))
    g = np.empty(n)
    s = np.empty(n)
    for r in range(len(products)):
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
        condition[r] = (high / low) ** 2
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
        steps[r] = 0.0
        for i in range(n):
            a = free[i]
            steps[r, a] = s[i]
            scale = mu[r]
            if diagonal:
                scale *= products[r, a, a]
            # L(0) - L(step) = step' (damping step - gradient) / 2
            decrease += 0.5 * s[i] * (scale * s[i] - g[i])
        predicted[r] = decrease


def step_by_qr(
    residuals: FloatArray,
    jacobian: FloatArray,
    weights: FloatArray,
    free: NDArray[np.int64],
    mu: float,
    decay: float,
    diagonal: bool,
) -> FloatArray:
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
    ndarray, shape (P,)
        Least-squares solution of ``[J; sqrt(mu) D; sqrt(decay) I] s = -[r; 0; sqrt(decay) w]``.
    """
    j = jacobian[:, free]
    scale = np.linalg.norm(j, axis=0) if diagonal else np.ones(len(free))
    blocks = [j, np.diag(np.sqrt(mu) * scale), np.sqrt(decay) * np.eye(len(free))]
    right = [residuals, np.zeros(len(free)), np.sqrt(decay) * weights[free]]
    q, r = np.linalg.qr(np.concatenate(blocks))
    step = np.zeros_like(weights)
    try:
        step[free] = np.linalg.solve(r, -(q.T @ np.concatenate(right)))
    except np.linalg.LinAlgError:
        step[free] = np.nan
    return step
