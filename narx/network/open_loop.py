"""The NARX network fed with measured outputs: a one-step predictor (series-parallel).

Samples do not depend on one another, so plain torch operations do;
`narx.training.least_squares.normal_equations` has the compiled path for training.
"""

import torch
from torch import Tensor

from narx.network.kernel_arrays import broadcast
from narx.network.structure import NarxStructure


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
    weights, inputs, state = broadcast(weights, inputs, state, structure)
    x = lagged_features(inputs, measured, state, structure)
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
    weights, inputs, state = broadcast(weights, inputs, state, structure)
    x = lagged_features(inputs, measured, state, structure)
    w1 = weights[..., structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
    w2 = weights[..., None, structure.w2]
    hidden = torch.tanh(x @ w1.mT + weights[..., None, structure.b1])
    outputs = (hidden * w2).sum(-1) + weights[..., structure.b2, None]
    slope = w2 * (1.0 - hidden * hidden)
    rows = (slope.unsqueeze(-1) * x.unsqueeze(-2)).flatten(-2)
    return outputs, torch.cat([rows, slope, hidden, torch.ones_like(outputs)[..., None]], dim=-1)


def lagged_features(
    inputs: Tensor, measured: Tensor, state: Tensor, structure: NarxStructure
) -> Tensor:
    """Collect the features of every sample from inputs and measured outputs.

    Parameters
    ----------
    inputs : Tensor, shape (..., N, n_inputs)
        Normalised inputs.
    measured : Tensor, shape (..., N)
        Normalised measured outputs.
    state : Tensor, shape (..., n_state)
        Inputs and outputs before the first sample.
    structure : NarxStructure
        Sizes of the network.

    Returns
    -------
    Tensor, shape (..., N, n_features)
        ``v_k, v_{k-1}, ..., p_{k-1}, p_{k-2}, ...``.
    """
    n, n_past = inputs.shape[-2], structure.n_input_state
    past_inputs = state[..., :n_past].unflatten(-1, (-1, structure.n_inputs)).flip(-2)
    v = torch.cat([past_inputs, inputs], dim=-2)
    p = torch.cat([state[..., n_past:].flip(-1), measured.expand(inputs.shape[:-1])], dim=-1)
    lags = [v[..., lag : lag + n, :] for lag in range(structure.input_lags - 1, -1, -1)]
    lags += [p[..., lag : lag + n, None] for lag in range(structure.output_lags - 1, -1, -1)]
    return torch.cat(lags, dim=-1)
