"""Multi-start training: seeded, threaded, failed starts dropped."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.experiments.speed.task import open_then_closed, random_starts
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.solver import Options
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import multi_start
from narx.training.stages import Stage

DEFAULT = NarxStructure()
SHORT = Options(Stopping(max_evaluations=15))


def signals(n=400):
    time_s = np.arange(n) / 100.0
    v = np.sin(2 * np.pi * 0.9 * time_s) + 0.4 * np.sin(2 * np.pi * 1.8 * time_s + 1.0)
    p = np.zeros(n)
    for k in range(1, n):
        p[k] = 0.97 * p[k - 1] + 0.05 * np.tanh(v[k])
    return torch.from_numpy(v)[:, None], torch.from_numpy(p)


def curriculum(n_samples=300, horizon=None):
    inputs, targets = signals()
    stages = open_then_closed(inputs[:n_samples, 0].numpy(), targets[:n_samples].numpy())
    if horizon is not None:
        fit = NetworkFit(
            inputs[:n_samples], targets[:n_samples], structure=DEFAULT, horizon=horizon
        )
        stages.insert(1, Stage("ahead", fit, 1.0 / fit.total_weight))
    held_back = targets.clone()
    held_back[:n_samples] = torch.nan
    return stages, NetworkFit(inputs, held_back, structure=DEFAULT)


def test_the_best_by_held_back_samples_is_kept():
    stages, validation = curriculum(horizon=10)
    starts = random_starts(20, np.random.default_rng(0))
    result = multi_start(stages, starts, validation, SHORT)
    assert [stage.name for stage in stages] == ["open", "ahead", "closed"]
    assert validation.n_residuals == 100
    errors = np.sqrt(validation.products(result.all_weights)[:, -1, -1] / 100)
    np.testing.assert_allclose(result.errors, errors)
    assert result.best == np.argmin(errors)
    np.testing.assert_array_equal(result.weights, result.all_weights[result.best])
    history = result.history(stages)
    assert {row["stage"] for row in history} == {0.0, 1.0, 2.0}
    assert all(np.isfinite(row["cost_deg2"]) for row in history)
    last = stages[-1].problem.products(result.weights[None])[0, -1, -1]
    assert history[-1]["cost_deg2"] == pytest.approx(last / stages[-1].problem.total_weight)


@pytest.mark.concurrency
def test_the_same_seed_gives_the_same_weights_with_any_number_of_threads():
    stages, validation = curriculum()
    threads = torch.get_num_threads()
    results = []
    try:
        for n in (1, 2, 3):
            torch.set_num_threads(n)
            starts = random_starts(35, np.random.default_rng(7))
            results.append(multi_start(stages, starts, validation, SHORT).all_weights)
    finally:
        torch.set_num_threads(threads)
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])


def test_starts_that_diverge_are_dropped_and_counted():
    stages, validation = curriculum()
    starts = random_starts(5, np.random.default_rng(0))
    starts[1] = np.nan
    starts[3] = np.inf
    result = multi_start(stages, starts, validation, SHORT)
    assert result.n_dropped == 2
    assert result.best not in (1, 3)
    with pytest.raises(UserError, match="none of 1 starts"):
        multi_start(stages, starts[1:2], validation, SHORT)


def test_odd_networks_stay_odd():
    stages, validation = curriculum()
    starts = random_starts(4, np.random.default_rng(0))
    held = np.zeros(DEFAULT.n_weights, dtype=bool)
    held[DEFAULT.b1] = held[DEFAULT.b2] = True
    starts[:, held] = 0.0
    result = multi_start(stages, starts, validation, SHORT, trainable=~held)
    assert not result.all_weights[:, held].any()


def test_a_horizon_that_is_none_is_refused():
    inputs, targets = signals()
    with pytest.raises(ValueError, match="horizon"):
        NetworkFit(inputs, targets, structure=DEFAULT, horizon=0)


def test_every_iteration_is_logged_with_the_costs_of_all_starts():
    stages, validation = curriculum()
    starts = random_starts(20, np.random.default_rng(0))
    told = []
    result = multi_start(
        stages,
        starts,
        validation,
        SHORT,
        log=lambda first, cost, factor: told.append((first, 2 * cost * factor)),
    )
    groups = {first for first, _ in told}
    assert groups == {0, 16}
    assert all(len(cost) == (16 if first == 0 else 4) for first, cost in told)
    of_first = [cost[0] for first, cost in told if first == 0]
    history = [row["cost_deg2"] for row in result.history(stages, 0)]
    # the history holds the cost before each iteration as well
    assert {float(cost) for cost in of_first if np.isfinite(cost)} <= set(history)


def test_starts_that_end_a_stage_in_the_same_minimum_are_trained_as_one():
    stages, validation = curriculum()
    starts = random_starts(3, np.random.default_rng(0))
    twice = np.concatenate([starts, starts[::-1]])
    told = []
    result = multi_start(
        stages,
        twice,
        validation,
        SHORT,
        structure=DEFAULT,
        log=lambda first, cost, factor: told.append(cost),
    )
    apart = multi_start(stages, starts, validation, SHORT)
    np.testing.assert_allclose(result.errors, np.concatenate([apart.errors, apart.errors[::-1]]))
    assert all(len(cost) == 6 and np.isnan(cost[3:]).all() for cost in told)
    (of_last,) = result.stages["closed"]
    assert len(of_last.weights) == 3
    np.testing.assert_array_equal(result.rows[-1], [0, 1, 2, 2, 1, 0])
    costs = [[row["cost_deg2"] for row in result.history(stages, start)] for start in (0, 5)]
    assert costs[0] == costs[1]
    assert result.code is of_last.codes[result.best]


def test_a_start_ends_a_stage_as_soon_as_its_mean_square_is_low_enough():
    stages, validation = curriculum()
    starts = random_starts(1, np.random.default_rng(0))
    free = multi_start(stages, starts, validation, SHORT).history(stages)
    costs = [row["cost_deg2"] for row in free if row["stage"] == 0.0]
    limit = np.sqrt(costs[0] * costs[-1])
    result = multi_start(stages, starts, validation, SHORT, low_enough=limit)
    ended = [row["cost_deg2"] for row in result.history(stages) if row["stage"] == 0.0]
    assert ended[-1] <= limit < ended[-2]
    assert len(ended) < len(costs)


def test_each_stage_of_a_start_ends_with_its_cost_however_long_the_others_take():
    stages, validation = curriculum()
    starts = random_starts(4, np.random.default_rng(0))
    options = Options(Stopping(max_evaluations=15, cost_change=0.3))
    result = multi_start(stages, starts, validation, options)
    assert len(set(result.stages["closed"][0].n_evaluations)) > 1
    for start in range(4):
        history = result.history(stages, start)
        assert np.isfinite([row["cost_deg2"] for row in history]).all()
        squares = stages[-1].problem.products(result.all_weights[start][None])[0, -1, -1]
        assert history[-1]["cost_deg2"] == pytest.approx(squares * stages[-1].mean_square)
