"""The NARX recurrence as a differentiable torch operator, with exact Jacobians.

Closed loop (parallel): the network is fed its own outputs. Open loop (series-parallel): it is
fed measured ones, which makes it a one-step predictor. Multi-step: closed loop, started again
from measured outputs every `horizon` samples.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from narx.kernels import plain
from narx.structure import NarxStructure

FloatArray = NDArray[np.float64]
Tanh = Literal["rational", "exact"]


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
    final_state : ndarray, shape (..., n_state)
        State after the last sample of each sequence.
    """

    cost: float
    gradient: FloatArray
    jtj: FloatArray
    n_residuals: int
    final_state: FloatArray


def closed_loop(
    weights: Tensor,
    inputs: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    tanh: Tanh = "rational",
) -> tuple[Tensor, Tensor]:
    """Run a network in closed loop.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights (`NarxStructure`); leading dimensions broadcast against those of `inputs`.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    state : Tensor, shape (..., n_state), optional
        State before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.
    tanh : {"rational", "exact"}
        ``rational`` is within a few units in the last place, and vectorises.

    Returns
    -------
    outputs : Tensor, shape (..., N)
        Network outputs.
    final_state : Tensor, shape (..., n_state)
        State after the last sample: a long recording run in pieces gives the same outputs.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    if inputs.device.type == "cpu":
        outputs, final = _ClosedLoop.apply(weights, inputs, state, structure, tanh)
        return outputs, final
    return closed_loop_by_torch(weights, inputs, state, structure=structure)


def closed_loop_by_torch(
    weights: Tensor, inputs: Tensor, state: Tensor | None = None, *, structure: NarxStructure
) -> tuple[Tensor, Tensor]:
    """Run a network in closed loop by plain torch operations, one sample after another.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    state : Tensor, shape (..., n_state), optional
        State before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    outputs : Tensor, shape (..., N)
        Network outputs.
    final_state : Tensor, shape (..., n_state)
        State after the last sample.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    w1 = weights[..., structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
    b1, w2 = weights[..., structure.b1], weights[..., structure.w2]
    b2 = weights[..., structure.b2]
    n_past, outputs = structure.n_input_state, []
    for present in inputs.unbind(-2):
        x = torch.cat([present, state], dim=-1)
        p = b2 + (w2 * torch.tanh((w1 * x.unsqueeze(-2)).sum(-1) + b1)).sum(-1)
        outputs.append(p)
        state = torch.cat([x[..., :n_past], p.unsqueeze(-1), state[..., n_past:-1]], dim=-1)
    if not outputs:
        return inputs.new_zeros(inputs.shape[:-1]), state
    return torch.stack(outputs, dim=-1), state


def closed_loop_jacobian(
    weights: Tensor,
    inputs: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
) -> tuple[Tensor, Tensor]:
    """Run a network in closed loop with the sensitivity of every output to every weight.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights; leading dimensions broadcast against those of `inputs`.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    state : Tensor, shape (..., n_state), optional
        State before the first sample; zero if not given. It does not depend on the weights.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    outputs : Tensor, shape (..., N)
        Network outputs.
    jacobian : Tensor, shape (..., N, P)
        Derivative of the outputs with respect to the weights, by forward sensitivities.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    w, x, s = _flat(weights, inputs, state)
    outputs, activations, _ = _rollout(w, x, s, structure)
    jac = np.empty((*x.shape[:2], structure.n_weights))
    plain.jacobian(w, x, s, structure.sizes, outputs, activations, True, jac)
    return _back(outputs, inputs, ()), _back(jac, inputs, (structure.n_weights,))


def closed_loop_normal_equations(
    weights: Tensor,
    inputs: Tensor,
    targets: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    sequence_weights: Tensor | None = None,
    washout: int = 0,
) -> NormalEquations:
    """Reduce the closed-loop fit of one network to several sequences to its normal equations.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
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

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    w, x, s = _flat(weights, inputs, state)
    outputs, activations, final = _rollout(w, x, s, structure)
    jac = np.empty((*x.shape[:2], structure.n_weights))
    plain.jacobian(w, x, s, structure.sizes, outputs, activations, True, jac)
    return _normal_equations(
        outputs, jac, targets, sequence_weights, washout, _back(final, inputs[..., 0, 0], None)
    )


def open_loop(
    weights: Tensor,
    inputs: Tensor,
    measured: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
) -> Tensor:
    """Predict each sample from the measured outputs before it (differentiable).

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights; leading dimensions broadcast against those of `inputs`.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    measured : Tensor, shape (..., N)
        Normalised measured outputs.
    state : Tensor, shape (..., n_state), optional
        Inputs and outputs before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    Tensor, shape (..., N)
        One-step predictions; NaN where a measured output they need is NaN.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    x = _lagged_features(inputs, measured, state, structure)
    w1 = weights[..., structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
    hidden = torch.tanh(x @ w1.mT + weights[..., None, structure.b1])
    return (hidden * weights[..., None, structure.w2]).sum(-1) + weights[..., structure.b2, None]


def open_loop_jacobian(
    weights: Tensor,
    inputs: Tensor,
    measured: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
) -> tuple[Tensor, Tensor]:
    """Predict each sample from measured outputs, with the derivative by every weight.

    Parameters
    ----------
    weights : Tensor, shape (..., P)
        Flat weights; leading dimensions broadcast against those of `inputs`.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    measured : Tensor, shape (..., N)
        Normalised measured outputs.
    state : Tensor, shape (..., n_state), optional
        Inputs and outputs before the first sample; zero if not given.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    outputs : Tensor, shape (..., N)
        One-step predictions.
    jacobian : Tensor, shape (..., N, P)
        Their derivative with respect to the weights.
    """
    weights, inputs, state = _broadcast(weights, inputs, state, structure)
    x = _lagged_features(inputs, measured, state, structure)
    w1 = weights[..., structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
    w2 = weights[..., None, structure.w2]
    hidden = torch.tanh(x @ w1.mT + weights[..., None, structure.b1])
    outputs = (hidden * w2).sum(-1) + weights[..., structure.b2, None]
    slope = w2 * (1.0 - hidden * hidden)
    rows = (slope.unsqueeze(-1) * x.unsqueeze(-2)).flatten(-2)
    return outputs, torch.cat([rows, slope, hidden, torch.ones_like(outputs)[..., None]], dim=-1)


def open_loop_normal_equations(
    weights: Tensor,
    inputs: Tensor,
    measured: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    sequence_weights: Tensor | None = None,
    washout: int = 0,
) -> NormalEquations:
    """Reduce the one-step fit of one network to several sequences to its normal equations.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights.
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
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

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    outputs, jac = open_loop_jacobian(weights, inputs, measured, state, structure=structure)
    _, inputs, state = _broadcast(weights, inputs, state, structure)
    bad = outputs.isnan()
    return _normal_equations(
        outputs.detach().numpy(),
        jac.detach().numpy(),
        measured.masked_fill(bad, torch.nan),
        sequence_weights,
        washout,
        state.numpy(),
    )


def _lagged_features(
    inputs: Tensor, measured: Tensor, state: Tensor, structure: NarxStructure
) -> Tensor:
    n, n_past = inputs.shape[-2], structure.n_input_state
    past_inputs = state[..., :n_past].unflatten(-1, (-1, structure.n_inputs)).flip(-2)
    v = torch.cat([past_inputs, inputs], dim=-2)
    p = torch.cat([state[..., n_past:].flip(-1), measured.expand(inputs.shape[:-1])], dim=-1)
    lags = [v[..., lag : lag + n, :] for lag in range(structure.input_lags - 1, -1, -1)]
    lags += [p[..., lag : lag + n, None] for lag in range(structure.output_lags - 1, -1, -1)]
    return torch.cat(lags, dim=-1)


def _normal_equations(
    outputs: FloatArray,
    jac: FloatArray,
    targets: Tensor,
    sequence_weights: Tensor | None,
    washout: int,
    final_state: Any,
) -> NormalEquations:
    residuals = outputs.reshape(targets.shape) - targets.detach().numpy()
    counts = ~np.isnan(targets.detach().numpy())
    counts[..., :washout] = False
    root = np.ones(targets.shape)
    if sequence_weights is not None:
        root *= np.sqrt(sequence_weights.detach().numpy())[..., None]
    jac = jac.reshape((*targets.shape, jac.shape[-1]))
    e, j = (residuals * root)[counts], (jac * root[..., None])[counts]
    return NormalEquations(0.5 * float(e @ e), j.T @ e, j.T @ j, int(counts.sum()), final_state)


def _broadcast(
    weights: Tensor, inputs: Tensor, state: Tensor | None, structure: NarxStructure
) -> tuple[Tensor, Tensor, Tensor]:
    if inputs.ndim < 2 or inputs.shape[-1] != structure.n_inputs:
        raise ValueError(f"inputs {tuple(inputs.shape)}, expected (..., N, {structure.n_inputs})")
    if weights.shape[-1:] != (structure.n_weights,):
        raise ValueError(f"weights {tuple(weights.shape)}, expected (..., {structure.n_weights})")
    if state is None:
        state = inputs.new_zeros(structure.n_state)
    if state.shape[-1:] != (structure.n_state,):
        raise ValueError(f"state {tuple(state.shape)}, expected (..., {structure.n_state})")
    lead = torch.broadcast_shapes(weights.shape[:-1], inputs.shape[:-2], state.shape[:-1])
    return (
        weights.expand(*lead, structure.n_weights),
        inputs.expand(*lead, *inputs.shape[-2:]),
        state.expand(*lead, structure.n_state),
    )


def _flat(weights: Tensor, inputs: Tensor, state: Tensor) -> tuple[Any, Any, Any]:
    def double(tensor: Tensor, keep: int) -> FloatArray:
        flat = tensor.detach().to(torch.float64).reshape(-1, *tensor.shape[-keep:])
        return np.ascontiguousarray(flat.numpy())

    n_sequences = int(np.prod(inputs.shape[:-2]))
    x = np.ascontiguousarray(inputs.detach().to(torch.float64).numpy())
    x = x.reshape(n_sequences, *inputs.shape[-2:])
    return double(weights, 1), x, double(state, 1)


def _rollout(
    w: FloatArray, x: FloatArray, s: FloatArray, structure: NarxStructure
) -> tuple[FloatArray, FloatArray, FloatArray]:
    outputs, final = np.empty(x.shape[:2]), np.empty_like(s)
    activations = np.empty((*x.shape[:2], structure.hidden))
    plain.rollout(w, x, s, structure.sizes, outputs, final, activations)
    return outputs, activations, final


def _back(array: FloatArray, like: Tensor, last: tuple[int, ...] | None) -> Tensor:
    if last is None:  # a state
        return torch.from_numpy(array).reshape(*like.shape, -1).to(like.dtype)
    return torch.from_numpy(array).reshape(*like.shape[:-1], *last).to(like.dtype)


class _ClosedLoop(torch.autograd.Function):
    """The recurrence on the CPU."""

    @staticmethod
    def forward(
        ctx: Any, weights: Tensor, inputs: Tensor, state: Tensor, structure: Any, tanh: str
    ) -> tuple[Tensor, Tensor]:
        w, x, s = _flat(weights, inputs, state)
        outputs, activations, final = _rollout(w, x, s, structure)
        ctx.save_for_backward(weights, inputs, state)
        ctx.structure, ctx.kept = structure, (outputs, activations)
        return _back(outputs, inputs, ()), _back(final, inputs[..., 0, 0], None)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, d_outputs: Tensor, d_final: Tensor) -> tuple[Tensor | None, ...]:
        weights, inputs, state = ctx.saved_tensors
        structure, (outputs, activations) = ctx.structure, ctx.kept
        w, x, s = _flat(weights, inputs, state)
        dy = np.ascontiguousarray(d_outputs.to(torch.float64).numpy()).reshape(outputs.shape)
        df = np.ascontiguousarray(d_final.to(torch.float64).numpy()).reshape(s.shape)
        dw, dx, ds = np.zeros_like(w), np.zeros_like(x), np.zeros_like(s)
        plain.adjoint(w, x, s, structure.sizes, outputs, activations, dy, df, dw, dx, ds)

        def back(array: FloatArray, like: Tensor) -> Tensor:
            return torch.from_numpy(array).reshape(like.shape).to(like.dtype)

        return back(dw, weights), back(dx, inputs), back(ds, state), None, None
