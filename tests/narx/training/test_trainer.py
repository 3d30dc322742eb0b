"""A training from a notebook: own arrays, trials, folds, without a configuration."""

import numpy as np
import pytest

from narx import Trainer
from narx.datasets import SimulatedGait, one_window
from narx.errors import UserError
from narx.training import LevenbergMarquardt, MethodTeacher, TrialReader
from narx.windows import from_arrays

QUICK = LevenbergMarquardt(restarts=2, iterations=20)


def swings(duration_s=20.0, rate_hz=100.0, amplitude=0.4):
    """Small swings about two axes, whose rates are the derivatives of the angles."""
    time_s = np.arange(0, duration_s, 1 / rate_hz)
    omega = 2 * np.pi * 0.9
    size = amplitude * np.array([1.0, 0.2, 0.0])
    return omega * np.cos(omega * time_s)[:, None] * size, np.sin(omega * time_s)[:, None] * size


@pytest.fixture(scope="module")
def source():
    return SimulatedGait(treadmill_duration_s=45.0, sampling_rate_hz=100.0)


def best_deg(checkpoint):
    return checkpoint.history["report"]["restarts"]["validation_rmse_best_deg"]


def test_own_arrays_become_a_network_that_follows_them():
    rates, angles = swings()
    checkpoint = Trainer(optimizer=QUICK).fit(from_arrays(rates, angles, 100.0))
    assert best_deg(checkpoint) < 0.3
    assert checkpoint.model.sampling_rate_hz == 100.0
    assert checkpoint.history["trained_on"] == ["arrays"]
    assert checkpoint.error_std_rad is None


def test_several_sequences_train_together():
    own = [
        sequence
        for number, amplitude in enumerate((0.2, 0.5))
        for sequence in from_arrays(*swings(amplitude=amplitude), 100.0, name=f"walk {number}")
    ]
    checkpoint = Trainer(optimizer=QUICK).fit(own)
    assert checkpoint.history["trained_on"] == ["walk 0", "walk 1"]
    assert checkpoint.history["training_s"] == pytest.approx(2 * 0.75 * 20.0)


def test_a_gap_cuts_own_arrays_in_two():
    rates, angles = swings()
    rates[900:910] = np.nan
    first, second = from_arrays(rates, angles, 100.0)
    assert first.signals.n_samples == 900
    assert second.signals.n_samples == len(rates) - 910


def test_a_fold_gives_the_same_as_its_trial(source):
    index = source.index().assign(source="simulated_gait")
    (fold,) = one_window(index, earliest_s=8.0, latest_s=10.0)
    trainer = Trainer(optimizer=QUICK, seed=3)
    seen = []
    by_fold = trainer.fit_fold({"simulated_gait": source}, fold, lambda i, n: seen.append(i))
    again = trainer.fit_fold({"simulated_gait": source}, fold)
    assert best_deg(by_fold) == best_deg(again)
    assert seen
    assert by_fold.history["fold"] == fold.name
    assert by_fold.error_std_rad is not None
    trial = source.load(*fold.training[0].key[1:])
    whole = trainer.fit([trial])
    assert whole.history["training_s"] > by_fold.history["training_s"]
    assert best_deg(whole) < 5.0


def test_the_teacher_is_ours_to_choose(source):
    class Zero:
        def estimate(self, signals):
            return np.zeros((signals.n_samples, 3))

    row = source.index().iloc[0]
    trial = source.load(row.subject, row.condition, row.trial)
    trainer = Trainer(reader=TrialReader(MethodTeacher(Zero())), optimizer=QUICK)
    with pytest.raises(UserError, match="does not vary"):
        trainer.fit([trial])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"held_back": 1.5}, "held_back is 1.5, expected a number from 0 to 0.9"),
        ({"axis_scaling": "foo"}, "axis_scaling is 'foo', expected one of training, own"),
        ({"washout_s": -1.0}, "washout_s"),
    ],
)
def test_values_out_of_range_are_refused_before_the_training(wrong, message):
    with pytest.raises(UserError, match=message):
        Trainer(**wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"skip_s": -1.0}, "skip_s is -1.0"),
        ({"weights": {"simulated_gait": 0.0}}, "weights.simulated_gait is 0.0"),
    ],
)
def test_a_reader_refuses_nonsense(wrong, message):
    with pytest.raises(UserError, match=message):
        TrialReader(**wrong)


def test_wrong_segments_and_parts_are_named(source):
    row = source.index().iloc[0]
    trial = source.load(row.subject, row.condition, row.trial)
    with pytest.raises(UserError, match=r"segments holds 'elbow', .* they have .*thigh_right"):
        Trainer(reader=TrialReader(segments=("elbow",))).fit([trial])
    with pytest.raises(UserError, match=r"lasts 4\d\.\d s, no part of it"):
        Trainer(reader=TrialReader(skip_s=1000.0)).fit([trial])


@pytest.mark.parametrize(
    ("rates", "angles", "rate_hz", "message"),
    [
        (np.zeros((500, 1)), np.zeros((500, 1)), 100.0, r"rates_rad_s has shape \(500, 1\)"),
        (np.zeros((500, 3)), np.zeros((400, 3)), 100.0, r"angles_rad has shape \(400, 3\)"),
        (np.zeros((500, 3)), np.zeros((500, 3)), -1.0, "sampling_rate_hz is -1"),
        (np.full((500, 3), np.inf), np.zeros((500, 3)), 100.0, "infinite at sample 0"),
        (np.zeros((100, 3)), np.zeros((100, 3)), 100.0, "no part of 2 s"),
    ],
)
def test_arrays_that_are_none_are_refused(rates, angles, rate_hz, message):
    with pytest.raises(UserError, match=message):
        from_arrays(rates, angles, rate_hz)


def test_nothing_to_train_on_is_refused():
    with pytest.raises(UserError, match="no sequence"):
        Trainer().fit([])


@pytest.mark.parametrize("training", ["walk", [None], [np.zeros((100, 3))]])
def test_only_trials_and_sequences_are_trained_on(training):
    with pytest.raises(UserError, match=r"^training: found a \w+, expected trials or sequences"):
        Trainer().fit(training)


def test_an_optimiser_is_an_object_not_its_class():
    with pytest.raises(UserError, match=r"class LevenbergMarquardt, .* LevenbergMarquardt\(\)"):
        Trainer(optimizer=LevenbergMarquardt)
