"""Three coupled axes against plain torch operations and the kinematics they implement."""

import numpy as np
import pytest
import torch

from narx.kinematics.segment_angles import coupled_rates
from narx.network.coupled_loop import coupled_closed_loop, coupled_closed_loop_by_torch
from narx.network.structure import NarxStructure
from narx.training.least_squares.by_torch import products_by_torch
from narx.training.least_squares.coupled import CoupledFit

DEFAULT = NarxStructure()
SCALES = {
    "rate_scale": torch.tensor([2.0, 1.0, 1.5], dtype=torch.float64),
    "angle_scale": torch.tensor([0.8, 0.5, 0.6], dtype=torch.float64),
    "structure": DEFAULT,
}


def problem(n_sequences, n_samples, seed=0):
    rng = np.random.default_rng(seed)
    return [
        torch.from_numpy(a)
        for a in (
            0.4 * rng.standard_normal(19),
            rng.standard_normal((n_sequences, n_samples, 3)),
            0.5 * rng.standard_normal((n_sequences, 3, 3)),
            0.3 * rng.standard_normal((n_sequences, 3)),
        )
    ]


@pytest.mark.parametrize("n_sequences", [1, 11])
def test_equals_plain_torch(n_sequences):
    arguments = problem(n_sequences, 300)
    angles, final = coupled_closed_loop(*arguments, **SCALES)
    expected, expected_final = coupled_closed_loop_by_torch(*arguments, **SCALES)
    torch.testing.assert_close(angles, expected, rtol=0, atol=1e-10)
    torch.testing.assert_close(final, expected_final, rtol=0, atol=1e-10)


def test_exact_functions():
    arguments = problem(9, 200)
    angles, _ = coupled_closed_loop(*arguments, **SCALES, tanh="exact")
    expected, _ = coupled_closed_loop_by_torch(*arguments, **SCALES)
    torch.testing.assert_close(angles, expected, rtol=0, atol=1e-10)


def test_the_rates_are_those_of_the_kinematics():
    """A network that outputs v_k reveals its input."""
    weights, rates, state, posture = problem(5, 1)
    slope = 1e-4  # small enough for tanh to be linear
    weights[:] = 0.0
    weights[0], weights[DEFAULT.w2.start] = slope, 1.0 / slope
    angles, _ = coupled_closed_loop(weights, rates, state, posture, **SCALES)
    ahead = 2.0 * state[..., 1] - state[..., 2]
    tilt = (SCALES["angle_scale"] * ahead + posture).numpy()
    fed = coupled_rates(rates[:, 0].numpy(), tilt) / SCALES["rate_scale"].numpy()
    expected = SCALES["angle_scale"].numpy() * fed + posture.numpy()
    np.testing.assert_allclose(angles[:, 0], expected, rtol=1e-6)


def test_a_turn_of_a_tilted_segment_is_not_booked_as_flexion():
    """An integrator of coupled rates follows a rotation; three uncoupled ones do not."""
    rate_hz = 2000.0
    weights = torch.zeros(19, dtype=torch.float64)
    slope = 1e-3
    weights[0], weights[2] = slope / rate_hz, slope
    weights[DEFAULT.w2.start] = 1.0 / slope
    one = torch.ones(3, dtype=torch.float64)
    # tilted forward by 0.5 rad, turning about the vertical
    n, turn, tilt = 4000, 1.0, 0.5
    rates = torch.zeros(1, n, 3, dtype=torch.float64)
    rates[..., 1], rates[..., 2] = -turn * np.sin(tilt), turn * np.cos(tilt)
    posture = torch.tensor([[tilt, 0.0, 0.0]], dtype=torch.float64)
    angles, _ = coupled_closed_loop(
        weights, rates, None, posture, rate_scale=one, angle_scale=one, structure=DEFAULT
    )
    expected = torch.tensor([tilt, 0.0, turn * n / rate_hz], dtype=torch.float64)
    torch.testing.assert_close(angles[0, -1], expected, rtol=0, atol=5e-3)


def test_the_singularity_is_kept_away():
    weights, rates, state, posture = problem(3, 30)
    posture[:, 1] = torch.tensor([np.pi / 2, np.pi / 2 - 0.05, np.pi / 2 + 0.05])
    weights.requires_grad_()
    ours, theirs = (
        run(weights, rates, state, posture, **SCALES)[0]
        for run in (coupled_closed_loop, coupled_closed_loop_by_torch)
    )
    assert ours.isfinite().all()
    torch.testing.assert_close(ours, theirs, rtol=0, atol=1e-7)
    gradients = [torch.autograd.grad(a.square().sum(), weights)[0] for a in (ours, theirs)]
    torch.testing.assert_close(*gradients, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("n_sequences", [1, 3])
def test_gradcheck(n_sequences):
    weights, rates, state, posture = problem(n_sequences, 6)
    weights.requires_grad_()
    assert torch.autograd.gradcheck(
        lambda w: coupled_closed_loop(w, rates, state, posture, **SCALES)[0], weights
    )


def test_gradcheck_by_everything():
    inputs = [t.requires_grad_() for t in problem(2, 4)]
    scales = [SCALES[name].clone().requires_grad_() for name in ("rate_scale", "angle_scale")]

    def run(*given):
        rate_scale, angle_scale = given[4:]
        return coupled_closed_loop(
            *given[:4], **SCALES | {"rate_scale": rate_scale, "angle_scale": angle_scale}
        )

    assert torch.autograd.gradcheck(run, [*inputs, *scales])
    with torch.no_grad():  # without gradients the kernel runs and gives the same values
        compiled = run(*inputs, *scales)
    for ours, theirs in zip(compiled, run(*inputs, *scales), strict=True):
        assert not ours.requires_grad
        assert theirs.requires_grad
        torch.testing.assert_close(ours, theirs.detach(), rtol=0, atol=1e-12)


@pytest.mark.parametrize("offset_free", [False, True])
@pytest.mark.parametrize("axis_weights", [(1.0, 2.0, 0.5), (1.0, 1.0, 0.0), (1.0, 0.0, 0.5)])
def test_normal_equations_against_autograd(offset_free, axis_weights):
    weights, rates, state, posture = problem(9, 150)
    weights.requires_grad_()
    targets = torch.from_numpy(np.random.default_rng(5).standard_normal(rates.shape))
    targets[:, 30:40, 0] = torch.nan
    targets[0, 90:] = torch.nan
    share = torch.linspace(0.5, 2.0, 9, dtype=torch.float64)
    options = {
        "axis_weights": axis_weights,
        "sequence_weights": share,
        "washout": 4,
        "offset_free": offset_free,
    }
    fit = CoupledFit(rates, targets, state, posture, **SCALES, **options)
    products = fit.products(weights.detach().numpy()[None])[0]
    angles, _ = coupled_closed_loop_by_torch(weights, rates, state, posture, **SCALES)
    there = ~targets.isnan()
    there[:, :4] = False
    error = torch.where(there, angles - targets.nan_to_num(), 0.0)
    if offset_free:
        error = error - error.sum(1, keepdim=True) / there.sum(1, keepdim=True)
        error = torch.where(there, error, 0.0)
    factors = torch.tensor(axis_weights, dtype=torch.float64) * share[:, None, None]
    cost = 0.5 * (factors * error.square()).sum()
    (gradient,) = torch.autograd.grad(cost, weights)
    np.testing.assert_allclose(0.5 * products[-1, -1], cost.item(), rtol=1e-12)
    np.testing.assert_allclose(products[-1, :-1], gradient, rtol=1e-9, atol=1e-9)
    by_torch = products_by_torch(fit.residuals, weights.detach().numpy()[None])[0]
    np.testing.assert_allclose(np.tril(products), np.tril(by_torch), rtol=1e-9, atol=1e-9)


def test_starts_in_step_equal_starts_alone():
    weights, rates, state, posture = problem(3, 130)
    targets = 0.1 * rates
    fit = CoupledFit(rates, targets, state, posture, **SCALES, offset_free=True)
    starts = weights.numpy() * np.linspace(0.5, 1.5, 11)[:, None]
    together = fit.products(starts)
    for start, products in zip(starts, together, strict=True):
        alone = fit.products(start[None])[0]
        np.testing.assert_allclose(np.tril(products), np.tril(alone), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("pieces", [[1, 299], [128, 172], [150, 0, 150]])
def test_pieces_give_the_same_as_the_whole(pieces):
    weights, rates, state, posture = problem(9, 300)
    whole, whole_final = coupled_closed_loop(weights, rates, state, posture, **SCALES)
    parts = []
    for piece in rates.split(pieces, dim=1):
        part, state = coupled_closed_loop(weights, piece, state, posture, **SCALES)
        parts.append(part)
    assert torch.equal(torch.cat(parts, dim=1), whole)
    assert torch.equal(state, whole_final)


def test_edges():
    weights, rates, state, posture = problem(2, 2)
    one, _ = coupled_closed_loop(weights, rates[:, :1], state, posture, **SCALES)
    both, _ = coupled_closed_loop(weights, rates, state, posture, **SCALES)
    assert torch.equal(one[:, 0], both[:, 0])
    none, final = coupled_closed_loop(weights, rates[:, :0], state, posture, **SCALES)
    assert none.shape == (2, 0, 3)
    assert torch.equal(final, state)
    rates[0, 0, 2] = torch.nan
    missing, _ = coupled_closed_loop(weights, rates, state, posture, **SCALES)
    assert missing[0, 1].isnan().all()
    assert missing[1].isfinite().all()
    with pytest.raises(ValueError, match="rates"):
        coupled_closed_loop(weights, rates[..., :2], state, posture, **SCALES)
    with pytest.raises(ValueError, match="weights"):
        coupled_closed_loop(weights[:5], rates, state, posture, **SCALES)
