"""What a least-squares solver asks of a problem, and a prior that any of them can have."""

from typing import Protocol

import numpy as np

from narx.types import FloatArray


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


class TowardsPrior:
    """Keep weights near those of a known network: a ridge about them instead of about zero.

    A least-squares problem with ``sum(strength (weights - centre)^2)`` added to its squares.

    Parameters
    ----------
    problem : LeastSquaresProblem
        What is to be fitted.
    centre : ndarray, shape (P,)
        Weights that cost nothing.
    strength : ndarray, shape (P,)
        Factor of each weight's squared distance, in the unit of the squared residuals.
    """

    def __init__(
        self, problem: LeastSquaresProblem, centre: FloatArray, strength: FloatArray
    ) -> None:
        self._problem, self._centre, self._strength = problem, centre, strength

    @property
    def n_weights(self) -> int:
        """Number of weights, P."""
        return self._problem.n_weights

    @property
    def n_residuals(self) -> int:
        """Number of residuals of the problem itself."""
        return self._problem.n_residuals

    def products(self, weights: FloatArray) -> FloatArray:
        """Multiply residuals and their derivatives, those of the prior included.

        Parameters
        ----------
        weights : ndarray, shape (R, P)
            Weights of each start.

        Returns
        -------
        ndarray, shape (R, P + 1, P + 1)
            Lower triangle of ``[J r].T @ [J r]`` of each start.
        """
        products = self._problem.products(weights).copy()
        distance = weights - self._centre
        diagonal = np.arange(self.n_weights)
        products[:, diagonal, diagonal] += self._strength
        products[:, -1, :-1] += self._strength * distance
        products[:, -1, -1] += (self._strength * distance**2).sum(axis=1)
        return products
