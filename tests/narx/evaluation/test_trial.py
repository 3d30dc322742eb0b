"""Which samples of a trial are scored, which methods ran, and which were not applicable."""

import numpy as np
import pytest

from narx.calibration.calibrate import CalibratedSegment
from narx.datasets.splits import TrialPart
from narx.errors import MethodNotApplicableError, UserError
from narx.evaluation.trial import evaluate_trial
from narx.evaluation.workload import Workload
from narx.kinematics.segment_angles import orientation_from_angles
from narx.method import Estimate, OrientationMethod, SegmentSignals
from narx.recordings.trial import ImuRecording, Trial

N, RATE_HZ = 41, 10.0
ANGLES = np.linspace(0.0, 0.4, N)[:, None] * [1.0, 0.5, 0.25]
ZEROS = np.zeros((N, 3))


def _trial(**changes):
    time = 100.0 + np.arange(N) / RATE_HZ
    imus = {"thigh_right": ImuRecording("thigh_right", time, ZEROS, ZEROS)}
    return Trial("d", "S1", "slow", "1", RATE_HZ, imus, **changes)


def _segment(name="thigh_right", factor=1.0, reference=True):
    wxyz = orientation_from_angles(factor * ANGLES)
    return CalibratedSegment(
        SegmentSignals(name, RATE_HZ, ZEROS, ZEROS, None),
        wxyz if reference else None,
        factor * ANGLES if reference else None,
        None,
        np.zeros(3),
        (),
    )


def _refuses(signals):
    raise MethodNotApplicableError(f"nothing to do with {signals.segment}")


class _Method(OrientationMethod):
    def __init__(self, run):
        self.run = run

    def _estimate(self, signals):
        raise NotImplementedError


METHODS = {
    "good": _Method(lambda signals: Estimate(ANGLES - 0.01, ANGLES * 0 + 0.02)),
    "other": _Method(_refuses),
}


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"skip_s": float("nan")}, "skip_s is nan, expected a number"),
        ({"skip_s": -1.0}, "skip_s is -1.0, expected a number from 0"),
        ({"scored_rate_hz": 0.0}, "scored_rate_hz is 0.0, expected a number above 0"),
        ({"scored_rate_hz": float("nan")}, "scored_rate_hz is nan, expected"),
        ({"methods": {"zero": "zero"}}, "methods.zero is 'zero', expected OrientationMethod"),
        ({"trial": None}, "trial is null, expected Trial"),
    ],
)
def test_impossible_arguments_are_refused(option, said):
    part = TrialPart("d", "S1", "slow", "1")
    arguments = {"trial": _trial(), "calibrated": {"thigh_right": _segment()}, "methods": METHODS,
                 "part": part, "skip_s": 0.0}  # fmt: skip
    with pytest.raises(UserError, match=rf"^evaluate_trial: {said}"):
        evaluate_trial(**arguments | option)


@pytest.mark.parametrize(
    ("part", "skip_s", "scored_from", "scored_to"),
    [((0.0, float("inf")), 0.0, 0, 41), ((1.0, 2.0), 0.5, 10, 20), ((1.0, 2.0), 1.5, 15, 20)],
)
def test_a_part_is_scored_from_its_start_to_before_its_end(part, skip_s, scored_from, scored_to):
    part = TrialPart("d", "S1", "slow", "1", *part)
    segments = {"thigh_right": _segment()}
    (found,), refusals = evaluate_trial(_trial(), segments, METHODS, part, skip_s)
    assert np.flatnonzero(found.scored).tolist() == list(range(scored_from, scored_to))
    assert found.time_s[[0, -1]].tolist() == [0.0, 4.0]
    np.testing.assert_array_equal(found.reference_rad, ANGLES)
    assert list(found.estimates_rad) == list(found.std_rad) == ["good"]
    (refusal,) = refusals
    assert (refusal.method, refusal.segment) == ("other", "thigh_right")
    assert refusal.reason == "nothing to do with thigh_right"


def test_samples_that_the_source_leaves_out_are_not_scored():
    scored = np.arange(N) % 2 == 0
    part = TrialPart("d", "S1", "slow", "1")
    workload = Workload()
    (found,), _ = evaluate_trial(
        _trial(scored=scored), {"thigh_right": _segment(reference=False)}, METHODS, part, 0.3,
        workload,
    )  # fmt: skip
    assert np.flatnonzero(found.scored).tolist() == list(range(4, N, 2))
    assert np.isnan(found.reference_rad).all()
    assert set(workload.methods_s) == {"good", "other"}


def test_two_segments_of_a_leg_make_a_knee_where_both_have_a_reference():
    part = TrialPart("d", "S1", "slow", "1")
    segments = {"thigh_right": _segment(), "shank_right": _segment("shank_right", -1.0)}
    found, _ = evaluate_trial(_trial(), segments, METHODS, part, 0.0)
    assert [one.segment for one in found] == ["thigh_right", "shank_right", "knee_right"]
    # flexion is the thigh's angle less the shank's, up to the small other angles
    np.testing.assert_allclose(found[2].reference_rad[:, 0], 2 * ANGLES[:, 0], atol=0.02)
    np.testing.assert_allclose(found[2].std_rad["good"], 0.02 * np.sqrt(2))
    segments["shank_right"] = _segment("shank_right", -1.0, reference=False)
    found, _ = evaluate_trial(_trial(), segments, METHODS, part, 0.0)
    assert [one.segment for one in found] == ["thigh_right", "shank_right"]
