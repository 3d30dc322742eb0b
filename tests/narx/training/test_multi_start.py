"""Many starts: seeded, in threads, bad ones dropped."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.solver import Options
from narx.training.least_squares.stopping import Stopping
from narx.training.multi_start import Stage, multi_start, network_curriculum, normal_starts

DEFAULT = NarxStructure()
SHORT = Options(Stopping(max_evaluations=15))


def signals(n=400):
    time_s = np.arange(n) / 100.0
    v = np.sin(2 * np.pi * 0.9 * time_s) + 0.4 * np.sin(2 * np.pi * 1.8 * time_s + 1.0)
    p = np.zeros(n)
    for k in range(1, n):
        p[k] = 0.97 * p[k - 1] + 0.05 * np.tanh(v[k])
    return torch.from_numpy(v)[:, None], torch.from_numpy(p)


def curriculum(n_samples=300, **options):
    inputs, targets = signals()
    stages = network_curriculum(
        inputs[:n_samples], targets[:n_samples], structure=DEFAULT, options=SHORT, **options
    )
    held_back = targets.clone()
    held_back[:n_samples] = torch.nan
    return stages, NetworkFit(inputs, held_back, structure=DEFAULT)


def test_the_best_by_held_back_samples_is_kept():
    stages, validation = curriculum(horizons=(1, 10, None))
    starts = normal_starts(DEFAULT, 20, np.random.default_rng(0))
    result = multi_start(stages, starts, validation)
    assert [stage.name for stage in stages] == ["open_loop", "horizon_10", "closed_loop"]
    assert validation.n_residuals == 100
    errors = np.sqrt(validation.products(result.all_weights)[:, -1, -1] / 100)
    np.testing.assert_allclose(result.errors, errors)
    assert result.best == np.argmin(errors)
    np.testing.assert_array_equal(result.weights, result.all_weights[result.best])
    spread = result.spread()
    assert spread["min"] == errors.min()
    assert spread["n_starts"] == 20
    history = result.history()
    assert {row["stage"] for row in history} == {0.0, 1.0, 2.0}
    assert all(np.isfinite(row["cost"]) for row in history)


def test_the_same_seed_gives_the_same_weights_with_any_number_of_threads():
    stages, validation = curriculum(horizons=(1, None))
    threads = torch.get_num_threads()
    results = []
    try:
        for n in (1, 2, 3):
            torch.set_num_threads(n)
            starts = normal_starts(DEFAULT, 35, np.random.default_rng(7))
            results.append(multi_start(stages, starts, validation).all_weights)
    finally:
        torch.set_num_threads(threads)
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])


def test_starts_that_diverge_are_dropped_and_counted():
    stages, validation = curriculum(horizons=(None,))
    starts = normal_starts(DEFAULT, 5, np.random.default_rng(0))
    starts[1] = np.nan
    starts[3] = np.inf
    result = multi_start(stages, starts, validation)
    assert result.n_dropped == 2
    assert result.best not in (1, 3)
    with pytest.raises(UserError, match="none of 1 starts"):
        multi_start(stages, starts[1:2], validation)


def test_odd_networks_stay_odd():
    stages, validation = curriculum(horizons=(1, None))
    starts = normal_starts(DEFAULT, 4, np.random.default_rng(0), odd=True)
    held = starts[0] == 0.0
    result = multi_start(stages, starts, validation, trainable=~held)
    assert not result.all_weights[:, held].any()


def test_stages_of_one_option_each():
    inputs, targets = signals()
    options = [SHORT, Options(Stopping(max_evaluations=3))]
    stages = network_curriculum(
        inputs, targets, structure=DEFAULT, horizons=(1, None), options=options
    )
    assert [stage.options for stage in stages] == options
    assert isinstance(stages[0], Stage)
    with pytest.raises(ValueError, match="horizon"):
        network_curriculum(inputs, targets, structure=DEFAULT, horizons=(0,))
