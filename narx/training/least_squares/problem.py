"""Interface of least-squares problems, and a prior for any of them."""

from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from narx.types import FloatArray


class LeastSquaresProblem(Protocol):
    """Half a sum of squares as a function of weights, evaluated for several starts at once."""

    @property
    def n_weights(self) -> int:
        """Number of weights, P."""

    @property
    def n_residuals(self) -> int:
        """Number of residuals used."""

    @property
    def total_weight(self) -> float:
        """Sum of the weights of the squared residuals that are used."""

    def residuals(self, weights: Tensor) -> Tensor:
        """Compute weighted residuals by torch operations, differentiable.

        Parameters
        ----------
        weights : Tensor, shape (P,)
            Flat weights; on their device.

        Returns
        -------
        Tensor
            Residuals of any shape; zero where they are not used.
        """

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
            twice the cost in the corner. The upper triangle need not be filled. Not finite if a
            start has diverged.
        """


class TowardsPrior:
    """Keep weights near those of a known network: a ridge penalty about them instead of zero.

    A least-squares problem with ``sum(strength (weights - centre)^2)`` added to its squares.

    Parameters
    ----------
    problem : LeastSquaresProblem
        Problem to fit.
    centre : ndarray, shape (P,)
        Weights without a penalty.
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

    @property
    def total_weight(self) -> float:
        """Sum of the weights of the problem's own squared residuals."""
        return self._problem.total_weight

    def residuals(self, weights: Tensor) -> Tensor:
        """Compute residuals by torch operations, those of the prior last.

        Parameters
        ----------
        weights : Tensor, shape (P,)
            Flat weights; on their device.

        Returns
        -------
        Tensor, shape (N + P,)
            Weighted.
        """
        centre, root = (
            torch.from_numpy(a).to(weights.device) for a in (self._centre, np.sqrt(self._strength))
        )
        own = self._problem.residuals(weights).reshape(-1)
        return torch.cat([own, root * (weights - centre)])

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
