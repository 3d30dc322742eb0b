"""How far a Levenberg-Marquardt step may go, and how it is computed."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

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
