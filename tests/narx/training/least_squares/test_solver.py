"""The solver against scipy, and each of its parts against its specification."""

import numpy as np
import pytest
import torch
from scipy.optimize import least_squares

from narx.experiments.speed.task import random_starts
from narx.kernels.lm_step import damped_steps
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.one_step import OneStepFit
from narx.training.least_squares.solver import Options, levenberg_marquardt
from narx.training.least_squares.stopping import ResultCode, Stopping
from narx.windows.lagged import LaggedWindows

DEFAULT = NarxStructure()


def signals(n=600, noise=0.0, seed=0):
    """A saturated leaky integrator of a gait-like rate."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(n) / 100.0
    v = np.sin(2 * np.pi * 0.9 * time_s) + 0.4 * np.sin(2 * np.pi * 1.8 * time_s + 1.0)
    p = np.zeros(n)
    for k in range(1, n):
        p[k] = 0.97 * p[k - 1] + 0.05 * np.tanh(v[k])
    return torch.from_numpy(v)[:, None], torch.from_numpy(p + noise * rng.standard_normal(n))


def one_step_fit(inputs, targets):
    return OneStepFit(LaggedWindows([inputs.numpy()], [targets.numpy()]), DEFAULT)


class Curve:
    """Rosenbrock's function and friends as a least-squares problem."""

    n_weights = 2
    n_residuals = 2

    def products(self, weights):
        out = []
        for x, y in weights:
            r = np.array([10.0 * (y - x * x), 1.0 - x])
            j = np.array([[-20.0 * x, 10.0], [-1.0, 0.0]])
            both = np.column_stack([j, r])
            out.append(both.T @ both)
        return np.array(out)


@pytest.mark.parametrize("scaling", ["identity", "diagonal"])
def test_rosenbrock(scaling):
    options = Options(Stopping(max_evaluations=300), scaling)
    result = levenberg_marquardt(Curve(), [[-1.2, 1.0], [2.0, -3.0]], options)
    np.testing.assert_allclose(result.weights, 1.0, atol=1e-6)
    assert all(code != ResultCode.NOT_FINITE for code in result.codes)


def test_no_kept_step_raises_the_cost():
    inputs, targets = signals(noise=0.01)
    fit = NetworkFit(inputs, targets, structure=DEFAULT)
    starts = random_starts(9, np.random.default_rng(0))
    result = levenberg_marquardt(fit, starts, Options(Stopping(max_evaluations=40)))
    cost = result.history["cost"]
    assert (np.diff(cost, axis=0)[~np.isnan(np.diff(cost, axis=0))] <= 0).all()
    assert cost.shape == result.history["damping"].shape == result.history["gradient"].shape
    np.testing.assert_allclose(0.5 * fit.products(result.weights)[:, -1, -1], result.cost)


def test_reaches_the_cost_of_scipy_from_the_same_start():
    inputs, targets = signals(300, noise=0.01)
    fit = one_step_fit(inputs, targets)
    # starts near one minimum: from distant starts, which of the equal minima is reached is random
    rng = np.random.default_rng(1)
    options = Options(Stopping(max_evaluations=600))
    valley = levenberg_marquardt(fit, random_starts(1, rng), options).weights
    starts = valley * (1.0 + 0.2 * rng.standard_normal((3, 19)))
    result = levenberg_marquardt(fit, starts, options)

    def errors(w):
        return fit.residuals(w)

    def residuals(w):
        return errors(torch.from_numpy(w)).numpy()

    def jacobian(w):
        return torch.func.jacfwd(errors)(torch.from_numpy(w)).numpy()

    for start, cost in zip(starts, result.cost, strict=True):
        theirs = least_squares(residuals, start, jacobian, method="lm", max_nfev=600)
        assert cost <= theirs.cost * (1.0 + 1e-3)


def test_starts_are_trained_each_on_its_own():
    inputs, targets = signals()
    fit = one_step_fit(inputs, targets)
    starts = random_starts(5, np.random.default_rng(2))
    options = Options(Stopping(max_evaluations=5))
    together = levenberg_marquardt(fit, starts, options)
    again = levenberg_marquardt(fit, starts, options)
    np.testing.assert_array_equal(together.weights, again.weights)
    for i, start in enumerate(starts):
        alone = levenberg_marquardt(fit, start, options)
        np.testing.assert_allclose(together.cost[i], alone.cost[0], rtol=1e-6)


def test_trainable_weights_only():
    inputs, targets = signals()
    fit = NetworkFit(inputs, targets, structure=DEFAULT)
    starts = random_starts(3, np.random.default_rng(3))
    held = np.zeros(DEFAULT.n_weights, dtype=bool)
    held[DEFAULT.b1] = held[DEFAULT.b2] = True
    assert held.sum() == 4
    starts[:, held] = 0.0
    result = levenberg_marquardt(
        fit, starts, Options(Stopping(max_evaluations=10)), trainable=~held
    )
    assert not result.weights[:, held].any()
    assert (result.cost < 0.5 * fit.products(starts)[:, -1, -1]).all()


def test_the_step_solves_the_augmented_system():
    rng = np.random.default_rng(4)
    jac, r, w = rng.standard_normal((40, 6)), rng.standard_normal(40), rng.standard_normal(6)
    both = np.column_stack([jac, r])
    free = np.array([0, 2, 3, 5])
    mu, decay = 0.3, 0.2
    for diagonal in (False, True):
        trial, numbers = np.empty((1, 6)), [np.empty(1) for _ in range(2)]
        damped_steps(
            np.array([0]), (both.T @ both)[None], w[None], free, np.array([mu]),
            np.array([decay]), diagonal, trial, *numbers,
        )  # fmt: skip
        steps = trial - w
        j = jac[:, free]
        scale = np.diag(j.T @ j) if diagonal else np.ones(4)
        matrix = j.T @ j + decay * np.eye(4) + mu * np.diag(scale)
        expected = np.linalg.solve(matrix, -(j.T @ r + decay * w[free]))
        np.testing.assert_allclose(steps[0, free], expected)
        assert not steps[0, [1, 4]].any()
        # the decrease that the quadratic model promises
        s = expected
        model = (j.T @ r + decay * w[free]) @ s + 0.5 * s @ (j.T @ j + decay * np.eye(4)) @ s
        np.testing.assert_allclose(numbers[0][0], -model)


def test_codes():
    inputs, targets = signals()
    fit = one_step_fit(inputs, targets)
    start = random_starts(1, np.random.default_rng(0))
    few = levenberg_marquardt(fit, start, Options(Stopping(max_evaluations=2)))
    assert few.codes == [ResultCode.EVALUATIONS]
    assert few.n_evaluations[0] == 2
    low = levenberg_marquardt(fit, start, Options(Stopping(squares=1e-2 * fit.n_residuals)))
    assert low.codes == [ResultCode.COST]
    stalled = levenberg_marquardt(
        fit, start, Options(Stopping(max_evaluations=500, cost_change=1e-2))
    )
    assert stalled.codes == [ResultCode.COST_CHANGE]
    lost = levenberg_marquardt(fit, np.full((1, 19), np.nan))
    assert lost.codes == [ResultCode.NOT_FINITE]
    exact = levenberg_marquardt(Curve(), [1.0, 1.0])
    assert exact.codes[0] in (ResultCode.GRADIENT, ResultCode.DAMPING)
    assert exact.n_evaluations[0] < 100


def test_bayesian_regularisation():
    # few, so that the effective number of weights matters beside them
    inputs, targets = signals(60, noise=0.05)
    fit = one_step_fit(inputs, targets)
    starts = random_starts(2, np.random.default_rng(0))
    options = Options(Stopping(max_evaluations=300), bayesian=True)
    for start in starts:
        end = levenberg_marquardt(fit, start, options)
        # the fixed point of MacKay's rule: decay = gamma E_D / (E_W (N - gamma))
        products = fit.products(end.weights)[0]
        jtj = np.tril(products[:-1, :-1])
        jtj = jtj + np.tril(jtj, -1).T
        decay = end.weight_decay[0]
        gamma = 19 - decay * np.trace(np.linalg.inv(jtj + decay * np.eye(19)))
        rule = gamma * products[-1, -1] / ((end.weights**2).sum() * (fit.n_residuals - gamma))
        np.testing.assert_allclose(decay, rule, rtol=1e-3)
        # what is minimised: half the squares and half the weight decay
        both = 0.5 * products[-1, -1] + 0.5 * decay * (end.weights**2).sum()
        np.testing.assert_allclose(end.history["cost"][-1, 0], both)
        assert 0 < gamma < 19


class Told:
    """Given costs, one after another, with a gradient and a curvature that stay."""

    n_weights, n_residuals = 2, 9

    def __init__(self, costs, curvature=(4.0, 1.0)):
        self.costs, self.curvature = iter(costs), curvature

    def products(self, weights):
        out = np.zeros((len(weights), 3, 3))
        out[:, [0, 1], [0, 1]], out[:, 2, :2] = self.curvature, 1.0
        out[:, 2, 2] = 2.0 * np.array(next(self.costs))
        return out


@pytest.mark.parametrize(("damping", "unit"), [("diagonal", 1.0), ("identity", 4.0)])
def test_damping_grows_from_a_thousandth_of_the_largest_curvature_until_it_is_useless(
    damping, unit
):
    """Each rejected step in a row doubles the factor of the next increase (Nielsen 1999)."""
    options = Options(damping=damping, bayesian=True)
    end = levenberg_marquardt(Told([10.0, *[20.0] * 99]), [0.5, 0.5], options)
    n = np.arange(10)
    np.testing.assert_allclose(end.history["damping"][:, 0], 1e-3 * unit * 2.0 ** (n * (n + 1) / 2))
    assert end.codes == [ResultCode.DAMPING]  # beyond 1e10
    assert end.n_evaluations[0] == 9
    assert end.weight_decay[0] == 0.0


def test_damping_falls_to_its_smallest_while_steps_do_better_than_predicted():
    end = levenberg_marquardt(Told(np.arange(100.0, 50.0, -1.0)), [0.5, 0.5], Options(Stopping(49)))
    expected = np.maximum(4e-3 / 3.0 ** np.arange(50), 4e-18)
    np.testing.assert_allclose(end.history["damping"][:, 0], expected)


def test_weight_decay_is_chosen_for_the_starts_whose_step_is_accepted():
    options = Options(Stopping(1), bayesian=True)
    end = levenberg_marquardt(Told([[10.0, 10.0], [9.0, 20.0]]), [[0.5, 0.5]] * 2, options)
    assert end.weight_decay[0] > 0.0 == end.weight_decay[1]


def test_without_curvature_the_first_damping_is_absolute():
    options = Options(Stopping(1))
    end = levenberg_marquardt(Told([1.0, 2.0], (0.0, 0.0)), [0.5, 0.5], options)
    assert end.history["damping"][0, 0] == pytest.approx(1e-3)


def test_held_weights_have_no_part_in_bayesian_regularisation():
    """MacKay's rule for two of three weights of a linear problem."""
    rng = np.random.default_rng(5)
    a = rng.normal(size=(20, 3))
    b = a @ [4.5, 1.0, -2.0] + rng.normal(size=20)

    class Linear:
        n_weights, n_residuals = 3, 20

        def products(self, weights):
            rows = [np.column_stack([a, a @ w - b]) for w in weights]
            return np.array([r.T @ r for r in rows])

    options = Options(Stopping(max_evaluations=300), bayesian=True)
    end = levenberg_marquardt(Linear(), [5.0, 0.3, -0.2], options, trainable=[False, True, True])
    (weights,), (decay,) = end.weights, end.weight_decay
    assert weights[0] == 5.0
    free, errors, squares = a[:, 1:], a @ weights - b, np.sum(weights[1:] ** 2)
    matrix = free.T @ free + decay * np.eye(2)
    gamma = 2.0 - decay * np.trace(np.linalg.inv(matrix))
    rule = gamma * errors @ errors / (squares * (20.0 - gamma))
    np.testing.assert_allclose(decay, rule, rtol=1e-6)
    np.testing.assert_allclose(free.T @ errors + decay * weights[1:], 0.0, atol=1e-6)
    np.testing.assert_allclose(end.cost, 0.5 * errors @ errors)
    both = 0.5 * errors @ errors + 0.5 * decay * squares
    np.testing.assert_allclose(end.history["cost"][-1, 0], both)


def test_a_start_that_stops_before_the_others_has_its_last_cost():
    told = []
    end = levenberg_marquardt(Curve(), [[1.0, 1.0], [-1.2, 1.0]], log=told.append)
    assert end.n_evaluations[0] == 1 < end.n_evaluations[1]
    for start, n in enumerate(end.n_evaluations):
        cost = end.history["cost"][:, start]
        assert np.flatnonzero(np.isfinite(cost)).tolist() == list(range(n + 1))
        assert cost[n] == end.cost[start]
        assert np.isfinite(np.array(told)[:, start]).sum() == n
