"""The training objective against numpy."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.batch import Batch
from narx.training.initial_weights import leaky_integrator_weights, random_weights
from narx.training.objective import Objective
from narx.training.stages import closed_loop_fit

RATE_HZ = 20.0
B, N = 3, 80


@pytest.fixture
def model():
    model = Narx(RATE_HZ, Normalisation(2.0, 0.3))
    with torch.no_grad():
        weights = random_weights(model, np.random.default_rng(0), slope=0.2)
        model.weights.copy_(torch.from_numpy(weights))
    return model


@pytest.fixture
def sequences(model):
    rng = np.random.default_rng(1)
    rates, targets = rng.normal(size=(B, N, 3)), 0.2 * rng.normal(size=(B, N, 3))
    targets[0, 50:] = np.nan  # padding
    targets[1, 30:40, 1] = np.nan
    targets[:, :, 2] += 0.5
    return Batch(
        torch.from_numpy(rates),
        torch.from_numpy(targets),
        model.initial_state(torch.from_numpy(0.1 * rng.normal(size=(B, 3)))),
        torch.from_numpy(0.1 * rng.normal(size=(B, 3))),
        torch.tensor([1.0, 2.0, 0.5], dtype=torch.float64),
    )


def cost_and_gradient(objective, model, sequences):
    """Mean square that an optimiser minimises, rad^2, and half its gradient."""
    problem, _ = closed_loop_fit(model, sequences, objective, "test")
    products = problem.products(model.weights.detach().numpy()[None])[0] / problem.total_weight
    return products[-1, -1], products[-1, :-1]


def cost(objective, model, sequences):
    return cost_and_gradient(objective, model, sequences)[0]


@pytest.mark.parametrize("offset_free", [False, True])
@pytest.mark.parametrize("washout_s", [0.0, 1.0])
@pytest.mark.parametrize("axis_weights", [(1.0, 0.0, 0.0), (1.0, 0.5, 0.2)])
def test_mean_square_as_numpy_has_it(model, sequences, offset_free, washout_s, axis_weights):
    objective = Objective(axis_weights, offset_free, washout_s)
    with torch.no_grad():
        angles = model(sequences.rates_rad_s, sequences.state, sequences.posture_rad)[0].numpy()
    error = angles - sequences.targets_rad.numpy()
    error[:, : round(washout_s * RATE_HZ)] = np.nan
    if offset_free:
        error -= np.nanmean(error, axis=1, keepdims=True)
    squares = weights = 0.0
    for row in range(B):
        for axis in range(3):
            counted = error[row, :, axis][np.isfinite(error[row, :, axis])]
            weight = float(sequences.weight[row]) * axis_weights[axis]
            squares += weight * np.sum(counted**2)
            weights += weight * len(counted)
    assert cost(objective, model, sequences) == pytest.approx(squares / weights, rel=1e-9)


def test_an_offset_does_not_matter_where_it_is_not_to(model, sequences):
    shifted = replace(sequences, targets_rad=sequences.targets_rad + 0.3)
    free, bound = Objective(offset_free=True), Objective(offset_free=False)
    assert cost(free, model, shifted) == pytest.approx(cost(free, model, sequences), rel=1e-9)
    assert cost(bound, model, shifted) != pytest.approx(cost(bound, model, sequences), rel=0.1)


def test_unused_samples_have_no_gradient(model, sequences):
    targets = sequences.targets_rad.clone()
    targets[1:] = math.nan
    rates = sequences.rates_rad_s.clone()
    rates[1:] *= -2.0
    rates[0, 50:] *= -2.0  # the padding of the first
    alone = Batch(*(value[:1] for value in vars(sequences).values()))
    gradients = []
    for those in (replace(sequences, targets_rad=targets, rates_rad_s=rates), alone):
        gradients.append(cost_and_gradient(Objective(), model, those)[1])
    assert np.abs(gradients[0]).max() > 1e-3
    np.testing.assert_allclose(gradients[0], gradients[1], rtol=1e-9, atol=1e-12)


def test_no_rest_no_row(sequences, model):
    assert Objective(rest_weight=0.0).with_rest(model, sequences) is sequences


def test_the_return_to_rest_is_a_decay_without_motion(model, sequences):
    objective = Objective(rest_weight=0.5, rest_leak_rad_s=0.5)
    resting = objective.with_rest(model, sequences)
    n = round(4.0 / 0.5 * RATE_HZ)  # four time constants
    assert resting.rates_rad_s.shape == resting.targets_rad.shape == (B + 1, n, 3)
    assert not resting.rates_rad_s[B].any()
    assert not resting.posture_rad[B].any()
    time_s = np.arange(1, n + 1) / RATE_HZ
    expected = np.tile(0.2 * np.exp(-0.5 * time_s)[:, None], 3)
    np.testing.assert_allclose(resting.targets_rad[B], expected, atol=1e-12)
    np.testing.assert_allclose(resting.state[B, :, 1:], 0.2 / 0.3, atol=1e-12)
    # the other sequences are padded and otherwise unchanged
    np.testing.assert_array_equal(resting.rates_rad_s[:B, :N], sequences.rates_rad_s)
    np.testing.assert_array_equal(resting.targets_rad[:B, :N], sequences.targets_rad)
    assert not resting.rates_rad_s[:B, N:].any()
    assert resting.targets_rad[:B, N:].isnan().all()


def test_a_short_return_is_as_long_as_the_longest_sequence(model, sequences):
    resting = Objective(rest_weight=0.5, rest_leak_rad_s=10.0).with_rest(model, sequences)
    assert resting.rates_rad_s.shape == (B + 1, N, 3)
    assert resting.targets_rad[B].isfinite().all()


@pytest.mark.parametrize("axis_weights", [(1.0, 0.0, 0.0), (1.0, 0.5, 0.2)])
def test_the_return_weighs_as_much_as_said_beside_all_others_together(
    model, sequences, axis_weights
):
    objective = Objective(axis_weights, rest_weight=0.25, rest_leak_rad_s=0.5)
    resting = objective.with_rest(model, sequences)
    counts = resting.targets_rad.isfinite() * torch.tensor(axis_weights, dtype=torch.float64)
    share = (counts * resting.weight[:, None, None]).sum(dim=(1, 2))
    assert float(share[B] / share[:B].sum()) == pytest.approx(0.25, rel=1e-9)


def test_a_leaky_integrator_returns_as_asked():
    model = Narx(RATE_HZ, Normalisation(2.0, 0.3))
    objective = Objective(offset_free=False, rest_weight=1.0, rest_leak_rad_s=0.3)

    def error_deg(sequences, leak_rad_s):
        weights = leaky_integrator_weights(model, leak_rad_s)
        with torch.no_grad():
            model.weights.copy_(torch.from_numpy(weights))
        return math.degrees(math.sqrt(cost(objective, model, sequences)))

    nothing = Batch(
        torch.zeros(1, 10, 3, dtype=torch.float64),
        torch.zeros(1, 10, 3, dtype=torch.float64),
        torch.zeros(1, 3, model.structure.n_state, dtype=torch.float64),
        torch.zeros(1, 3, dtype=torch.float64),
        torch.ones(1, dtype=torch.float64),
    )
    resting = objective.with_rest(model, nothing)
    assert error_deg(resting, 0.3) < 0.05
    assert error_deg(resting, 0.1) > 1.0
    assert error_deg(resting, 0.9) > 1.0


def test_torch_and_the_compiled_loop_have_the_same_errors_free_of_their_mean(model, sequences):
    """The mean is that of the scored samples alone: two of the sequences have others."""
    objective = Objective(offset_free=True)
    problem, _ = closed_loop_fit(model, sequences, objective, "test")
    squares = problem.residuals(model.weights.detach()).square().sum()
    expected, _ = cost_and_gradient(objective, model, sequences)
    np.testing.assert_allclose(squares / problem.total_weight, expected, rtol=1e-9)
