"""Damping of Levenberg-Marquardt steps."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from narx.types import FloatArray


@dataclass(frozen=True)
class Damping:
    """Damping of the Gauss-Newton matrix.

    It follows the ratio of the actual to the predicted decrease of the cost (Nielsen 1999).

    Parameters
    ----------
    scaling : {"identity", "diagonal"}
        ``JTJ + mu I`` (Levenberg) or ``JTJ + mu diag(JTJ)`` (Marquardt).
    initial : float
        First mu, relative to the largest diagonal entry for the identity.
    smallest, largest : float
        Bounds of mu, relative as `initial`; beyond the largest the solver stops.
    """

    scaling: Literal["identity", "diagonal"] = "identity"
    initial: float = 1e-3
    smallest: float = 1e-18
    largest: float = 1e10

    def scale(self, products: FloatArray) -> FloatArray:
        """Return the unit of mu for each start.

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
