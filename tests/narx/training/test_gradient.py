"""Cost and gradient of the gradient optimisers, against finite differences and the prior."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.batch import Batch
from narx.training.gradient import Adam, Lbfgs, _basis, _compiled
from narx.training.initial_weights import leaky_integrator_weights, typical_sizes
from narx.training.objective import Objective
from narx.training.progress import Progress
from narx.training.restarts import Restarts
from narx.training.stages import Stage, stages_of


@pytest.fixture
def cost():
    """Cost in deg^2 and its gradient as a function of the weights, for a strength of the prior."""
    rng = np.random.default_rng(0)
    model = Narx(20.0, Normalisation(2.0, 0.3))
    start = torch.from_numpy(0.1 * rng.normal(size=(2, 3)))
    batch = Batch(
        torch.from_numpy(rng.normal(size=(2, 60, 3))),
        torch.from_numpy(0.2 * rng.normal(size=(2, 60, 3))),
        model.initial_state(start),
        start,
        torch.ones(2, dtype=torch.float64),
    )

    def with_prior(prior_deg2):
        (stage,) = stages_of(model, batch, Objective(), ["closed"], prior_deg2)
        return _compiled(stage)

    # away from the centre of the prior, each weight by its own share of its typical size
    size = typical_sizes(model)
    share = 0.3 * rng.normal(size=len(size))
    return with_prior, leaky_integrator_weights(model) + share * size, size, share


@pytest.mark.parametrize("prior_deg2", [0.0, 500.0])
def test_the_gradient_is_that_of_finite_differences(cost, prior_deg2):
    with_prior, weights, size, _ = cost
    value = with_prior(prior_deg2)
    steps = 1e-5 * np.diag(size)
    slopes = [(value(weights + d)[0] - value(weights - d)[0]) / 2e-5 for d in steps]
    scaled = value(weights)[1] * size
    np.testing.assert_allclose(scaled, slopes, rtol=1e-4, atol=1e-6 * np.abs(scaled).max())


def test_the_prior_costs_its_mean_square_per_typical_size(cost):
    """In deg^2: a weight changed by its typical size costs `prior_deg2`, in any unit."""
    with_prior, weights, _, share = cost
    added = with_prior(7.0)(weights)[0] - with_prior(0.0)(weights)[0]
    assert added == pytest.approx(7.0 * np.sum(share**2))


@pytest.mark.parametrize(("fall", "settled"), [(0.9e-3, True), (1.1e-3, False)])
def test_training_ends_when_the_cost_falls_by_less_than_asked_per_iteration(fall, settled):
    """The mean over the last ten iterations, relative to the cost before them."""
    costs = [200.0, 100.0 * (1.0 + fall)] + [100.0 * (1.0 - k * fall) for k in range(11)]
    optimizer = Lbfgs(cost_change=1e-3)
    assert optimizer._settled(costs) == settled
    assert not optimizer._settled(costs[-10:])


@pytest.mark.parametrize("device", ["meta", "nonsense"])
def test_a_device_without_values_is_refused(device):
    with pytest.raises(UserError, match=rf"^optimizer\.device is '{device}': "):
        Adam(device=device)


class Linear:
    """``A w - b``, whose least squares numpy finds; remembers the costs it was asked for."""

    n_weights = 3

    def __init__(self):
        rng = np.random.default_rng(0)
        self.a = rng.normal(size=(20, 3)) * [30.0, 3.0, 0.01]
        self.b = 10.0 * rng.normal(size=20)
        self.best = np.linalg.lstsq(self.a, self.b)[0]
        self.costs = []

    def products(self, weights):
        rows = np.column_stack([self.a, self.a @ weights[0] - self.b])
        self.costs.append(rows[:, -1] @ rows[:, -1] / 20.0)
        return (rows.T @ rows)[None]


def descended(optimizer, problem, start):
    run = Restarts(lambda iteration, numbers: None, Progress())
    run.begin(start)
    stage = Stage("linear", problem, 1.0 / 20.0)
    return optimizer._descend(stage, 0, np.arange(3), np.array([0.1, 2.0, 50.0]), run)


def test_directions_have_equal_curvature_down_to_a_limit():
    """One square degree per square unit; where it is less, the curvature stays as it is."""
    problem, size = Linear(), np.array([0.1, 2.0, 50.0])
    basis = _basis(Stage("linear", problem, 1.0 / 20.0), np.zeros(3), np.arange(3), size)
    curvature = problem.a.T @ problem.a / 20.0
    bends = np.linalg.eigvalsh(curvature * np.outer(size, size))
    assert bends[0] < 1.0 < bends[1]
    expected = np.diag([bends[0], 1.0, 1.0])
    np.testing.assert_allclose(basis.T @ curvature @ basis, expected, atol=1e-9)


def test_lbfgs_reaches_the_least_squares_of_a_linear_problem():
    problem = Linear()
    start = problem.best + np.array([1.0, -3.0, 20.0])
    found = descended(Lbfgs(iterations=30, cost_change=0.0), problem, start)
    np.testing.assert_allclose(found, problem.best, rtol=1e-3, atol=1e-3)


def test_the_lowest_cost_is_kept_although_a_step_raises_it():
    problem = Linear()
    found = descended(Adam(iterations=12, learning_rate=10.0), problem, problem.best)
    assert problem.costs[-1] > 1.005 * min(problem.costs)
    np.testing.assert_array_equal(found, problem.best)


def test_adam_descends_the_logarithm_of_the_cost(cost):
    with_prior, weights, size, _ = cost
    value = with_prior(0.0)
    steps = 1e-5 * np.diag(size)
    slopes = [np.log(value(weights + d)[0] / value(weights - d)[0]) / 2e-5 for d in steps]
    now, gradient = value(weights)
    scaled = Adam()._scaled(gradient, now) * size
    np.testing.assert_allclose(scaled, slopes, rtol=1e-4, atol=1e-6 * np.abs(scaled).max())
