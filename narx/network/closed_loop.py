"""The NARX network in closed loop, as a differentiable torch operator.

Closed loop (parallel): the network's inputs include its own past outputs.
All floating types are computed in float64: a trained loop is nearly an
integrator and amplifies rounding errors about 1e5-fold.
"""

from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from narx.kernels import loops
from narx.kernels.threads import in_threads
from narx.network.kernel_arrays import (
    EXACT,
    back,
    broadcast,
    compiled_for,
    flat,
    flat_weights,
    gradients_by_torch,
    kernel_shape,
    lanes_for,
)
from narx.network.structure import NarxStructure, Tanh


def closed_loop(
    weights: Tensor,
    inputs: Tensor,
    state: Tensor | None = None,
    *,
    structure: NarxStructure,
    tanh: Tanh = "rational",
) -> tuple[Tensor, Tensor]:
    """Run a network in closed loop.

    Compiled on the CPU, with the gradient. Gradients of the gradient (``create_graph=True``) and
    the transforms of `torch.func` run in plain torch operations, hundreds of times slower.

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
    weights, inputs, state = broadcast(weights, inputs, state, structure)
    if compiled_for(inputs):
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
    weights, inputs, state = broadcast(weights, inputs, state, structure)
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


class _ClosedLoop(torch.autograd.Function):
    """The recurrence on the CPU."""

    @staticmethod
    def forward(
        ctx: Any,
        weights: Tensor,
        inputs: Tensor,
        state: Tensor,
        structure: NarxStructure,
        tanh: Tanh,
    ) -> tuple[Tensor, Tensor]:
        w, x, s = flat_weights(weights), flat(inputs, 2), flat(state, 1)
        outputs, final = np.empty(x.shape[:2]), np.empty_like(s)
        shape, lanes, exact = kernel_shape(structure), lanes_for(len(x)), EXACT[tanh]

        def part(first: int, last: int) -> None:
            loops.axis_loop.run(w, x, s, first, last, outputs, final, shape, lanes, exact)

        in_threads(part, len(x), len(lanes))
        ctx.save_for_backward(weights, inputs, state)
        ctx.kept = (w, x, s, outputs, shape, lanes, exact)
        ctx.structure = structure
        return back(outputs, inputs.shape[:-1], inputs), back(final, state.shape, inputs)

    @staticmethod
    def backward(ctx: Any, d_outputs: Tensor, d_final: Tensor) -> tuple[Tensor | None, ...]:
        weights, inputs, state = ctx.saved_tensors
        if torch.is_grad_enabled():  # a graph of the gradients is asked for
            run = partial(closed_loop_by_torch, structure=ctx.structure)
            gradients = gradients_by_torch(run, ctx.saved_tensors, (d_outputs, d_final))
            return *gradients, None, None
        w, x, s, outputs, *sizes = ctx.kept
        dy, df = flat(d_outputs, 1), flat(d_final, 1)
        dw, dx, ds = np.empty((len(x), w.shape[1])), np.empty_like(x), np.empty_like(s)

        def part(first: int, last: int) -> None:
            loops.axis_loop.adjoint(w, x, s, outputs, dy, df, first, last, dw, dx, ds, *sizes)

        in_threads(part, len(x), len(sizes[1]))
        return (
            back(dw, weights.shape, weights),
            back(dx, inputs.shape, inputs),
            back(ds, state.shape, state),
            None,
            None,
        )
