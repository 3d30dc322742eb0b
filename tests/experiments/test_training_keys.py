"""Every key of solver and training in a configuration reaches its parameter."""

import numpy as np
import pytest
from hydra import compose, initialize_config_module

from narx.errors import UserError
from narx.experiments.configuration import checked_configuration
from narx.experiments.networks import trainer
from narx.inference.checkpoint import save
from narx.windows import from_arrays

TIME_S = np.arange(0.0, 20.0, 0.01)
QUICK = ("optimizer.restarts=2", "optimizer.iterations=20")


def walk(lag_s=0.0):
    """Angles of a swing that are late by `lag_s`, and its rates."""
    omega = 2 * np.pi * 0.9
    angles = 0.4 * np.sin(omega * (TIME_S - lag_s))[:, None] * [1.0, 0.2, 0.0]
    rates = 0.4 * omega * np.cos(omega * TIME_S)[:, None] * [1.0, 0.2, 0.0]
    return from_arrays(rates, angles, 100.0)


def configured(*overrides):
    with initialize_config_module("narx.configs", version_base="1.3"):
        cfg = compose("train", overrides=[*QUICK, *overrides])
    return trainer(checked_configuration(cfg, "train"))


def fitted(*overrides, sequences=None):
    return configured(*overrides).fit(sequences or walk())


def report(checkpoint):
    return checkpoint.history["report"]


@pytest.mark.parametrize(
    ("override", "code"),
    [
        ("optimizer.gradient=1e9", "gradient is small"),
        ("optimizer.step=1e3", "step is small"),
        ("optimizer.cost_change=1", "cost no longer falls"),
        ("optimizer.cost_deg2=1e6", "cost is low enough"),
        ("optimizer.iterations=2", "all evaluations are used"),
    ],
)
def test_each_limit_stops_a_start_for_its_own_reason(override, code):
    ended = report(fitted(override))
    assert ended["code"] == code
    assert ended["iterations"] < report(fitted())["iterations"]


def test_damping_and_regularisation_change_the_way():
    ways = [(), ("optimizer.damping=identity",), ("optimizer.bayesian=true",)]
    weights = [fitted(*way).model.weights.detach().numpy() for way in ways]
    assert not np.allclose(weights[0], weights[1], rtol=1e-6)
    assert not np.allclose(weights[0], weights[2], rtol=1e-6)


def test_a_training_continues_from_a_checkpoint(tmp_path):
    path = tmp_path / "first.pt"
    first = fitted("optimizer.iterations=2")
    save(first, path)
    again = fitted(f"training.start={path}", "optimizer.iterations=0")
    np.testing.assert_array_equal(again.model.weights.detach(), first.model.weights.detach())
    assert report(again)["restarts"]["restarts"] == 1
    further = fitted(f"training.start={path}")
    costs = [row["cost_deg2"] for row in report(further)["history"]]
    assert costs[-1] < costs[0]
    # the last stage alone
    assert {row["stage"] for row in report(further)["history"]} == {0.0}


def test_a_checkpoint_that_is_not_there_is_one_line_before_the_training(tmp_path):
    with pytest.raises(UserError, match=r"nowhere\.pt"):
        configured(f"training.start={tmp_path / 'nowhere.pt'}")


def test_a_late_target_is_brought_back_unless_it_is_to_stay():
    late = walk(0.008)
    errors = {}
    for align in ("true", "false"):
        network = fitted(f"training.align_clock={align}", sequences=late)
        estimate = network.method().estimate(walk()[0].signals)
        truth = walk()[0].target_rad
        errors[align] = np.degrees((estimate - truth)[1000:, 0].std())
    # 8 ms of a swing of 23 degrees with 0.9 Hz are 0.73 degrees
    assert errors["true"] < 0.2
    assert errors["false"] > 0.4


def test_axes_that_are_not_coupled_need_no_second_key():
    network = fitted("model.coupled=no")
    assert not network.model.coupled
    with pytest.raises(UserError, match=r"offset_free=true needs model\.coupled=true"):
        configured("model.coupled=no", "model.objective.offset_free=true")


def test_a_washout_longer_than_the_data_is_refused_before_the_first_step():
    steps = []
    with pytest.raises(UserError, match=r"no sample .* counts; .*washout_s is 1000 s"):
        configured("model.objective.washout_s=1000").fit(
            walk(), log=lambda iteration, numbers: steps.append(iteration)
        )
    assert not steps
