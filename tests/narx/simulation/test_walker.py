"""The individual walkers: speed, cadence, ranges."""

from dataclasses import replace

import numpy as np
import pytest

from narx.errors import UserError
from narx.simulation.body import TABLE_1, body_of
from narx.simulation.gait_curves import TABLE_TOE_OFF, evaluate
from narx.simulation.running import running_curves
from narx.simulation.skeleton import forward_velocity
from narx.simulation.walker import (
    pelvis_velocity,
    stride_frequency_hz,
    toe_off_phase,
    walking_pattern,
)

PHASE = np.arange(400) / 400


@pytest.mark.parametrize("subject", list(TABLE_1))
@pytest.mark.parametrize("speed_m_s", [0.72, 0.92, 1.19])
def test_feet_carry_the_walker_at_the_speed(subject, speed_m_s):
    body = TABLE_1[subject]
    pattern = walking_pattern(subject, body, speed_m_s, 0)
    phase = np.arange(3 * 128) / 128
    velocity = forward_velocity(
        pattern.joint_angles(phase), phase, pattern.toe_off, pattern.left_lag, body,
        128 / pattern.stride_s,
    )  # fmt: skip
    stride = velocity[128:256, :2]
    assert stride[:, 0].mean() == pytest.approx(speed_m_s, abs=0.005)
    # and about as evenly as people walk, whose pelvis goes to the sides by 0.16 m/s
    usual = pelvis_velocity(phase[128:256], speed_m_s, pattern.stride_s)
    assert (np.sqrt(np.mean((stride - usual) ** 2, axis=0)) < [0.07, 0.04]).all()


def test_strides_are_about_as_many_as_the_paper_counted():
    # Tham et al. (2020), section III: cycles of five subjects, five minutes each
    for speed_km_h, counted in ((2.6, 1109), (3.3, 1272), (4.3, 1413)):
        strides = sum(
            300.0 * stride_frequency_hz(speed_km_h / 3.6, body.height_m)
            for body in TABLE_1.values()
        )
        assert strides == pytest.approx(counted, rel=0.06)


def test_joint_ranges_are_human():
    for subject, body in TABLE_1.items():
        for speed_m_s in (0.72, 1.19):
            angles = walking_pattern(subject, body, speed_m_s, 0).joint_angles(PHASE)
            for side in ("right", "left"):
                knee = np.degrees(angles[f"knee_{side}"])
                hip = np.degrees(angles[f"hip_{side}"])
                assert 38.0 < np.ptp(knee[:, 0]) < 72.0
                assert knee[:, 0].min() > -8.0
                assert np.ptp(knee[:, 1]) < 9.0
                assert 25.0 < np.ptp(hip[:, 0]) < 50.0
                assert hip[:, 0].max() > 10.0 > -2.0 > hip[:, 0].min()


def test_a_person_is_the_same_at_every_speed_and_unlike_another():
    def knee(subject, speed):
        pattern = walking_pattern(subject, TABLE_1["S1"], speed, 0)
        return np.degrees(pattern.joint_angles(PHASE)["knee_right"][:, 0])

    def distance(a, b):
        return np.sqrt(np.mean((a - b) ** 2))

    assert distance(knee("S1", 0.9), knee("S1", 0.92)) < 0.5
    assert distance(knee("S1", 0.9), knee("S2", 0.9)) > 1.5


def test_usual_pelvis_velocity():
    velocity = pelvis_velocity(PHASE, 0.7, 1.4)
    assert velocity[:, 0].mean() == pytest.approx(0.7)
    path = np.cumsum(velocity[:, 1]) * 1.4 / len(PHASE)
    assert np.ptp(path) == pytest.approx(0.07, abs=0.001)
    # 6 % faster than on average
    assert velocity[:, 0].max() == pytest.approx(1.06 * 0.7)
    # fastest after each heel strike; over the right leg in the middle of its stance
    assert PHASE[np.argmax(velocity[:200, 0])] == pytest.approx(0.06)
    assert PHASE[np.argmin(path)] == pytest.approx(0.35, abs=0.01)


@pytest.mark.parametrize(
    ("speed_m_s", "width_m"), [(0.1, 0.08), (0.7, 0.07), (1.6, 0.04), (3.0, 0.03)]
)
def test_the_pelvis_sways_the_less_to_the_sides_the_faster_the_walk(speed_m_s, width_m):
    velocity = pelvis_velocity(PHASE, speed_m_s, 1.1)
    path = np.cumsum(velocity[:, 1]) * 1.1 / len(PHASE)
    assert np.ptp(path) == pytest.approx(width_m, rel=0.03)


@pytest.mark.parametrize(("speed_m_s", "steps_a_minute"), [(1.7, 1.1 * 64.8), (0.85, 48.0)])
def test_stride_frequency_is_that_of_grieve_and_gear(speed_m_s, steps_a_minute):
    """At one stature and half a stature per second; 0.5^0.57 = 0.674."""
    assert 60.0 * stride_frequency_hz(speed_m_s, 1.7) == pytest.approx(steps_a_minute, abs=0.05)


@pytest.fixture(scope="module")
def runners():
    """Two hundred people, whose curves no fit to their feet has changed."""
    return [walking_pattern(f"V{k}", TABLE_1["S1"], 4.0, 0, runs=True) for k in range(1, 201)]


def test_legs_of_one_person_differ_less_than_two_persons(runners):
    legs = [[one.curves[f"knee_{side}"][0] for side in ("right", "left")] for one in runners]
    right, left = np.stack(legs, axis=1)
    within = np.mean(np.abs(right - left) ** 2)
    between = np.mean(np.abs(right[1:] - right[:-1]) ** 2)
    assert within < 0.5 * between


def test_people_differ_in_frequency_and_contacts_as_documented(runners):
    frequency = [1.0 / one.stride_s for one in runners]
    assert np.mean(frequency) == pytest.approx(1.35, rel=0.01)
    assert np.std(frequency) == pytest.approx(0.03 * 1.35, rel=0.2)
    for numbers, mean, spread in (
        ([one.toe_off for one in runners], 0.38, 0.006),
        ([one.left_lag for one in runners], 0.5, 0.005),
    ):
        assert np.mean(numbers) == pytest.approx(mean, abs=0.2 * spread)
        assert np.std(numbers) == pytest.approx(spread, rel=0.2)


def test_people_differ_in_size_and_timing_as_documented(runners):
    """Size 8 %, each harmonic 4 %, timing 0.8 % of the stride; a third of it from leg to leg."""
    mean = running_curves(4.0)["knee"][0]
    both = 1.0 + 0.33**2
    relative = np.array([one.curves["knee_right"][0] for one in runners])[:, 1:3] / mean[1:3]
    size = np.sqrt(both * (0.08**2 + 0.04**2))
    np.testing.assert_allclose(np.abs(relative).std(axis=0), size, rtol=0.2)
    # the second harmonic turns twice as far
    angle = [np.hypot(2.0 * np.pi * k * 0.008, 0.04) * np.sqrt(both) for k in (1, 2)]
    np.testing.assert_allclose(np.angle(relative).std(axis=0), angle, rtol=0.2)
    legs = [[one.curves[f"knee_{side}"][0, 0] for side in ("right", "left")] for one in runners]
    means = np.degrees(np.array(legs).real)
    # 3 degrees and 8 % of the mean
    spread = np.sqrt(both) * np.hypot(3.0, 0.08 * np.degrees(mean[0].real))
    np.testing.assert_allclose(means.std(axis=0), spread, rtol=0.2)
    apart = np.sqrt(2.0) * 0.33 * np.hypot(3.0, 0.08 * np.degrees(mean[0].real))
    assert np.diff(means).std() == pytest.approx(apart, rel=0.2)
    # a mean angle has no phase
    assert np.abs(np.array(legs).imag).max() == 0.0


@pytest.mark.parametrize(
    ("speed_m_s", "phase"), [(0.0, 0.70), (1.3, 0.63), (2.0, 0.5915), (3.0, 0.58)]
)
def test_the_foot_leaves_the_ground_earlier_the_faster_the_walk(speed_m_s, phase):
    assert toe_off_phase(speed_m_s) == pytest.approx(phase)


def test_the_left_leg_lags_and_both_leave_the_ground_with_the_table():
    pattern = replace(walking_pattern("S1", TABLE_1["S1"], 0.9, 0), left_lag=0.53, toe_off=0.66)
    strikes, offs = (pattern.joint_angles(np.array([p, p + 0.53])) for p in (0.0, 0.66))
    for phase, angles in ((0.0, strikes), (TABLE_TOE_OFF, offs)):
        for joint, row in (("knee_right", 0), ("knee_left", 1)):
            expected = evaluate(pattern.curves[joint], np.array([phase]))[0]
            np.testing.assert_allclose(angles[joint][row], expected, atol=1e-9)


def test_the_pelvis_of_a_person_is_level_and_straight_on_average(runners):
    """A third of the spread that the legs have: about 0.3 and 0.45 degrees."""
    means = [np.degrees(pattern.curves["pelvis"][:, 0].real) for pattern in runners]
    spread = np.std(means, axis=0)
    np.testing.assert_allclose(spread, [2.0, 0.3, 0.45], rtol=0.2)


def test_bodies():
    # Tham et al. (2020), Table 1
    table = {name: (body.height_m, body.mass_kg) for name, body in TABLE_1.items()}
    assert table == {
        "S1": (1.62, 48.0), "S2": (1.84, 84.0), "S3": (1.59, 49.0), "S4": (1.79, 75.0),
        "S5": (1.59, 55.0),
    }  # fmt: skip
    assert body_of("S2", 0) == TABLE_1["S2"]
    assert body_of("V7", 0) == body_of("V7", 0) != body_of("V7", 1)
    heights = [body_of(f"V{k}", 0).height_m for k in range(1, 300)]
    assert np.mean(heights) == pytest.approx(1.69, abs=0.02)
    assert np.std(heights) == pytest.approx(0.09, rel=0.1)
    people = [body_of(f"V{k}", 0) for k in range(1, 300)]
    index = [person.mass_kg / person.height_m**2 for person in people]
    assert (np.mean(index), np.std(index)) == pytest.approx((23.0, 2.5), rel=0.1)
    with pytest.raises(UserError, match="subject 'S9', expected S1"):
        body_of("S9", 0)
