"""The knee constrains the headings of both sensors of a leg."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import LEG_HEADING_SD_DEG, calibrate
from narx.calibration.knee import ABDUCTION_DEG, _first_steps, _integrated, knee_headings
from narx.calibration.walking import HEADING_SD_DEG
from narx.datasets.simulated_gait import SimulatedGait
from narx.kinematics.joint_angles import orientation_from_joint_angles
from narx.kinematics.segment_angles import axis_rates, mirror_angular_rate, orientation_from_angles
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, Trial

_RATE_HZ = 100.0
_STAND_S = 2.0
_TIME_S = np.arange(0.0, 20.0, 1.0 / _RATE_HZ)


def _leg(abduction_per_flexion=0.0):
    """Orientations of thigh and shank of a right leg that stands, then walks."""
    phase = 2 * np.pi * 0.9 * np.maximum(_TIME_S - _STAND_S, 0.0)
    ramp = np.clip((_TIME_S - _STAND_S) / 2.0, 0.0, 1.0)[:, None]
    # the thigh's angular rate is skewed as in gait: the forward swing is faster
    hip = np.column_stack(
        [20 * np.sin(phase + 0.35 * np.sin(phase)), 3 * np.sin(phase + 1), 4 * np.sin(phase + 2)]
    )
    flexion = 20 - 12 * np.cos(phase + 0.6) - 18 * np.cos(2 * phase - 0.5)
    knee = np.column_stack([flexion, abduction_per_flexion * flexion, 0 * flexion])
    thigh = orientation_from_angles(np.radians(ramp * hip))
    shank = orientation_from_joint_angles(np.radians(ramp * knee), thigh)
    return [Rotation.from_quat(q, scalar_first=True) for q in (thigh, shank)]


def _rates(orientation):
    """Angular rate in the moving frame, at the samples."""
    rate = (orientation[:-1].inv() * orientation[1:]).as_rotvec() * _RATE_HZ
    return np.vstack([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])


def _faced(orientation, error_deg):
    """Axis rates of a segment whose frame is rotated by an angle about z."""
    turn = Rotation.from_euler("Z", -error_deg, degrees=True)
    return axis_rates(turn.apply(_rates(orientation)))


def test_a_rate_that_rises_is_integrated_by_its_mean_between_samples():
    """From rest at 2 rad/s^2 about one axis for 1 s: exactly 1 rad, not 0.98 or 1.02."""
    rates = np.zeros((51, 3))
    rates[:, 0] = 2.0 * np.arange(51) / 50.0
    turned = _integrated(rates, 50.0)
    assert (turned[0].inv() * turned[-1]).magnitude() == pytest.approx(1.0, abs=1e-9)


@settings(max_examples=8, deadline=None)
@given(thigh_deg=st.floats(-12, 12), shank_deg=st.floats(-12, 12))
def test_a_hinge_tells_both_headings(thigh_deg, shank_deg):
    thigh, shank = _leg()
    turns = knee_headings(
        _faced(thigh, thigh_deg), _faced(shank, shank_deg), _RATE_HZ, heading_sd_deg=(1e3, 1e3)
    )
    np.testing.assert_allclose(np.degrees(turns), [thigh_deg, shank_deg], atol=0.3)


def test_headings_are_as_good_at_other_rates():
    thigh, shank = (_faced(o, e) for o, e in zip(_leg(), (6.0, -4.0), strict=True))
    slow = knee_headings(thigh[::2], shank[::2], _RATE_HZ / 2, HEADING_SD_DEG)
    np.testing.assert_allclose(
        slow, knee_headings(thigh, shank, _RATE_HZ, HEADING_SD_DEG), atol=np.radians(0.3)
    )


def test_the_less_certain_heading_is_rotated():
    thigh, shank = _leg()
    signals = _faced(thigh, 5.0), _faced(shank, 5.0), _RATE_HZ
    turns = np.degrees(knee_headings(*signals, heading_sd_deg=(1e-3, 1e3)))
    assert abs(turns[0]) < 0.01
    assert turns[1] == pytest.approx(5.0, abs=4.0)
    assert np.abs(knee_headings(*signals, heading_sd_deg=(1e-3, 1e-3))).max() < 1e-4


def test_true_knee_abduction_is_preserved():
    # the result minimises the cost in the docstring of `knee_headings`
    thigh, shank = _leg(abduction_per_flexion=0.1)
    exact = knee_headings(_faced(thigh, 0.0), _faced(shank, 0.0), _RATE_HZ, HEADING_SD_DEG)
    free = knee_headings(
        _faced(thigh, 0.0), _faced(shank, 0.0), _RATE_HZ, heading_sd_deg=(1e3, 1e3)
    )
    sd = np.array(HEADING_SD_DEG)
    assert np.sum((np.degrees(exact) / sd) ** 2) < np.sum((np.degrees(free) / sd) ** 2)
    # with zero turns the cost is the variance of the abduction alone, an upper bound
    flexion = 20 - 12 * np.cos(_TIME_S) - 18 * np.cos(2 * _TIME_S)
    assert np.sum((np.degrees(exact) / sd) ** 2) < np.var(0.1 * flexion) / ABDUCTION_DEG**2


def _trial(side, **changes):
    """A walk recorded by sensors with arbitrary mounting."""
    imus = {}
    for k, (name, orientation) in enumerate(zip(("thigh", "shank"), _leg(), strict=True)):
        rate, force = _rates(orientation), orientation.inv().apply([0.0, 0.0, GRAVITY_M_S2])
        if side == "left":
            rate, force = mirror_angular_rate(rate), force * [1.0, -1.0, 1.0]
        mounting = Rotation.random(random_state=k)
        imus[f"{name}_{side}"] = ImuRecording(
            f"{name}_{side}", _TIME_S, mounting.apply(rate), mounting.apply(force)
        )
    fields = {
        "still_s": ((0.0, _STAND_S - 0.1),),
        "starts_in_calibration_posture": True,
        "walking_s": (_STAND_S, float(_TIME_S[-1])),
    }
    return Trial("made", "s", "c", "t", _RATE_HZ, imus, **(fields | changes))


def _turned(trial):
    return {
        segment: "minimise knee abduction" in " ".join(calibrated.notes)
        for segment, calibrated in calibrate(trial, "walking").items()
    }


def test_left_and_right_legs_are_turned_alike():
    right, left = (
        [c.signals.axis_rates_rad_s for c in calibrate(_trial(side)).values()]
        for side in ("right", "left")
    )
    np.testing.assert_allclose(right, left, atol=1e-6)
    assert all(_turned(_trial("left")).values())


def test_without_a_knee_to_see_the_segment_keeps_its_own_frame():
    whole = _trial("right")
    for lonely in ("thigh_right", "shank_right"):
        alone = Trial(
            "made", "s", "c", "t", _RATE_HZ, {lonely: whole.imus[lonely]}, still_s=whole.still_s
        )
        assert _turned(alone) == {lonely: False}
    nowhere = {"still_s": (), "starts_in_calibration_posture": False}
    assert not any(_turned(_trial("right", **nowhere)).values())
    assert not any(_turned(_trial("right", walking_s=(_STAND_S, 4.5))).values())
    # the walk does not follow the standing directly
    assert not any(_turned(_trial("right", walking_s=(9.0, 19.0))).values())
    at_once = {"still_s": (), "walking_s": None}
    assert all(_turned(_trial("right", **at_once)).values())


def test_a_gap_ends_what_the_knee_is_seen_in():
    early, late, both = _trial("right"), _trial("right"), _trial("right")
    for trial, gap_s in ((early, 4.0), (late, 15.0), (both, 4.0), (both, 15.0)):
        trial.imus["shank_right"].gyroscope_rad_s[int(gap_s * _RATE_HZ)] = np.nan
    assert not any(_turned(early).values())
    assert not any(_turned(both).values())
    assert all(_turned(late).values())


@pytest.mark.parametrize(
    ("still_s", "walking_s", "gap_s", "expected_s"),
    [
        (((0.0, 1.9),), None, None, (1.9, 61.9)),  # a minute
        (((0.0, 1.9), (80.0, 90.0)), (3.0, 99.0), None, (1.9, 63.0)),  # of the walk
        (((0.0, 1.9),), (3.0, 20.0), None, (1.9, 20.0)),
        (((0.0, 1.9),), (1.0, 99.0), None, (1.9, 61.9)),
        ((), (0.5, 99.0), None, (0.0, 60.5)),  # the first sample is the posture
        (((0.0, 1.9),), (6.8, 99.0), None, (1.9, 66.8)),
        (((0.0, 1.9),), (7.0, 99.0), None, None),  # more than five seconds before the walk
        (((40.0, 50.0),), (3.0, 40.0), None, None),  # after the walk
        (((0.0, 1.9),), None, 30.0, (1.9, 29.9)),
        (((0.0, 1.9),), None, 1.0, (1.9, 61.9)),  # a gap before the walk
    ],
)
def test_the_walk_that_tells_of_the_knee(still_s, walking_s, gap_s, expected_s):
    time_s = np.arange(1000) / 10.0
    imu = ImuRecording("thigh", time_s, np.zeros((1000, 3)), np.zeros((1000, 3)))
    trial = Trial(
        "made", "s", "c", "t", 10.0, {"thigh": imu}, still_s=still_s, walking_s=walking_s,
        starts_in_calibration_posture=True,
    )  # fmt: skip
    found = time_s[_first_steps(trial, time_s != gap_s)]
    assert (None if not len(found) else (found[0], found[-1])) == expected_s
    assert len(found) == 0 or len(found) == round(10.0 * (found[-1] - found[0])) + 1


def test_simulated_knees_agree_better_with_their_bones():
    """Walking calibration of drawn walkers: cross-talk of flexion into abduction."""
    source = SimulatedGait(
        subjects=["V1", "V2", "V3", "V4"],
        conditions=["normal"],
        treadmill_duration_s=30.0,
        sampling_rate_hz=100.0,
    )
    own, by_knee = [], []
    for trial in source:
        truth = source.truth(trial.subject, trial.condition, trial.trial)
        calibrated = calibrate(trial, "walking")
        alone = {
            s: calibrate(
                Trial(
                    "made", "s", "c", "t", 100.0, {s: trial.imus[s]},
                    still_s=trial.still_s, walking_s=trial.walking_s,
                ),
                "walking",
            )[s]
            for s in trial.imus
        }  # fmt: skip
        for shank in ("shank_right", "shank_left"):
            bone, sensor = (
                Rotation.from_quat(of[shank][:500], scalar_first=True)
                for of in (truth.segment_wxyz, truth.sensor_wxyz)
            )
            for errors, found in ((own, alone), (by_knee, calibrated)):
                off = found[shank].sensor_to_anatomical * (sensor.inv() * bone).mean()
                errors.append(np.degrees(off.as_rotvec()[2]))
    assert np.sqrt(np.mean(np.square(by_knee))) < np.sqrt(np.mean(np.square(own))) - 0.5


def test_the_knee_rotates_calibrated_frames_by_less_than_their_uncertainty():
    source = SimulatedGait(
        subjects=["V1"], conditions=["fast"], treadmill_duration_s=25.0, sampling_rate_hz=100.0
    )
    trial = next(iter(source))
    leg, knee = calibrate(trial, "leg"), calibrate(trial, "knee")
    for segment, one in knee.items():
        turn = (one.sensor_to_anatomical * leg[segment].sensor_to_anatomical.inv()).as_rotvec()
        np.testing.assert_allclose(turn[:2], 0.0, atol=1e-9)
        limit = LEG_HEADING_SD_DEG[segment.startswith("shank")]
        assert 0.0 < np.degrees(abs(turn[2])) < limit


def test_what_counts_as_walking_does_not_depend_on_the_rate():
    """A knee that bends at 0.6 Hz, near the edge of the band: at 100 Hz as at 50 Hz."""
    flexion = 25.0 * np.sin(2 * np.pi * 0.6 * _TIME_S)
    still = np.zeros((len(_TIME_S), 3))
    knee = np.radians(np.column_stack([flexion, still[:, 0], still[:, 0]]))
    thigh = orientation_from_angles(still)
    shank = orientation_from_joint_angles(knee, thigh)
    leg = [Rotation.from_quat(q, scalar_first=True) for q in (thigh, shank)]
    rates = [_faced(segment, error) for segment, error in zip(leg, (8.0, -5.0), strict=True)]
    fast, slow = (
        np.degrees(knee_headings(*(r[::n] for r in rates), _RATE_HZ / n, (4.0, 4.0)))
        for n in (1, 2)
    )
    np.testing.assert_allclose(fast, slow, atol=0.01)
    assert 0.5 < abs(fast[1]) < 0.9
