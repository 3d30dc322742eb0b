"""Fit of a network one step ahead, to lagged windows."""

import numpy as np
import torch
from torch import Tensor

from narx.kernels import loops
from narx.kernels.threads import in_threads
from narx.network.kernel_arrays import EXACT, feature_shape
from narx.network.structure import NarxStructure, Tanh
from narx.training.least_squares.by_torch import products_by_torch
from narx.types import FloatArray
from narx.windows.lagged import LaggedWindows

# windows summed by one thread; fixed, so that results do not depend on the number of threads
_PART = 16384


class OneStepFit:
    """Least squares between one-step predictions and the targets of lagged windows.

    Parameters
    ----------
    windows : LaggedWindows
        Windows in normalised units, with the structure's lags.
    structure : NarxStructure
        Sizes of the network.
    tanh : {"rational", "exact"}
        As in `narx.network.closed_loop.closed_loop`.

    Raises
    ------
    ValueError
        If the windows do not have the structure's lags.
    """

    def __init__(
        self, windows: LaggedWindows, structure: NarxStructure, tanh: Tanh = "rational"
    ) -> None:
        n, n_features = windows.features.shape
        if n_features != structure.n_features:
            raise ValueError(
                f"windows of {n_features} values, a network of {structure.n_features} features"
            )
        self.windows, self.structure = windows, structure
        self.n_weights = structure.n_weights
        self.n_residuals = int(np.count_nonzero(windows.weights.numpy()))
        self.total_weight = float(windows.weights.sum())
        # padded to whole vectors with windows of zero weight
        padded = np.zeros((n_features + 2, -(-n // 8) * 8))
        padded[:-2, :n] = windows.features.numpy().T
        padded[-2, :n] = windows.targets.numpy()
        padded[-1, :n] = np.sqrt(windows.weights.numpy())
        self._features, self._targets, self._roots = padded[:-2], padded[-2], padded[-1]
        self._shape = feature_shape(structure)
        self._exact = EXACT[tanh]

    def products(self, weights: FloatArray) -> FloatArray:
        """Multiply residuals and their derivatives.

        Parameters
        ----------
        weights : ndarray, shape (R, P)
            Weights of each start.

        Returns
        -------
        ndarray, shape (R, P + 1, P + 1)
            Lower triangle of ``[J r].T @ [J r]`` of each start.
        """
        if not loops.AVAILABLE:
            return products_by_torch(self.residuals, weights)
        size = self.n_weights + 1
        n_rows = self.n_weights // 4 * 4 + 4
        n_parts = max(-(-len(self._targets) // _PART), 1)
        sums = np.zeros((len(weights) * n_parts, n_rows, n_rows, 8))
        weights = np.ascontiguousarray(weights)

        def work(first: int, last: int) -> None:
            loops.one_step.one_step_products(
                weights, self._features, self._targets, self._roots, _PART, first, last, sums,
                self._shape, self._exact,
            )  # fmt: skip

        in_threads(work, len(sums), 1)
        return sums.reshape(len(weights), n_parts, n_rows, n_rows, 8).sum(axis=(1, 4))[
            :, :size, :size
        ]

    def residuals(self, weights: Tensor) -> Tensor:
        """Compute weighted residuals by torch operations, differentiable.

        Parameters
        ----------
        weights : Tensor, shape (P,)
            Flat weights; on their device.

        Returns
        -------
        Tensor, shape (M,)
            Residuals in normalised units.
        """
        structure, windows = self.structure, self.windows
        features, targets, squares = (
            tensor.to(weights.device)
            for tensor in (windows.features, windows.targets, windows.weights)
        )
        w1 = weights[structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
        hidden = torch.tanh(features @ w1.mT + weights[structure.b1])
        outputs = hidden @ weights[structure.w2] + weights[structure.b2]
        return torch.sqrt(squares) * (outputs - targets)
