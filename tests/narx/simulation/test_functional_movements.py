"""Calibration movements: which axis, which way first, how far."""

import numpy as np
import pytest

from narx.kinematics.segment_angles import angles_from_orientation, mirror_quaternion
from narx.simulation.functional_movements import PARTS, calibration_angles, duration_s
from narx.simulation.skeleton import segment_orientations

RATE_HZ = 100.0


def _perform(part, seed=0):
    time_s = np.arange(int(duration_s(part) * RATE_HZ)) / RATE_HZ
    return time_s, calibration_angles(part, time_s, np.random.default_rng(seed))


def _segment_angles_deg(angles, segment):
    wxyz = segment_orientations(angles)[segment].as_quat(scalar_first=True)
    if segment.endswith("left"):
        wxyz = mirror_quaternion(wxyz)
    return np.degrees(angles_from_orientation(wxyz))


def test_standing_sways_by_tenths_of_a_degree():
    _, angles = _perform("standing")
    for joint in angles.values():
        assert 0.05 < np.degrees(np.std(joint)) < 0.6


@pytest.mark.parametrize("part", [p for p in PARTS if p.startswith("hip")])
def test_hip_abduction_moves_the_thigh_outwards_first(part):
    time_s, angles = _perform(part)
    side = part.rsplit("_", 1)[1]
    thigh = _segment_angles_deg(angles, f"thigh_{side}")
    assert 20.0 < thigh[:, 1].max() < 40.0
    assert thigh[:, 1].min() > -4.0
    first = np.argmax(np.abs(thigh[:, 1]) > 8.0)
    assert thigh[first, 1] > 0.0
    assert np.abs(thigh[:, [0, 2]]).max() < 12.0
    other = _segment_angles_deg(angles, f"thigh_{'left' if side == 'right' else 'right'}")
    assert np.abs(other[time_s < 2.0]).max() < 3.0


@pytest.mark.parametrize("part", [p for p in PARTS if p.startswith("knee")])
def test_knee_flexion_moves_the_foot_forwards_first_over_a_level_thigh(part):
    _, angles = _perform(part)
    side = part.rsplit("_", 1)[1]
    shank = _segment_angles_deg(angles, f"shank_{side}")
    # dangling, then lifted forwards
    assert abs(shank[0, 0]) < 5.0
    assert 35.0 < shank[:, 0].max() < 70.0
    assert shank[:, 0].min() > -10.0
    # deg of hip flexion, not of the Euler angle, which is near its pole
    assert 80.0 < np.degrees(angles[f"hip_{side}"][:, 0]).mean() < 96.0
    assert np.degrees(np.ptp(angles[f"hip_{side}"][:, 0])) < 6.0


def test_the_pelvis_rises_on_the_side_of_the_lifted_leg_by_a_tenth():
    for side, down in (("right", -1.0), ("left", 1.0)):
        _, angles = _perform(f"hip_abduction_{side}")
        lifted = np.degrees(angles[f"hip_{side}"][:, 1])
        pelvis = np.degrees(angles["pelvis"][:, 1])
        assert np.polyfit(lifted, pelvis, 1)[0] == pytest.approx(0.1 * down, abs=0.01)


def test_the_thigh_is_lifted_as_the_knee_is_stretched():
    for side in ("right", "left"):
        slopes = []
        for seed in range(20):
            _, angles = _perform(f"knee_flexion_{side}", seed)
            slopes.append(np.polyfit(*(angles[f"{j}_{side}"][:, 0] for j in ("knee", "hip")), 1)[0])
        assert np.mean(slopes) == pytest.approx(-0.04, abs=0.003)


@pytest.mark.parametrize("part", [p for p in PARTS if p.startswith(("hip", "knee"))])
def test_five_movements_begin_after_two_seconds_and_end_before_the_recording(part):
    time_s, angles = _perform(part)
    joint, side = part.split("_")[0], part.rsplit("_", 1)[1]
    way = np.degrees(angles[f"{joint}_{side}"][:, 1 if joint == "hip" else 0])
    moved = np.abs(way - way[time_s < 1.9].mean())
    size = {"hip": 30.0, "knee": 50.0}[joint]
    assert moved[(time_s < 2.0) | (time_s > 19.5)].max() < 2.0
    above = moved > 0.5 * size
    starts = time_s[1:][np.diff(above.astype(int)) == 1]
    ends = time_s[1:][np.diff(above.astype(int)) == -1]
    assert len(starts) == 5
    # one way takes 1.2 s, and so do the way back and its halves together; 0.3 s of rest between
    np.testing.assert_allclose(ends - starts, 1.5, atol=0.15)
    np.testing.assert_allclose(np.diff(starts), 3.4, atol=0.3)
    assert moved.max() == pytest.approx(size, rel=0.12)


def test_the_table_is_still_for_half_a_minute_and_standing_lasts_ten_seconds():
    lengths = [duration_s(part) for part in ("still", "standing", "hip_abduction_left")]
    assert lengths == [30.0, 10.0, 20.0]


def test_the_other_angles_follow_by_their_share():
    """4 % of the movement from person to person, 2 % more from repetition to repetition."""
    time_s = np.arange(2000) / RATE_HZ
    people = [
        calibration_angles("hip_abduction_right", time_s, np.random.default_rng(k))["hip_right"]
        for k in range(300)
    ]
    # the sway of standing is common to all samples of a peak: compare means over a plateau
    begins = [(time_s > t - 0.1) & (time_s < t + 0.1) for t in 3.4 + 3.4 * np.arange(5)]
    plateaus = np.array([[one[b].mean(axis=0) for b in begins] for one in people])
    shares = plateaus[:, :, [0, 2]] / plateaus[:, :, 1:2]
    within = shares.std(axis=1, ddof=1)
    # the sway adds 0.25 of some 27 degrees
    sway = 0.25 / 27.0
    assert np.sqrt(np.mean(within**2)) == pytest.approx(np.hypot(0.02, sway), rel=0.15)
    between = np.sqrt(shares.mean(axis=1).var() - np.mean(within**2) / 5.0)
    assert between == pytest.approx(0.04, rel=0.15)


def test_movements_are_neither_exact_nor_identical():
    _, angles = _perform("hip_abduction_right")
    moving = np.degrees(angles["hip_right"])
    assert 0.3 < np.ptp(moving[:, 0]) < 15.0
    _, again = _perform("hip_abduction_right", seed=1)
    assert np.abs(moving - np.degrees(again["hip_right"])).max() > 1.0
