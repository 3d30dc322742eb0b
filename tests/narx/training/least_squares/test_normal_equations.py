"""Normal equations against the Jacobians they stand for."""

import numpy as np
import pytest
import torch

from narx.network.closed_loop import closed_loop_by_torch, closed_loop_jacobian
from narx.network.open_loop import open_loop, open_loop_jacobian
from narx.network.structure import NarxStructure
from narx.training.least_squares.normal_equations import (
    closed_loop_normal_equations,
    open_loop_normal_equations,
)

DEFAULT = NarxStructure()


def problem(n_sequences, n_samples, seed=0):
    rng = np.random.default_rng(seed)
    weights = torch.from_numpy(0.4 * rng.standard_normal(19))
    inputs = torch.from_numpy(rng.standard_normal((n_sequences, n_samples, 1)))
    targets = torch.from_numpy(rng.standard_normal((n_sequences, n_samples)))
    state = torch.from_numpy(rng.standard_normal((n_sequences, 3)))
    return weights, inputs, targets, state


def from_jacobian(outputs, jac, targets, weights, washout):
    counts = ~(targets.isnan() | outputs.isnan())
    counts[:, :washout] = False
    root = weights.sqrt()[:, None].expand(targets.shape)[counts]
    e = (outputs - targets)[counts] * root
    j = jac[counts] * root[:, None]
    return 0.5 * e @ e, j.T @ e, j.T @ j, int(counts.sum())


@pytest.mark.parametrize("n_sequences", [1, 2, 11])
@pytest.mark.parametrize("kind", ["open", "closed"])
def test_equal_to_the_jacobians(n_sequences, kind):
    weights, inputs, targets, state = problem(n_sequences, 300)
    targets[:, 40:43] = torch.nan
    targets[0, 200:] = torch.nan
    share = torch.linspace(0.5, 2.0, n_sequences, dtype=torch.float64)
    options = {"structure": DEFAULT, "sequence_weights": share, "washout": 5}
    if kind == "open":
        outputs, jac = open_loop_jacobian(weights, inputs, targets, state, structure=DEFAULT)
        ours = open_loop_normal_equations(weights, inputs, targets, state, **options)
    else:
        outputs, jac = closed_loop_jacobian(weights, inputs, state, structure=DEFAULT)
        ours = closed_loop_normal_equations(weights, inputs, targets, state, **options)
    cost, gradient, jtj, n = from_jacobian(outputs, jac, targets, share, 5)
    assert ours.n_residuals == n
    np.testing.assert_allclose(ours.cost, cost, rtol=1e-12)
    np.testing.assert_allclose(ours.gradient, gradient, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(ours.jtj, jtj, rtol=1e-10, atol=1e-10)


def test_open_loop_jacobian_against_autograd():
    weights, inputs, targets, state = problem(2, 12)
    _, jac = open_loop_jacobian(weights, inputs, targets, state, structure=DEFAULT)
    expected = torch.autograd.functional.jacobian(
        lambda w: open_loop(w, inputs, targets, state, structure=DEFAULT), weights
    )
    torch.testing.assert_close(jac, expected)


def test_open_loop_is_the_first_step_of_the_closed_loop():
    weights, inputs, targets, state = problem(1, 30)
    predicted = open_loop(weights, inputs, targets, state, structure=DEFAULT)
    for k in range(2, 30):
        now = torch.stack([inputs[0, k - 1, 0], targets[0, k - 1], targets[0, k - 2]])
        step, _ = closed_loop_by_torch(weights, inputs[0, k : k + 1], now, structure=DEFAULT)
        torch.testing.assert_close(predicted[0, k], step[0])


@pytest.mark.parametrize("n_sequences", [1, 3])
@pytest.mark.parametrize("horizon", [1, 2, 7, 200])
def test_multi_step_restarts_from_measured_outputs(n_sequences, horizon):
    weights, inputs, targets, state = problem(n_sequences, 170)
    weights.requires_grad_()
    ours = closed_loop_normal_equations(
        weights, inputs, targets, state, structure=DEFAULT, horizon=horizon
    )
    past_v = torch.cat([state[:, :1], inputs[..., 0]], dim=1)
    past_p = torch.cat([state[:, 1:].flip(-1), targets], dim=1)
    cost = torch.zeros((), dtype=torch.float64)
    for k in range(0, 170, horizon):
        start = torch.cat([past_v[:, k : k + 1], past_p[:, k : k + 2].flip(-1)], dim=1)
        part = slice(k, k + horizon)
        outputs, _ = closed_loop_by_torch(weights, inputs[:, part], start, structure=DEFAULT)
        cost = cost + 0.5 * (outputs - targets[:, part]).square().sum()
    (gradient,) = torch.autograd.grad(cost, weights)
    np.testing.assert_allclose(ours.cost, cost.item(), rtol=1e-12)
    np.testing.assert_allclose(ours.gradient, gradient, rtol=1e-9, atol=1e-9)
    if horizon == 1:
        weights = weights.detach()
        once = open_loop_normal_equations(weights, inputs, targets, state, structure=DEFAULT)
        np.testing.assert_allclose(ours.jtj, once.jtj, rtol=1e-12)


def test_pieces_carry_the_state_over():
    weights, inputs, targets, state = problem(3, 260)
    whole = closed_loop_normal_equations(weights, inputs, targets, state, structure=DEFAULT)
    first = closed_loop_normal_equations(
        weights, inputs[:, :100], targets[:, :100], state, structure=DEFAULT
    )
    assert first.final_state.shape == (3, 3)
    _, expected = closed_loop_by_torch(weights, inputs, state, structure=DEFAULT)
    np.testing.assert_allclose(whole.final_state, expected, atol=1e-12)


def test_nothing_counts():
    weights, inputs, targets, state = problem(2, 20)
    empty = closed_loop_normal_equations(
        weights, inputs, targets * torch.nan, state, structure=DEFAULT
    )
    assert empty.cost == 0.0
    assert empty.n_residuals == 0
    assert not empty.jtj.any()
    none = closed_loop_normal_equations(
        weights, inputs[:, :0], targets[:, :0], state, structure=DEFAULT
    )
    assert none.cost == 0.0
    np.testing.assert_array_equal(none.final_state, state)


def test_threads_do_not_change_a_bit():
    weights, inputs, targets, state = problem(40, 150)
    threads = torch.get_num_threads()
    results = []
    try:
        for n in (1, 2, 3):
            torch.set_num_threads(n)
            results.append(
                closed_loop_normal_equations(weights, inputs, targets, state, structure=DEFAULT)
            )
    finally:
        torch.set_num_threads(threads)
    for other in results[1:]:
        np.testing.assert_array_equal(results[0].jtj, other.jtj)
