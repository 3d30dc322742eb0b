"""Fit of a network to sequences, several steps ahead or in closed loop."""

import numpy as np
import torch
from torch import Tensor

from narx.kernels import loops
from narx.kernels.threads import in_threads
from narx.network.closed_loop import closed_loop_by_torch
from narx.network.kernel_arrays import EXACT, broadcast, flat, in_groups, kernel_shape
from narx.network.structure import NarxStructure, Tanh
from narx.training.least_squares.by_torch import products_by_torch
from narx.types import FloatArray


class NetworkFit:
    """Least squares between a network's outputs and targets, in normalised units.

    Parameters
    ----------
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs, finite (shorter sequences are padded, with NaN targets).
    targets : Tensor, shape (..., N)
        Target outputs, normalised; NaN samples are left out.
    state : Tensor, shape (..., n_state), optional
        State before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.
    sequence_weights : Tensor, shape (...), optional
        Factor on the squared residuals of each sequence; 1 if not given.
    washout : int
        Initial samples of each sequence that are left out.
    horizon : int, optional
        Restart from measured outputs every `horizon` samples (2 or more) where these are available.
        By default the whole sequence is run in closed loop.
    tanh : {"rational", "exact"}
        As in `narx.network.closed_loop.closed_loop`.

    Raises
    ------
    ValueError
        If shapes do not fit or the horizon is below 2.
    """

    def __init__(
        self,
        inputs: Tensor,
        targets: Tensor,
        state: Tensor | None = None,
        *,
        structure: NarxStructure,
        sequence_weights: Tensor | None = None,
        washout: int = 0,
        horizon: int | None = None,
        tanh: Tanh = "rational",
    ) -> None:
        if horizon is not None and horizon < 2:
            raise ValueError(f"horizon is {horizon}, expected at least 2")
        some = inputs.new_zeros(structure.n_weights)
        _, inputs, state = broadcast(some, inputs, state, structure)
        self.structure, self.horizon, self.washout, self.tanh = structure, horizon, washout, tanh
        self._lead = inputs.shape[:-2]
        self._inputs, self._state = flat(inputs, 2), flat(state, 1)
        self._targets = flat(targets.expand(inputs.shape[:-1]), 1)
        self._roots = np.ones(len(self._inputs))
        if sequence_weights is not None:
            self._roots = np.sqrt(flat(sequence_weights.expand(self._lead), 0)).reshape(-1)
        there = ~np.isnan(self._targets)
        # samples after the last target are not used
        n_samples = there.shape[1]
        last = n_samples - np.argmax(there[:, ::-1], axis=1) if n_samples else 0
        self._lengths = np.where(there.any(axis=1), last, 0).astype(np.int64)
        self.n_weights = structure.n_weights
        self._counted = there
        self._counted[:, :washout] = False
        self.n_residuals = int(np.count_nonzero(self._counted))
        self.total_weight = float((self._roots**2) @ self._counted.sum(axis=1))

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
        return self._products(weights)

    def residuals(self, weights: Tensor) -> Tensor:
        """Compute weighted residuals by torch operations, differentiable.

        Parameters
        ----------
        weights : Tensor, shape (P,)
            Flat weights; on their device.

        Returns
        -------
        Tensor, shape (B, N)
            Zero where they are left out.
        """
        inputs, state, targets, roots, counted = (
            torch.from_numpy(a).to(weights.device)
            for a in (self._inputs, self._state, self._targets, self._roots, self._counted)
        )
        n_out, n_samples = self.structure.output_lags, targets.shape[1]
        past = state[:, self.structure.n_input_state :].flip(-1)
        measured = torch.cat([past, targets], dim=1)  # from k: the n_out before k
        horizon = self.horizon or max(n_samples, 1)
        outputs = []
        for start in range(0, n_samples, horizon):
            if start:
                lags = measured[:, start : start + n_out].flip(-1)
                known = ~lags.isnan().any(dim=1, keepdim=True)
                fed_back = torch.where(known, lags, state[:, self.structure.n_input_state :])
                state = torch.cat([state[:, : self.structure.n_input_state], fed_back], dim=1)
            part = inputs[:, start : start + horizon]
            output, state = closed_loop_by_torch(weights, part, state, structure=self.structure)
            outputs.append(output)
        if not outputs:
            return targets
        errors = roots[:, None] * (torch.cat(outputs, dim=1) - targets)
        return torch.where(counted, errors, 0.0)

    def _products(self, weights: FloatArray) -> FloatArray:
        n_sequences, n_starts = len(self._inputs), len(weights)
        n_rows = self.n_weights // 4 * 4 + 4
        lanes, groups, idle = in_groups(n_sequences, n_starts)
        packed = [np.ascontiguousarray(weights[group[0, :, 1]].T) for group in groups]
        sequences = np.ascontiguousarray(groups[..., 0])
        # separate sums for each group: the same numbers with any number of threads
        sums = np.zeros((len(groups), n_rows, n_rows, 8))
        shape, exact = kernel_shape(self.structure), EXACT[self.tanh]

        def part(first: int, last: int) -> None:
            for i in range(first, last):
                loops.axis_normal.normal_equations(
                    packed[i], self._inputs, self._targets, self._state, self._roots, self._lengths,
                    sequences[i], self.washout, self.horizon or 0, sums[i],
                    shape, lanes, exact,
                )  # fmt: skip

        in_threads(part, len(groups), 1)
        sums[-1, ..., idle] = 0.0
        products = np.zeros((n_starts, self.n_weights + 1, self.n_weights + 1))
        loops.gram.fold(sums, products)
        return products
