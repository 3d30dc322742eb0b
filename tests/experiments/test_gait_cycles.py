from dataclasses import replace

import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.experiments.gait_cycles import gait_cycles
from narx.method import SegmentSignals


@pytest.fixture
def walk(make_walk):
    """Twenty seconds, a contact every second from 0.5 s on, scored from 2 s on."""
    source = SimulatedGait(
        subjects=["S1"], conditions=["normal"], treadmill_duration_s=20, sampling_rate_hz=50,
        segments=["thigh_right", "shank_right"],
    )  # fmt: skip
    (trial,) = source
    knee = make_walk(segment="knee_right")
    contacts = {"heel_strike_right": np.arange(0.5, 20.0)}
    object.__setattr__(trial, "events", contacts)
    return trial, knee


def test_only_cycles_within_the_scored_part_count(walk):
    trial, knee = walk
    cycles = gait_cycles(trial, knee, None)
    # contacts at 2.5, 3.5, ..., 19.5
    assert (cycles.compared, cycles.complete) == (17, 17)


def test_a_hidden_marker_invalidates_only_its_cycle(walk):
    trial, knee = walk
    knee.reference_rad[knee.time_s.searchsorted(10.0)] = np.nan
    cycles = gait_cycles(trial, knee, None)
    assert (cycles.compared, cycles.complete) == (17, 16)


def test_a_sample_belongs_to_the_cycle_that_it_begins(walk):
    """Contacts count from the trial's first sample; one after the end begins no cycle."""
    trial, knee = walk
    object.__setattr__(trial, "events", {"heel_strike_right": [*np.arange(0.5, 20.0), 25.0]})
    knee.reference_rad[knee.time_s.searchsorted(19.5)] = np.nan
    cycles = gait_cycles(trial, knee, None)
    assert (cycles.compared, cycles.complete) == (17, 17)
    knee.reference_rad[knee.time_s.searchsorted(2.2)] = np.nan  # scored, but before a contact
    assert gait_cycles(trial, knee, None) == cycles
    knee.reference_rad[knee.time_s.searchsorted(2.5)] = np.nan
    assert gait_cycles(trial, knee, None).complete == 16
    object.__setattr__(trial, "imus", {
        name: replace(imu, time_s=imu.time_s + 100.0) for name, imu in trial.imus.items()
    })  # fmt: skip
    object.__setattr__(trial, "events", {"heel_strike_right": np.arange(100.5, 120.0)})
    assert gait_cycles(trial, knee, None).complete == 16


def test_contacts_are_found_where_the_trial_does_not_know_them():
    source = SimulatedGait(
        subjects=["S1"], conditions=["normal"], treadmill_duration_s=40, sampling_rate_hz=100,
        segments=["thigh_right", "shank_right"],
    )  # fmt: skip
    (trial,) = source
    from narx.datasets.splits import TrialPart
    from narx.evaluation.trial import evaluate_trial

    calibrated = calibrate(trial)
    part = TrialPart("simulated_gait", trial.subject, trial.condition, trial.trial)
    evaluated, _ = evaluate_trial(trial, calibrated, {}, part, 10.0)
    knee = evaluated[-1]
    known = gait_cycles(trial, knee, calibrated["thigh_right"].signals)
    object.__setattr__(trial, "events", {})
    found = gait_cycles(trial, knee, calibrated["thigh_right"].signals)
    assert abs(known.compared - found.compared) <= 2
    assert known.compared > 20


def test_standing_has_none(make_walk, walk):
    trial, knee = walk
    object.__setattr__(trial, "events", {})
    still = SegmentSignals(
        "thigh_right", 50.0, np.zeros((1000, 3)), np.tile([0, 0, 9.81], (1000, 1))
    )
    assert gait_cycles(trial, knee, still).compared == 0
