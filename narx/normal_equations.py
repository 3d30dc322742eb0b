"""Least-squares fits of a NARX network, reduced to their normal equations.

Forward sensitivities are carried along with the recurrence and folded into the Gauss-Newton
matrix while they are in the cache; the N x P Jacobian is never stored.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from narx._arrays import EXACT, broadcast, flat, kernel_shape, lanes_for
from narx.closed_loop import Tanh
from narx.kernels.normal import normal_equations
from narx.structure import NarxStructure

FloatArray = NDArray[np.float64]


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


def closed_loop_normal_equations(
    weights: Tensor,
    inputs: Tensor,
    targets: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    sequence_weights: Tensor | None = None,
    washout: int = 0,
    horizon: int | None = None,
    tanh: Tanh = "rational",
) -> NormalEquations:
    """Reduce the closed-loop fit of one network to several sequences to its normal equations.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs, finite (shorter sequences are padded, with NaN targets).
    targets : Tensor, shape (..., N)
        Normalised outputs wanted; NaN samples do not count (the recurrence runs on).
    state : Tensor, shape (..., n_state), optional
        State before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.
    sequence_weights : Tensor, shape (...), optional
        Factor on the squared residuals of each sequence; 1 if not given.
    washout : int
        Initial samples of each sequence that do not count.
    horizon : int, optional
        Start again from measured outputs every so many samples (where the targets they need
        are there); the whole sequence if not given.
    tanh : {"rational", "exact"}
        As in `narx.closed_loop.closed_loop`.

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    return _reduce(
        weights, inputs, targets, state, structure, sequence_weights, washout, horizon or 0, tanh
    )


def open_loop_normal_equations(
    weights: Tensor,
    inputs: Tensor,
    measured: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    sequence_weights: Tensor | None = None,
    washout: int = 0,
    tanh: Tanh = "rational",
) -> NormalEquations:
    """Reduce the one-step fit of one network to several sequences to its normal equations.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs, finite.
    measured : Tensor, shape (..., N)
        Normalised measured outputs; a NaN, and the samples that look back at it, do not count.
    state : Tensor, shape (..., n_state), optional
        Inputs and outputs before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.
    sequence_weights : Tensor, shape (...), optional
        Factor on the squared residuals of each sequence; 1 if not given.
    washout : int
        Initial samples of each sequence that do not count.
    tanh : {"rational", "exact"}
        As in `narx.closed_loop.closed_loop`.

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    return _reduce(
        weights, inputs, measured, state, structure, sequence_weights, washout, None, tanh
    )


def _reduce(
    weights: Tensor,
    inputs: Tensor,
    targets: Tensor,
    state: Tensor | None,
    structure: NarxStructure,
    sequence_weights: Tensor | None,
    washout: int,
    horizon: int | None,
    tanh: Tanh,
) -> NormalEquations:
    weights, inputs, state = broadcast(weights, inputs, state, structure)
    x, y, s = flat(inputs, 2), flat(targets.expand(inputs.shape[:-1]), 1), flat(state, 1)
    roots = np.ones(len(x))
    if sequence_weights is not None:
        roots = np.sqrt(flat(sequence_weights.expand(inputs.shape[:-2]), 0).reshape(-1))
    lanes = lanes_for(len(x))
    width, n_weights = len(lanes), structure.n_weights
    groups = np.full((-(-len(x) // width), width), -1)
    groups.reshape(-1)[: len(x)] = np.arange(len(x))
    n_rows = n_weights // 4 * 4 + 4
    sums = np.zeros((n_rows, n_rows, 8))
    final = np.empty_like(s)
    if len(x):
        w = flat(weights[(0,) * (weights.ndim - 1)], 1).reshape(-1)
        packed = np.repeat(w[:, None], width, axis=1)
        lengths = np.full(len(x), x.shape[1])
        normal_equations(
            packed, x, y, s, roots, lengths, groups, washout, horizon or 0, final, sums,
            kernel_shape(structure), lanes, EXACT[tanh], None if horizon is None else True,
        )  # fmt: skip
    products = sums.sum(axis=-1)
    products = np.tril(products) + np.tril(products, -1).T
    return NormalEquations(
        0.5 * float(products[n_weights, n_weights]),
        products[n_weights, :n_weights].copy(),
        products[:n_weights, :n_weights].copy(),
        int(np.count_nonzero(~np.isnan(y[:, washout:]))),
        None if horizon is None else final.reshape(state.shape),
    )
