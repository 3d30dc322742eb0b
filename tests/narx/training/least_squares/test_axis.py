"""The fit of one network against Jacobians by forward differentiation of plain torch loops."""

import numpy as np
import pytest
import torch

from narx.network.closed_loop import closed_loop_by_torch
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.by_torch import products_by_torch

DEFAULT = NarxStructure()


def problem(n_sequences, n_samples, seed=0):
    rng = np.random.default_rng(seed)
    weights = torch.from_numpy(0.4 * rng.standard_normal(19))
    inputs = torch.from_numpy(rng.standard_normal((n_sequences, n_samples, 1)))
    targets = torch.from_numpy(rng.standard_normal((n_sequences, n_samples)))
    state = torch.from_numpy(rng.standard_normal((n_sequences, 3)))
    return weights, inputs, targets, state


def closed(weights, inputs, measured, state):
    return closed_loop_by_torch(weights, inputs, state, structure=DEFAULT)[0]


def normal_equations(fit, weights):
    """Cost, gradient and Gauss-Newton matrix."""
    products = fit.products(weights.detach().numpy()[None])[0]
    lower = np.tril(products[:-1, :-1])
    return 0.5 * products[-1, -1], products[-1, :-1], lower + np.tril(lower, -1).T


@pytest.mark.parametrize("n_sequences", [1, 2, 11])
def test_equal_to_the_jacobians(n_sequences):
    run = closed
    weights, inputs, targets, state = problem(n_sequences, 300)
    targets[:, 40:43] = torch.nan
    targets[0, 200:] = torch.nan
    share = torch.linspace(0.5, 2.0, n_sequences, dtype=torch.float64)
    fit = NetworkFit(inputs, targets, state, structure=DEFAULT, sequence_weights=share, washout=5)
    outputs = run(weights, inputs, targets, state)
    jac = torch.func.jacfwd(run)(weights, inputs, targets, state)
    counts = ~(targets.isnan() | outputs.isnan())
    counts[:, :5] = False
    root = share.sqrt()[:, None].expand(targets.shape)[counts]
    e, j = (outputs - targets)[counts] * root, jac[counts] * root[:, None]
    cost, gradient, jtj = normal_equations(fit, weights)
    assert fit.n_residuals == int(counts.sum())
    np.testing.assert_allclose(fit.total_weight, float((counts.sum(dim=1) * share).sum()))
    np.testing.assert_allclose(cost, 0.5 * e @ e, rtol=1e-12)
    np.testing.assert_allclose(gradient, j.T @ e, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(jtj, j.T @ j, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("n_sequences", [1, 3])
@pytest.mark.parametrize("horizon", [2, 7, 200])
def test_multi_step_restarts_from_measured_outputs(n_sequences, horizon):
    weights, inputs, targets, state = problem(n_sequences, 170)
    weights.requires_grad_()
    fit = NetworkFit(inputs, targets, state, structure=DEFAULT, horizon=horizon)
    ours_cost, ours_gradient, _ = normal_equations(fit, weights)
    past_v = torch.cat([state[:, :1], inputs[..., 0]], dim=1)
    past_p = torch.cat([state[:, 1:].flip(-1), targets], dim=1)
    cost = torch.zeros((), dtype=torch.float64)
    for k in range(0, 170, horizon):
        start = torch.cat([past_v[:, k : k + 1], past_p[:, k : k + 2].flip(-1)], dim=1)
        part = slice(k, k + horizon)
        outputs, _ = closed_loop_by_torch(weights, inputs[:, part], start, structure=DEFAULT)
        cost = cost + 0.5 * (outputs - targets[:, part]).square().sum()
    (gradient,) = torch.autograd.grad(cost, weights)
    np.testing.assert_allclose(ours_cost, cost.item(), rtol=1e-12)
    np.testing.assert_allclose(ours_gradient, gradient, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("horizon", [None, 2, 7])
def test_residuals_by_torch_have_the_products_of_the_compiled_loop(horizon):
    weights, inputs, targets, state = problem(2, 60)
    targets[0, 20:23] = targets[1, 50:] = torch.nan
    share = torch.tensor([0.5, 2.0], dtype=torch.float64)
    options = {"sequence_weights": share, "washout": 3, "horizon": horizon}
    fit = NetworkFit(inputs, targets, state, structure=DEFAULT, **options)
    starts = weights.numpy()[None]
    found, expected = fit.products(starts)[0], products_by_torch(fit.residuals, starts)[0]
    np.testing.assert_allclose(np.tril(found), np.tril(expected), rtol=1e-9, atol=1e-9)


def test_restarts_from_its_own_outputs_change_nothing():
    """With more output lags than the horizon: the first restart needs the first state as well."""
    structure, rng = NarxStructure(2, 1, 2, 3), np.random.default_rng(1)
    shapes = (structure.n_weights, (1, 20, 1), (1, structure.n_state))
    weights, inputs, state = (torch.from_numpy(0.5 * rng.standard_normal(n)) for n in shapes)
    outputs, _ = closed_loop_by_torch(weights, inputs, state, structure=structure)
    fit = NetworkFit(inputs, outputs, state, structure=structure, horizon=2)
    assert fit.residuals(weights).abs().max() < 1e-12


def test_nothing_counts():
    weights, inputs, targets, state = problem(2, 20)
    empty = NetworkFit(inputs, targets * torch.nan, state, structure=DEFAULT)
    none = NetworkFit(inputs[:, :0], targets[:, :0], state, structure=DEFAULT)
    for fit in (empty, none):
        assert fit.n_residuals == 0
        assert not fit.products(weights.numpy()[None]).any()


@pytest.mark.concurrency
def test_threads_do_not_change_a_bit():
    weights, inputs, targets, state = problem(40, 150)
    threads = torch.get_num_threads()
    results = []
    try:
        for n in (1, 2, 3):
            torch.set_num_threads(n)
            fit = NetworkFit(inputs, targets, state, structure=DEFAULT)
            results.append(fit.products(weights.numpy()[None]))
    finally:
        torch.set_num_threads(threads)
    for other in results[1:]:
        np.testing.assert_array_equal(results[0], other)
