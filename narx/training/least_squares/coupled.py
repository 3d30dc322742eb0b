"""Fit of one network to three coupled axes."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from narx.kernels import loops
from narx.network.coupled_batch import CoupledBatch, Wanted
from narx.network.coupled_loop import broadcast_axes, coupled_closed_loop_by_torch
from narx.network.kernel_arrays import flat
from narx.network.structure import NarxStructure, Tanh
from narx.training.least_squares.by_torch import products_by_torch
from narx.types import BoolArray, FloatArray


class CoupledFit:
    """Least squares between the angles of three coupled axes and targets, in rad.

    Parameters
    ----------
    rates : Tensor, shape (..., N, 3)
        Gyroscope about the axes, rad/s, finite (shorter sequences are padded, with NaN targets).
    targets : Tensor, shape (..., N, 3)
        Target angles, rad; NaN samples are left out.
    state : Tensor, shape (..., 3, n_state), optional
        Normalised state before the first sample; zero if not given.
    posture : Tensor, shape (..., 3), optional
        Angles at a network output of zero, rad; zero if not given.
    rate_scale : Tensor, shape (3,)
        Rate that corresponds to 1 in the network, rad/s.
    angle_scale : Tensor, shape (3,)
        Angle that corresponds to an output of 1, rad.
    structure : NarxStructure
        Sizes of the network; one input.
    axis_weights : sequence of three floats
        Factors on the squared residuals of each axis; an axis of zero that no other depends on
        costs no time.
    sequence_weights : Tensor, shape (...), optional
        Factor on the squared residuals of each sequence; 1 if not given.
    washout : int
        Initial samples of each sequence that are left out.
    offset_free : bool
        Subtract each sequence's mean residual, axis by axis, before squaring.
    tanh : {"rational", "exact"}
        As in `narx.network.coupled_loop.coupled_closed_loop`.
    """

    def __init__(
        self,
        rates: Tensor,
        targets: Tensor,
        state: Tensor | None = None,
        posture: Tensor | None = None,
        *,
        rate_scale: Tensor,
        angle_scale: Tensor,
        structure: NarxStructure,
        axis_weights: Sequence[float] = (1.0, 1.0, 1.0),
        sequence_weights: Tensor | None = None,
        washout: int = 0,
        offset_free: bool = False,
        tanh: Tanh = "rational",
    ) -> None:
        rates, state, posture = broadcast_axes(rates, state, posture, structure)
        self._batch = CoupledBatch(rates, state, posture, rate_scale, angle_scale, structure, tanh)
        self.n_weights = structure.n_weights
        self._lead = rates.shape[:-2]
        batch = self._batch
        wanted = flat(targets.expand(rates.shape), 2) - batch.posture[:, None]
        wanted = wanted / batch.angle_scale
        weights = np.asarray(axis_weights, dtype=np.float64)
        self._axis_factors = weights * batch.angle_scale**2
        there: BoolArray = ~np.isnan(wanted) & (weights > 0)
        self._there = there
        there[:, :washout] = False
        n_samples = there.shape[1]
        any_axis = np.any(there, axis=2)
        last = n_samples - np.argmax(any_axis[:, ::-1], axis=1) if n_samples else 0
        lengths = np.where(np.any(any_axis, axis=1), last, 0).astype(np.int64)
        roots = None
        if sequence_weights is not None:
            roots = np.sqrt(flat(sequence_weights.expand(self._lead), 0)).reshape(-1)
        n_axes = 2 if weights[2] == 0 else 3
        self._wanted = Wanted(wanted, roots, lengths, washout, n_axes, offset_free)
        self.n_residuals = int(np.count_nonzero(there))
        counts = there.sum(axis=1) @ weights
        self.total_weight = float(counts.sum() if roots is None else roots**2 @ counts)

    def products(self, weights: FloatArray) -> FloatArray:
        """Multiply residuals and their derivatives.

        Parameters
        ----------
        weights : ndarray, shape (R, P)
            Weights of each start.

        Returns
        -------
        ndarray, shape (R, P + 1, P + 1)
            Lower triangle of ``[J r].T @ [J r]`` of each start, rad^2.
        """
        if not loops.AVAILABLE:
            return products_by_torch(self.residuals, weights)
        # an unused axis may have only NaN targets, or none at all
        counts, size = self._axis_factors > 0, self.n_weights + 1
        products = self._batch.products(weights, self._wanted)[:, counts, :size, :size]
        return np.einsum("a,raij->rij", self._axis_factors[counts], products)

    def residuals(self, weights: Tensor) -> Tensor:
        """Compute weighted residuals by torch operations, differentiable.

        Parameters
        ----------
        weights : Tensor, shape (P,)
            Flat weights; on their device.

        Returns
        -------
        Tensor, shape (B, N, 3)
            In rad, zero where they are left out.
        """
        batch, wanted, device = self._batch, self._wanted, weights.device

        def there_too(array: FloatArray | BoolArray) -> Tensor:
            return torch.from_numpy(array).to(device)

        angles, _ = coupled_closed_loop_by_torch(
            weights,
            *map(there_too, (batch.rates, batch.state, batch.posture)),
            rate_scale=1.0 / there_too(batch.scales[:3]),
            angle_scale=there_too(batch.angle_scale),
            structure=batch.structure,
        )
        targets = wanted.targets * batch.angle_scale + batch.posture[:, None]
        there = there_too(self._there)
        errors = torch.where(there, angles - there_too(targets), 0.0)
        if wanted.offset_free:
            mean = errors.sum(dim=1, keepdim=True) / there.sum(dim=1, keepdim=True).clamp(min=1)
            errors = torch.where(there, errors - mean, 0.0)
        errors = errors * there_too(np.sqrt(self._axis_factors) / batch.angle_scale)
        if wanted.roots is not None:
            errors = errors * there_too(wanted.roots)[:, None, None]
        return errors
