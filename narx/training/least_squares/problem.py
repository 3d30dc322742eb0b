"""What a least-squares solver asks of a problem."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from narx.types import FloatArray


@dataclass(frozen=True)
class NormalEquations:
    """Least-squares problem of one set of weights, reduced to what Gauss-Newton needs.

    Parameters
    ----------
    cost : float
        Half the sum of squared residuals (output - target) over the samples that count.
    gradient : ndarray, shape (P,)
        Gradient of `cost`: ``J.T @ residuals``.
    jtj : ndarray, shape (P, P)
        ``J.T @ J``.
    n_residuals : int
        Samples that count.
    final_state : ndarray, shape (..., n_state), or None
        State after the last sample of each sequence (closed loop only).
    """

    cost: float
    gradient: FloatArray
    jtj: FloatArray
    n_residuals: int
    final_state: FloatArray | None = None


class LeastSquaresProblem(Protocol):
    """Half a sum of squares as a function of weights, evaluated for several starts at once."""

    @property
    def n_weights(self) -> int:
        """Number of weights, P."""

    @property
    def n_residuals(self) -> int:
        """Number of residuals that count."""

    def products(self, weights: FloatArray) -> FloatArray:
        """Multiply residuals and their derivatives.

        Parameters
        ----------
        weights : ndarray, shape (R, P)
            Weights of each start.

        Returns
        -------
        ndarray, shape (R, P + 1, P + 1)
            ``[J r].T @ [J r]`` of each start: Gauss-Newton matrix, gradient in the last row,
            twice the cost in the corner. The upper triangle need not be filled. Not finite
            where a start has diverged.
        """

    def residuals(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Compute residuals and Jacobian of one start, for a solver that needs them.

        Parameters
        ----------
        weights : ndarray, shape (P,)
            Weights.

        Returns
        -------
        residuals : ndarray, shape (N,)
            Weighted residuals that count.
        jacobian : ndarray, shape (N, P)
            Their derivatives.
        """


def as_normal_equations(
    products: FloatArray, n_residuals: int, final_state: FloatArray | None = None
) -> NormalEquations:
    """Read products as normal equations.

    Parameters
    ----------
    products : ndarray, shape (P + 1, P + 1)
        Lower triangle of ``[J r].T @ [J r]``.
    n_residuals : int
        Samples that count.
    final_state : ndarray, optional
        State after the last sample.

    Returns
    -------
    NormalEquations
        With both triangles filled.
    """
    lower = np.tril(products[:-1, :-1])
    return NormalEquations(
        0.5 * float(products[-1, -1]),
        products[-1, :-1].copy(),
        lower + np.tril(lower, -1).T,
        n_residuals,
        final_state,
    )
