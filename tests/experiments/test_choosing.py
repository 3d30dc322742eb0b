"""Parameters are chosen on the training part only."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from narx.baselines.leaky_integrator import LeakyIntegrator
from narx.datasets.splits import Fold, TrialPart
from narx.experiments.choosing import TrainingPart, choose_parameters

LEAKS = [0.05, 0.5, 2.0]
SETTINGS = {"_target_": "narx.baselines.leaky_integrator.LeakyIntegrator"}
BOTH = (1.0, 1.0, 0.0)


def part(trial, start_s=0.0, stop_s=np.inf):
    return TrialPart("source", "subject", "condition", trial, start_s, stop_s)


@pytest.fixture
def prepare(motion):
    """Trial '2.0' is what a leak of 2 rad/s makes of the walk, and so on; late, all is spoiled."""
    walk = motion("walking", duration_s=60.0)

    def prepared(wanted):
        angles = LeakyIntegrator(float(wanted.trial)).estimate(walk.signals)
        angles[4000:] = 9.0
        segment = SimpleNamespace(signals=walk.signals, reference_angles_rad=angles)
        return SimpleNamespace(time_s=walk.time_s, scored=None), {"thigh_right": segment}

    return prepared


def chosen(fold, prepare):
    training = TrainingPart(fold, prepare, 5.0)
    return choose_parameters(SETTINGS, {"leak_rad_s": LEAKS}, training, BOTH, offset_free=False)


@pytest.mark.parametrize("leak", LEAKS)
def test_the_best_on_the_training_part_is_taken(prepare, leak):
    fold = Fold("f", (part(str(leak), 5.0, 30.0),), (part("0.7"),), (part(str(leak), 30.0, 40.0),))
    assert chosen(fold, prepare) == {"leak_rad_s": leak}


def test_the_test_part_and_later_samples_have_no_influence(prepare):
    seen = []

    def watching(wanted):
        seen.append(wanted.trial)
        trial, calibrated = prepare(wanted)
        signals = calibrated["thigh_right"].signals
        spoiled = signals.axis_rates_rad_s.copy()
        spoiled[3000:] = 50.0
        calibrated["thigh_right"].signals = replace(signals, axis_rates_rad_s=spoiled)
        return trial, calibrated

    fold = Fold("f", (part("0.5", 5.0, 30.0),), (part("2.0"),))
    assert chosen(fold, watching) == {"leak_rad_s": 0.5}
    assert seen == ["0.5"]


def test_the_error_is_the_mean_over_trials(prepare):
    fold = Fold("f", (part("0.5", 5.0, 30.0), part("2.0", 5.0, 30.0)), ())
    training = TrainingPart(fold, prepare, 5.0)
    alone = [
        TrainingPart(Fold("f", (one,), ()), prepare, 5.0).error_rad(
            LeakyIntegrator(0.5), BOTH, False
        )
        for one in fold.training
    ]
    assert alone[0] == pytest.approx(0.0, abs=1e-12)
    assert training.error_rad(LeakyIntegrator(0.5), BOTH, False) == pytest.approx(np.mean(alone))


def test_offset_free_takes_the_mean_error_off(prepare):
    def shifted(wanted):
        trial, calibrated = prepare(wanted)
        calibrated["thigh_right"].reference_angles_rad += 0.3
        return trial, calibrated

    fold = Fold("f", (part("0.5", 5.0, 30.0),), ())
    for offset_free, expected in ((True, 0.0), (False, 0.3)):
        error_rad = TrainingPart(fold, shifted, 5.0).error_rad(
            LeakyIntegrator(0.5), BOTH, offset_free
        )
        assert error_rad == pytest.approx(expected, abs=1e-9)


def error_rad(prepare, *parts, weights=BOTH, validation=()):
    training = TrainingPart(Fold("f", parts, (), validation), prepare, 5.0)
    return training.error_rad(LeakyIntegrator(0.5), weights, False)


def test_whole_turns_are_not_errors(prepare):
    def turned(wanted):
        trial, calibrated = prepare(wanted)
        calibrated["thigh_right"].reference_angles_rad += 2.0 * np.pi + 0.1
        return trial, calibrated

    assert error_rad(turned, part("0.5", 5.0, 30.0)) == pytest.approx(0.1)


def test_only_scored_samples_of_the_parts_count(prepare):
    """Spoiled before 5 s, from 20 to 25 s, and where the trial says so."""

    def spoiled(wanted):
        trial, calibrated = prepare(wanted)
        angles = calibrated["thigh_right"].reference_angles_rad
        wrong = (trial.time_s < 5.0) | ((trial.time_s >= 20.0) & (trial.time_s < 25.0))
        wrong |= (trial.time_s >= 10.0) & (trial.time_s < 11.0)
        angles[wrong] += 1.0
        trial.scored = (trial.time_s < 10.0) | (trial.time_s >= 11.0)
        return trial, calibrated

    parts = part("0.5", 0.0, 20.0), part("0.5", 25.0, 30.0)
    assert error_rad(spoiled, *parts) == pytest.approx(0.0, abs=1e-12)


def test_the_part_for_validation_is_training_too(prepare):
    one, other = part("0.5", 5.0, 30.0), part("2.0", 5.0, 30.0)
    assert error_rad(prepare, one, validation=(other,)) == error_rad(prepare, one, other)


def test_the_weight_of_an_axis_multiplies_its_square(prepare):
    one = part("2.0", 5.0, 30.0)
    once = error_rad(prepare, one, weights=(1.0, 0.0, 0.0))
    assert error_rad(prepare, one, weights=(9.0, 0.0, 0.0)) == pytest.approx(3.0 * once)


def test_without_a_reference_nothing_is_chosen(prepare):
    def blind(wanted):
        trial, calibrated = prepare(wanted)
        calibrated["thigh_right"].reference_angles_rad = None
        return trial, calibrated

    fold = Fold("f", (part("0.5"),), ())
    assert not TrainingPart(fold, blind, 5.0)
    assert chosen(fold, blind) == {}


def test_the_heading_leak_is_chosen_with_the_offset_that_a_drift_leaves(motion):
    """A drift of 0.5 deg/s with a leak of 0.05 rad/s is an offset of 10 degrees."""
    walk = motion("walking", duration_s=120.0)
    rates = walk.signals.axis_rates_rad_s.copy()
    rates[:, 2] += np.radians(0.5)
    signals = replace(walk.signals, axis_rates_rad_s=rates)
    segment = SimpleNamespace(signals=signals, reference_angles_rad=walk.angles_rad)
    fold = Fold("f", (part("1", 60.0, 120.0),), ())
    trial = SimpleNamespace(time_s=walk.time_s, scored=None)
    training = TrainingPart(fold, lambda wanted: (trial, {"thigh_right": segment}), 5.0)
    settings = {"_target_": "narx.baselines.madgwick.Madgwick", "heading": "leak"}
    grid = {"heading_leak_rad_s": [0.05, 0.5]}
    assert choose_parameters(settings, grid, training, (0.0, 0.0, 1.0), offset_free=False) == {
        "heading_leak_rad_s": 0.5
    }
