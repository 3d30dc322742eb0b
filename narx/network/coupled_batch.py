"""Sequences of three coupled axes as arrays for the kernels."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from narx.kernels import loops
from narx.kernels.sizes import VECTOR
from narx.kernels.threads import in_threads
from narx.network.kernel_arrays import (
    EXACT,
    flat,
    in_groups,
    in_lanes,
    kernel_shape,
    lanes_for,
    one_after_another,
)
from narx.network.structure import NarxStructure, Tanh
from narx.types import FloatArray

# sensitivities of one sample of eight sequences side by side take as long as those of this number
# of samples of a sequence alone (measured with AVX-512)
_SAMPLES_ALONE = 3.4


@dataclass(frozen=True)
class Wanted:
    """Targets of the outputs, as arrays.

    Parameters
    ----------
    targets : ndarray, shape (B, N, 3)
        Normalised outputs, NaN where they are missing; with `given` the residuals themselves.
    roots : ndarray, shape (B,), optional
        Square root of each sequence's weight; 1 if not given.
    lengths : ndarray of int, shape (B,), optional
        Samples of each sequence that are run; all if not given.
    washout : int
        Initial samples of each sequence that are left out of the residuals.
    n_axes : int
        2 leaves out the transverse axis, on which the others do not depend.
    offset_free : bool
        Subtract each sequence's mean residual, axis by axis.
    given : bool
        `targets` are residuals already.
    """

    targets: FloatArray
    roots: FloatArray | None = None
    lengths: NDArray[np.int64] | None = None
    washout: int = 0
    n_axes: int = 3
    offset_free: bool = False
    given: bool = False


class CoupledBatch:
    """Sequences of three axes as flat arrays (B sequences), and the kernels that process them.

    Parameters
    ----------
    rates : Tensor, shape (..., N, 3)
        Gyroscope about the sagittal, frontal and transverse axis, rad/s.
    state : Tensor, shape (..., 3, n_state)
        Normalised state before the first sample.
    posture : Tensor, shape (..., 3)
        Angles at a network output of zero, rad.
    rate_scale : Tensor, shape (3,)
        Rate that corresponds to 1 in the network, rad/s.
    angle_scale : Tensor, shape (3,)
        Angle that corresponds to an output of 1, rad.
    structure : NarxStructure
        Sizes of the network; one input.
    tanh : {"rational", "exact"}
        As in `narx.network.coupled_loop.coupled_closed_loop`.
    """

    def __init__(
        self,
        rates: Tensor,
        state: Tensor,
        posture: Tensor,
        rate_scale: Tensor,
        angle_scale: Tensor,
        structure: NarxStructure,
        tanh: Tanh,
    ) -> None:
        self.rates, self.state, self.posture = flat(rates, 2), flat(state, 2), flat(posture, 1)
        self.angle_scale = flat(angle_scale.expand(3), 1).reshape(3)
        rate_factor = 1.0 / flat(rate_scale.expand(3), 1).reshape(3)
        self.scales = np.concatenate([rate_factor, self.angle_scale])
        self.structure = structure
        self.shape, self.exact = kernel_shape(structure), EXACT[tanh]

    def run(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Run the sequences.

        Parameters
        ----------
        weights : ndarray, shape (B or 1, P)
            Weights of each sequence, or of all.

        Returns
        -------
        angles : ndarray, shape (B, N, 3)
            Angles, rad.
        final : ndarray, shape (B, 3, n_state)
            State after the last sample.
        """
        angles, final = np.empty_like(self.rates), np.empty_like(self.state)
        lanes = lanes_for(len(angles))

        def part(first: int, last: int) -> None:
            loops.coupled_loop.run(
                weights, self.rates, self.state, self.posture, self.scales, first, last,
                angles, final, self.shape, lanes, self.exact,
            )  # fmt: skip

        in_threads(part, len(angles), len(lanes))
        return angles, final

    def products(self, weights: FloatArray, wanted: Wanted) -> FloatArray:
        """Multiply residuals and their derivatives, for each start.

        Parameters
        ----------
        weights : ndarray, shape (R, P)
            Weights of each start.
        wanted : Wanted
            Targets of the outputs.

        Returns
        -------
        ndarray, shape (R, 3, K, K)
            Axis by axis, lower triangle, in normalised outputs; row ``P`` belongs to the residuals,
            and K is rounded up to a multiple of four.
        """
        n_sequences, n_restarts = len(self.rates), len(weights)
        n_rows = weights.shape[1] // 4 * 4 + 4
        lengths = wanted.lengths
        if lengths is None:
            lengths = np.full(n_sequences, self.rates.shape[1])
        if n_restarts == 1 and _unequal(lengths):
            lanes, groups, idle = one_after_another(n_sequences)
        else:
            lanes, groups, idle = in_groups(n_sequences, n_restarts)
        # separate sums for each group, so that results do not depend on the number of threads
        sums = np.zeros((len(groups), 3, n_rows, n_rows, 8))

        def part(first: int, last: int) -> None:
            for i in range(first, last):
                self._sensitivities(weights, wanted, lengths, groups[i], sums[i], lanes)

        in_threads(part, len(groups), 1)
        sums[-1, ..., idle] = 0.0
        if n_restarts == 1:
            return sums.sum(axis=(0, -1))[None]
        by_restart = np.moveaxis(sums, -1, 1).reshape(-1, 3, n_rows, n_rows)
        return by_restart[:n_restarts]

    def _sensitivities(
        self,
        weights: FloatArray,
        wanted: Wanted,
        lengths: NDArray[np.int64],
        groups: NDArray[np.int64],
        sums: FloatArray,
        lanes: tuple[int, ...],
    ) -> None:
        roots = np.ones(len(self.rates)) if wanted.roots is None else wanted.roots
        loops.coupled_normal.coupled_sensitivities(
            weights, self.rates, wanted.targets, self.state, self.posture, self.scales, roots,
            lengths, groups, wanted.washout, wanted.n_axes, wanted.offset_free, wanted.given,
            sums, self.shape, lanes, self.exact,
        )  # fmt: skip


def _unequal(lengths: NDArray[np.int64]) -> bool:
    """Whether most lanes would wait for the longest sequence of their group."""
    side_by_side = lengths[in_lanes(len(lengths), len(VECTOR))[0]].max(axis=1).sum()
    return bool(lengths.sum() < _SAMPLES_ALONE * side_by_side)
