"""Each stage's cost against a plain loop over sequences, axes and samples, in square degrees."""

import numpy as np
import pytest
import torch

from narx.kinematics.segment_angles import coupled_rates
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.batch import Batch
from narx.training.initial_weights import random_weights
from narx.training.objective import Objective
from narx.training.stages import closed_loop_fit, stages_of

RATE_HZ, B, N, MISSING_FROM = 20.0, 2, 40, 30
HORIZON = 7
AXIS_WEIGHTS = (1.0, 0.0, 0.25)
SEQUENCE_WEIGHTS = (2.0, 0.5)


def networks_and_sequences(coupled):
    rng = np.random.default_rng(0)
    offsets = (0.0, 0.0) if coupled else (0.1, -0.05)
    model = Narx(RATE_HZ, Normalisation(2.0, 0.3, *offsets), None, odd=False, coupled=coupled)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(random_weights(model, rng, slope=0.2)))
    targets = 0.2 * rng.normal(size=(B, N, 3))
    targets[1, MISSING_FROM:] = np.nan  # padding
    arrays = rng.normal(size=(B, N, 3)), targets, 0.1 * rng.normal(size=(B, 3, 3))
    rates, wanted, state = map(torch.from_numpy, arrays)
    posture = torch.from_numpy(0.1 * rng.normal(size=(B, 3)))
    return model, Batch(rates, wanted, state, posture, torch.tensor(SEQUENCE_WEIGHTS).double())


def step(model, v, before, outputs):
    """``b2 + w2 . tanh(W1 (v_k, v_{k-1}, p_{k-1}, p_{k-2}) + b1)``."""
    w, s = model.weights.detach().numpy(), model.structure
    x = np.array([v, before, *outputs])
    return w[s.b2] + w[s.w2] @ np.tanh(w[s.w1].reshape(3, 4) @ x + w[s.b1])


def errors_of(model, sequences, row, axis, name):
    """Errors of one axis of a sequence, normalised; NaN where none is defined."""
    scaled = model.normalisation
    rates, angles = sequences.rates_rad_s[row].numpy(), sequences.targets_rad[row].numpy()
    if model.coupled:
        rates = coupled_rates(rates, angles)
    v = (rates[:, axis] - scaled.rate_offset_rad_s) / scaled.rate_scale_rad_s
    posture = float(sequences.posture_rad[row, axis])
    wanted = (angles[:, axis] - posture - scaled.angle_offset_rad) / scaled.angle_scale_rad
    before, *outputs = sequences.state[row, axis].tolist()
    errors = np.full(N, np.nan)
    for k in range(MISSING_FROM if row == 1 else N):
        if name == "open" or (k and k % HORIZON == 0):
            outputs = list(wanted[k - 2 : k][::-1]) if k > 1 else [np.nan, np.nan]
        p = step(model, v[k], before, outputs)
        errors[k] = p - wanted[k]
        before, outputs = v[k], [p, outputs[0]]
    return errors


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("washout_s", [0.0, 0.4])
@pytest.mark.parametrize("name", ["open", HORIZON])
def test_the_cost_ahead_is_a_weighted_mean_square(coupled, washout_s, name):
    model, sequences = networks_and_sequences(coupled)
    objective = Objective(AXIS_WEIGHTS, washout_s=washout_s)
    (stage,) = stages_of(model, sequences, objective, [name], 0.0)
    squares = total = 0.0
    for row in range(B):
        for axis in (0, 2):
            errors = errors_of(model, sequences, row, axis, name)[round(washout_s * RATE_HZ) :]
            errors = np.degrees(0.3 * errors[np.isfinite(errors)])
            weight = SEQUENCE_WEIGHTS[row] * AXIS_WEIGHTS[axis]
            squares, total = squares + weight * errors @ errors, total + weight * len(errors)
    products = stage.problem.products(model.weights.detach().numpy()[None])
    assert products[0, -1, -1] * stage.mean_square == pytest.approx(squares / total, rel=1e-9)


@pytest.mark.parametrize("coupled", [False, True])
def test_the_cost_in_closed_loop_is_a_weighted_mean_square(coupled):
    model, sequences = networks_and_sequences(coupled)
    objective = Objective(AXIS_WEIGHTS, offset_free=False)
    problem, unit_deg2 = closed_loop_fit(model, sequences, objective, "training")
    with torch.no_grad():
        angles, _ = model(sequences.rates_rad_s, sequences.state, sequences.posture_rad)
    squares = torch.rad2deg(angles - sequences.targets_rad).numpy() ** 2
    weights = np.multiply.outer(SEQUENCE_WEIGHTS, AXIS_WEIGHTS)[:, None] * np.isfinite(squares)
    mean = np.nansum(weights * squares) / weights.sum()
    found = problem.products(model.weights.detach().numpy()[None])[0, -1, -1]
    assert found * unit_deg2 / problem.total_weight == pytest.approx(mean, rel=1e-9)
    (stage,) = stages_of(model, sequences, objective, ["closed"], 0.0)
    assert stage.mean_square == pytest.approx(unit_deg2 / problem.total_weight)
