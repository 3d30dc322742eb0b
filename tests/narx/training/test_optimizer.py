"""What optimizers have in common: starts, the choice among them, and the report."""

import numpy as np
import pytest
import torch

from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.batch import Batch
from narx.training.gradient import Lbfgs
from narx.training.levenberg_marquardt import LevenbergMarquardt
from narx.training.objective import Objective
from narx.training.optimizer import spread_report, starts_of


def batch(model, seed, n_samples):
    rng = np.random.default_rng(seed)
    rates, targets = rng.normal(size=(2, n_samples, 3)), 0.1 * rng.normal(size=(2, n_samples, 3))
    return Batch(
        torch.from_numpy(rates),
        torch.from_numpy(targets),
        torch.zeros(2, 3, model.structure.n_state, dtype=torch.float64),
        torch.from_numpy(0.05 * rng.normal(size=(2, 3))),
        torch.tensor([3.0, 0.5], dtype=torch.float64),
    )


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("optimizer", [Lbfgs, LevenbergMarquardt])
def test_the_best_start_is_that_of_the_least_error_on_held_out_samples(optimizer, coupled):
    """In degrees, by the weights of sequences and axes; the network has the weights of the best."""
    model = Narx(20.0, Normalisation(2.0, 0.3), None, coupled=coupled)
    training, held_out = batch(model, 0, 60), batch(model, 1, 40)
    objective = Objective((1.0, 0.25, 0.0), offset_free=False)
    report = optimizer(restarts=3, iterations=3).fit(
        model, training, held_out, objective, np.random.default_rng(0), lambda *_: None
    )
    with torch.no_grad():
        angles, _ = model(held_out.rates_rad_s, held_out.state, held_out.posture_rad)
    squares = torch.rad2deg(angles - held_out.targets_rad).numpy() ** 2
    weights = np.multiply.outer([3.0, 0.5], [1.0, 0.25, 0.0])[:, None] * np.ones_like(squares)
    rmse_deg = np.sqrt(np.sum(weights * squares) / weights.sum())
    assert report.restarts["restarts"] == 3.0
    assert report.restarts["validation_rmse_best_deg"] == pytest.approx(rmse_deg, rel=1e-9)
    assert rmse_deg <= report.restarts["validation_rmse_median_deg"]


def test_the_spread_of_restarts_is_that_of_the_finite_ones():
    assert spread_report(np.array([4.0, np.nan, 1.0, 2.0, 9.0, np.inf])) == {
        "restarts": 6.0,
        "dropped": 2.0,
        "validation_rmse_best_deg": 1.0,
        "validation_rmse_median_deg": 3.0,
        "validation_rmse_worst_deg": 9.0,
    }


def test_a_trained_network_goes_on_in_the_last_stage():
    model = Narx(20.0, Normalisation(2.0, 0.3))
    own = np.arange(19.0)
    starts, stages = starts_of(model, np.random.default_rng(0), 4, ("open", 5, "closed"), own)
    np.testing.assert_array_equal(starts, own[None])
    assert list(stages) == ["closed"]
    starts, stages = starts_of(model, np.random.default_rng(0), 4, ("open", "closed"), None)
    assert starts.shape == (4, 19)
    assert list(stages) == ["open", "closed"]


def test_every_evaluation_of_every_start_and_stage_is_counted():
    """The first of a start in a stage, and one for each of three iterations."""
    model = Narx(20.0, Normalisation(2.0, 0.3))
    training, held_out = batch(model, 0, 60), batch(model, 1, 40)
    optimizer = LevenbergMarquardt(2, 3, ("open", "closed"), cost_change=0.0)
    report = optimizer.fit(
        model, training, held_out, Objective(), np.random.default_rng(0), lambda *_: None
    )
    assert report.evaluations == 2 * 2 * (1 + 3)


@pytest.mark.parametrize(
    ("limit", "code"),
    [
        ({"gradient": 1e9}, "gradient is small"),
        ({"step": 1e3}, "step is small"),
        ({"cost_change": 0.99}, "cost no longer falls"),
    ],
)
def test_each_limit_of_levenberg_marquardt_ends_it_for_its_own_reason(limit, code):
    model = Narx(20.0, Normalisation(2.0, 0.3))
    training, held_out = batch(model, 0, 60), batch(model, 1, 40)
    optimizer = LevenbergMarquardt(1, 20, ("closed",), **{"cost_change": 0.0} | limit)
    report = optimizer.fit(
        model, training, held_out, Objective(), np.random.default_rng(0), lambda *_: None
    )
    assert report.code == code
