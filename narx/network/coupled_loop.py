"""Three axes in closed loop, coupled by the estimated tilt.

Before each step the gyroscope rates are converted to the rates of the segment's three angles (Euler
kinematics, `narx.kinematics.segment_angles.coupled_rates`) with the angles extrapolated to the time
of the sample: ``v_k = rates(u_k, angle_scale (2 p_{k-1} - p_{k-2}) + posture) / rate_scale``
(``p_{k-1}`` where the network has only one past output). Treating the axes independently would make
the turn of a tilted segment appear as flexion. The cosine of the frontal angle is kept at 0.1 or
more in magnitude, because the angles are singular at 90 degrees.
"""

from typing import Any

import numpy as np
import torch
from torch import Tensor

from narx.network.cell import coupled_rates
from narx.network.coupled_batch import CoupledBatch, Wanted
from narx.network.kernel_arrays import back, compiled_for, flat, gradients_by_torch
from narx.network.structure import NarxStructure, Tanh


def coupled_closed_loop(
    weights: Tensor,
    rates: Tensor,
    state: Tensor | None = None,
    posture: Tensor | None = None,
    *,
    rate_scale: Tensor,
    angle_scale: Tensor,
    structure: NarxStructure,
    tanh: Tanh = "rational",
) -> tuple[Tensor, Tensor]:
    """Run one network on three coupled axes.

    Compiled on the CPU, with the gradient with respect to the weights. If a gradient with respect
    to rates, state, posture or scales is required, for gradients of the gradient
    (``create_graph=True``), in the transforms of `torch.func` and on other devices, it runs in
    plain torch operations, hundreds of times slower.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights, shared by the axes.
    rates : Tensor, shape (..., N, 3)
        Gyroscope about the sagittal, frontal and transverse axis, rad/s.
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
    tanh : {"rational", "exact"}
        As in `narx.network.closed_loop.closed_loop`; for sine and cosine too.

    Returns
    -------
    angles : Tensor, shape (..., N, 3)
        ``angle_scale p + posture``, rad.
    final_state : Tensor, shape (..., 3, n_state)
        State after the last sample; without a gradient if the compiled kernel runs.

    Raises
    ------
    ValueError
        If shapes do not fit.
    """
    _check_weights(weights, structure)
    rates, state, posture = broadcast_axes(rates, state, posture, structure)
    others = (rates, state, posture, rate_scale, angle_scale)
    differentiated = torch.is_grad_enabled() and any(t.requires_grad for t in others)
    if differentiated or not compiled_for(rates):
        return coupled_closed_loop_by_torch(
            weights,
            rates,
            state,
            posture,
            rate_scale=rate_scale,
            angle_scale=angle_scale,
            structure=structure,
        )
    angles, final = _Coupled.apply(
        weights, rates, state, posture, rate_scale, angle_scale, structure, tanh
    )
    return angles, final


def coupled_closed_loop_by_torch(
    weights: Tensor,
    rates: Tensor,
    state: Tensor | None = None,
    posture: Tensor | None = None,
    *,
    rate_scale: Tensor,
    angle_scale: Tensor,
    structure: NarxStructure,
) -> tuple[Tensor, Tensor]:
    """Run the coupled axes in plain torch operations, one sample after another.

    Parameters
    ----------
    weights : Tensor, shape (P,)
        Flat weights, shared by the axes.
    rates : Tensor, shape (..., N, 3)
        Gyroscope, rad/s.
    state : Tensor, shape (..., 3, n_state), optional
        State before the first sample; zero if not given.
    posture : Tensor, shape (..., 3), optional
        Angles at a network output of zero, rad.
    rate_scale : Tensor, shape (3,)
        Rate that corresponds to 1 in the network, rad/s.
    angle_scale : Tensor, shape (3,)
        Angle that corresponds to an output of 1, rad.
    structure : NarxStructure
        Sizes of the network; one input.

    Returns
    -------
    angles : Tensor, shape (..., N, 3)
        Angles, rad.
    final_state : Tensor, shape (..., 3, n_state)
        State after the last sample.
    """
    _check_weights(weights, structure)
    rates, state, posture = broadcast_axes(rates, state, posture, structure)
    w1 = weights[..., structure.w1].unflatten(-1, (structure.hidden, structure.n_features))
    b1, w2, b2 = (weights[..., part] for part in (structure.b1, structure.w2, structure.b2))
    n_past, outputs = structure.n_input_state, []
    for sample in rates.unbind(-2):
        ahead = state[..., n_past]
        if structure.output_lags > 1:
            ahead = 2.0 * ahead - state[..., n_past + 1]
        v = coupled_rates(sample, angle_scale * ahead + posture) / rate_scale
        x = torch.cat([v.unsqueeze(-1), state], dim=-1)
        p = b2 + (w2 * torch.tanh((w1 * x.unsqueeze(-2)).sum(-1) + b1)).sum(-1)
        outputs.append(angle_scale * p + posture)
        state = torch.cat([x[..., :n_past], p.unsqueeze(-1), state[..., n_past:-1]], dim=-1)
    if not outputs:
        return torch.zeros_like(rates), state
    return torch.stack(outputs, dim=-2), state


def broadcast_axes(
    rates: Tensor, state: Tensor | None, posture: Tensor | None, structure: NarxStructure
) -> tuple[Tensor, Tensor, Tensor]:
    """Check last dimensions and expand the leading ones; missing arguments are zero.

    Parameters
    ----------
    rates : Tensor, shape (..., N, 3)
        Gyroscope.
    state : Tensor, shape (..., 3, n_state), or None
        State before the first sample.
    posture : Tensor, shape (..., 3), or None
        Angles at a network output of zero.
    structure : NarxStructure
        Sizes of the network; one input.

    Returns
    -------
    rates, state, posture : Tensor
        With the same leading dimensions.

    Raises
    ------
    ValueError
        If a shape does not fit.
    """
    if structure.n_inputs != 1:
        raise ValueError(f"n_inputs is {structure.n_inputs}, expected 1: the rate of each axis")
    if rates.ndim < 2 or rates.shape[-1] != 3:
        raise ValueError(f"rates {tuple(rates.shape)}, expected (..., N, 3)")
    state = rates.new_zeros(3, structure.n_state) if state is None else state
    posture = rates.new_zeros(3) if posture is None else posture
    lead = np.broadcast_shapes(rates.shape[:-2], state.shape[:-2], posture.shape[:-1])
    return (
        rates.expand(*lead, *rates.shape[-2:]),
        state.expand(*lead, 3, structure.n_state),
        posture.expand(*lead, 3),
    )


def _check_weights(weights: Tensor, structure: NarxStructure) -> None:
    if weights.shape != (structure.n_weights,):
        raise ValueError(f"weights {tuple(weights.shape)}, expected ({structure.n_weights},)")


class _Coupled(torch.autograd.Function):
    """The coupled recurrences on the CPU."""

    @staticmethod
    def forward(
        ctx: Any,
        weights: Tensor,
        rates: Tensor,
        state: Tensor,
        posture: Tensor,
        rate_scale: Tensor,
        angle_scale: Tensor,
        structure: NarxStructure,
        tanh: Tanh,
    ) -> tuple[Tensor, Tensor]:
        batch = CoupledBatch(rates, state, posture, rate_scale, angle_scale, structure, tanh)
        angles, last = batch.run(flat(weights, 1))
        final = back(last, state.shape, rates)
        ctx.save_for_backward(weights, rates, state, posture, rate_scale, angle_scale)
        ctx.batch, ctx.structure = batch, structure
        ctx.mark_non_differentiable(final)
        return back(angles, rates.shape, rates), final

    @staticmethod
    def backward(ctx: Any, d_angles: Tensor, _: Tensor) -> tuple[Tensor | None, ...]:
        weights, *others = ctx.saved_tensors
        if torch.is_grad_enabled():  # a graph of the gradient is asked for

            def angles(weights: Tensor) -> Tensor:
                rates, state, posture, rate_scale, angle_scale = others
                return coupled_closed_loop_by_torch(
                    weights, rates, state, posture, rate_scale=rate_scale,
                    angle_scale=angle_scale, structure=ctx.structure,
                )[0]  # fmt: skip

            return *gradients_by_torch(angles, [weights], [d_angles]), *(None,) * 7
        # products of the derivatives with d_angles in place of the residuals
        batch: CoupledBatch = ctx.batch
        wanted = Wanted(flat(d_angles, 2), given=True)
        products = batch.products(flat(weights, 1), wanted)
        gradient = batch.angle_scale @ products[0, :, weights.numel(), : weights.numel()]
        return back(gradient, weights.shape, weights), *(None,) * 7
