"""Least-squares fits of a NARX network, reduced to their normal equations.

Forward sensitivities are carried along with the recurrence and folded into the Gauss-Newton
matrix while they are in the cache; the N x P Jacobian is never stored.
"""

from collections.abc import Sequence

from torch import Tensor

from narx.network.structure import NarxStructure, Tanh
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.coupled import CoupledFit
from narx.training.least_squares.problem import NormalEquations


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
        As in `narx.network.closed_loop.closed_loop`.

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    fit = NetworkFit(
        inputs,
        targets,
        state,
        structure=structure,
        sequence_weights=sequence_weights,
        washout=washout,
        horizon=horizon,
        tanh=tanh,
    )
    return fit.normal_equations(weights)


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
        As in `narx.network.closed_loop.closed_loop`.

    Returns
    -------
    NormalEquations
        Cost, gradient and Gauss-Newton matrix, summed over the sequences.
    """
    fit = NetworkFit(
        inputs,
        measured,
        state,
        structure=structure,
        sequence_weights=sequence_weights,
        washout=washout,
        horizon=1,
        tanh=tanh,
    )
    return fit.normal_equations(weights)


def coupled_normal_equations(
    weights: Tensor,
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
) -> NormalEquations:
    """Reduce the fit of one network to three coupled axes to its normal equations.

    Parameters
    ----------
    weights : Tensor, shape (P,) or (3, P)
        Flat weights, one set for all axes or a set for each.
    rates : Tensor, shape (..., N, 3)
        Gyroscope about the axes, rad/s, finite (shorter sequences are padded, with NaN targets).
    targets : Tensor, shape (..., N, 3)
        Angles wanted, rad; NaN samples do not count (the recurrence runs on).
    state : Tensor, shape (..., 3, n_state), optional
        Normalised state before the first sample; zero if not given.
    posture : Tensor, shape (..., 3), optional
        Angles at a network output of zero, rad; zero if not given.
    rate_scale : Tensor, shape (3,)
        Rate that is 1 to the network, rad/s.
    angle_scale : Tensor, shape (3,)
        Angle that an output of 1 stands for, rad.
    structure : NarxStructure
        Sizes of the network; one input.
    axis_weights : sequence of three floats
        Factors on the squared residuals of each axis.
    sequence_weights : Tensor, shape (...), optional
        Factor on the squared residuals of each sequence; 1 if not given.
    washout : int
        Initial samples of each sequence that do not count.
    offset_free : bool
        Take each sequence's mean residual off, axis by axis, before squaring.
    tanh : {"rational", "exact"}
        As in `narx.network.coupled_loop.coupled_closed_loop`.

    Returns
    -------
    NormalEquations
        Cost (rad^2), gradient and Gauss-Newton matrix by the flattened weights, summed over
        sequences and axes.
    """
    fit = CoupledFit(
        rates,
        targets,
        state,
        posture,
        rate_scale=rate_scale,
        angle_scale=angle_scale,
        structure=structure,
        axis_weights=axis_weights,
        sequence_weights=sequence_weights,
        washout=washout,
        offset_free=offset_free,
        tanh=tanh,
    )
    return fit.normal_equations(weights)
