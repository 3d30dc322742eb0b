"""Products of residuals and their derivatives by torch's forward-mode differentiation.

Fallback of the least-squares problems if the compiled loops are not available
(`narx.kernels.loops`), and the reference for their tests.
"""

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from narx.types import FloatArray


def products_by_torch(residuals: Callable[[Tensor], Tensor], weights: FloatArray) -> FloatArray:
    """Multiply residuals and their derivatives, for each start.

    Parameters
    ----------
    residuals : callable
        Weights (P,) to residuals of any shape, in torch operations.
    weights : ndarray, shape (R, P)
        Weights of each start.

    Returns
    -------
    ndarray, shape (R, P + 1, P + 1)
        ``[J r].T @ [J r]`` of each start.
    """

    def twice(w: Tensor) -> tuple[Tensor, Tensor]:
        r = residuals(w).reshape(-1)
        return r, r

    products = np.empty((len(weights), weights.shape[1] + 1, weights.shape[1] + 1))
    for start, w in enumerate(weights):
        jacobian, r = torch.func.jacfwd(twice, has_aux=True)(torch.from_numpy(w))
        rows = torch.cat([jacobian, r[:, None]], dim=1)
        products[start] = (rows.mT @ rows).numpy()
    return products
