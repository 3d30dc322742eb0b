"""The start-up against an exact integration of rotations."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from narx.inference.start_up import StartUp
from narx.inference.washout import WASHOUT_S
from narx.kernels.start_up import MOVING_S
from narx.kinematics.segment_angles import (
    angles_from_orientation,
    axis_rates,
    orientation_from_angles,
)

RATE_HZ = 500.0


def motion(seconds, rng, mean=(0.1, 0.05, 0.0)):
    """Angles of a turning, swinging segment and the gyroscope that goes with them."""
    time = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    swing = np.column_stack(
        [
            0.4 * np.sin(2 * np.pi * 0.9 * time + phase) * (1 - np.exp(-time))
            for phase in rng.uniform(0, 6, 3)
        ]
    )
    angles = swing + np.array(mean) * (1 - np.exp(-time))[:, None]
    angles[:, 2] += 0.3 * time
    rotation = Rotation.from_quat(orientation_from_angles(angles), scalar_first=True)
    step = (rotation[:-1].inv() * rotation[1:]).as_rotvec() * RATE_HZ
    # the mean rate over an interval, put at its middle: trapezoids of neighbours restore it
    rates = np.vstack([step[:1], (step[1:] + step[:-1]) / 2, step[-1:]])
    return angles, axis_rates(rates)


def test_integrates_rotations_from_a_known_start():
    angles, rates = motion(20.0, np.random.default_rng(0))
    start_up = StartUp(duration_s=30.0)
    estimate = start_up.run(rates, 1 / RATE_HZ, start_up.begin(angles[0]))
    np.testing.assert_allclose(estimate, angles, atol=np.deg2rad(0.1))
    quaternion = orientation_from_angles(estimate)
    np.testing.assert_allclose(angles_from_orientation(quaternion), estimate, atol=1e-9)


def test_each_axis_on_its_own_books_a_turn_as_flexion():
    angles, rates = motion(20.0, np.random.default_rng(0), mean=(0.3, 0.2, 0.0))
    start_up = StartUp(duration_s=30.0)
    estimate = start_up.run(rates, 1 / RATE_HZ, start_up.begin(angles[0]), coupled=False)
    assert np.abs(estimate[-500:, :2] - angles[-500:, :2]).max() > np.deg2rad(20.0)


def test_posture_is_the_mean_angle_and_nothing_jumps():
    angles, rates = motion(30.0, np.random.default_rng(1))
    start_up = StartUp()
    state = start_up.begin(angles[0])
    estimate = start_up.run(rates, 1 / RATE_HZ, state)
    assert start_up.is_over(state)
    assert len(estimate) == pytest.approx(start_up.duration_s * RATE_HZ, abs=0.5 * RATE_HZ)
    posture, deviation, previous, last_rates = start_up.hand_over(state, 1 / RATE_HZ)
    np.testing.assert_allclose(posture + deviation, estimate[-1], atol=1e-12)
    np.testing.assert_allclose(posture[:2], [0.1, 0.05], atol=np.deg2rad(0.3))
    np.testing.assert_allclose(posture + previous, estimate[-2], atol=np.deg2rad(0.02))
    np.testing.assert_allclose(
        last_rates, (estimate[-1] - estimate[-3]) * RATE_HZ / 2, atol=np.deg2rad(2.0)
    )


@pytest.mark.parametrize(("begin_s", "middle_s"), [(2.0, 5.0), (0.0, 3.0), (100.0, 9.0)])
def test_posture_is_the_mean_of_its_part(begin_s, middle_s):
    """A bias makes the angle rise linearly, so the mean reveals the interval that was averaged."""
    bias = 0.01
    time = np.arange(round(15.0 * RATE_HZ)) / RATE_HZ
    rates = np.column_stack([np.full_like(time, bias), 3.0 * np.cos(6.0 * time), 0.0 * time])
    start_up = StartUp(averaging_begin_s=begin_s)
    assert (start_up.duration_s, start_up.averaging_s) == (12.0, 6.0)
    state = start_up.begin(np.zeros(3))
    n = len(start_up.run(rates, 1 / RATE_HZ, state, coupled=False))
    stood_s = n / RATE_HZ - start_up.duration_s
    posture, *_ = start_up.hand_over(state, 1 / RATE_HZ)
    assert posture[0] == pytest.approx(bias * (stood_s + middle_s), rel=2e-3)


@pytest.mark.parametrize("share", [0.25, 0.5, 0.8])
def test_the_posture_is_averaged_by_a_hann_window(share):
    """A step counts by the part of the window that is left: 1 - u + sin(2 pi u) / 2 pi."""
    start_up = StartUp()
    time = np.arange(round(15.0 * RATE_HZ)) / RATE_HZ
    at_s = start_up.averaging_begin_s + share * start_up.averaging_s
    rates = np.column_stack([1.0 * (abs(time - at_s) < 0.05), 3.0 * np.cos(6.0 * time), 0.0 * time])
    state = start_up.begin(np.zeros(3))
    estimate = start_up.run(rates, 1 / RATE_HZ, state, coupled=False)
    posture, *_ = start_up.hand_over(state, 1 / RATE_HZ)
    before = share - np.sin(2 * np.pi * share) / (2 * np.pi)
    assert posture[0] / estimate[-1, 0] == pytest.approx(1.0 - before, abs=5e-3)


def test_somebody_who_stands_is_waited_for():
    _, rates = motion(20.0, np.random.default_rng(1))
    sway = 0.02 * np.random.default_rng(3).normal(size=(round(15 * RATE_HZ), 3))
    start_up = StartUp()
    state = start_up.begin(np.zeros(3))
    assert len(start_up.run(sway, 1 / RATE_HZ, state)) == len(sway)
    assert not start_up.is_over(state)
    assert len(start_up.run(rates, 1 / RATE_HZ, state)) < len(rates)
    assert start_up.is_over(state)


def test_it_is_over_after_its_duration_in_movement():
    """At 16 Hz two seconds are 32 samples without rounding."""
    rates = np.tile([3.0, 0.0, 0.0], (60, 1))
    start_up = StartUp(duration_s=2.0, averaging_s=1.0)
    state = start_up.begin(np.zeros(3))
    n = len(start_up.run(rates, 1.0 / 16.0, state))
    assert state[MOVING_S] == 2.0
    assert start_up.is_over(state)
    assert n < 40


def test_unknown_start_forgets_where_it_began():
    start_up = StartUp()
    state = start_up.begin(None)
    second = round(RATE_HZ)
    turn = np.tile([0.5, -0.3, 0.0], (second, 1))
    estimate = start_up.run(np.vstack([turn, np.zeros((59 * second, 3))]), 1 / RATE_HZ, state)
    assert np.abs(estimate[second]).max() > np.deg2rad(4.0)
    assert np.abs(estimate[-1]).max() < np.deg2rad(0.5)
    posture, *_ = start_up.hand_over(state, 1 / RATE_HZ)
    assert not posture.any()


@pytest.mark.parametrize("known", [True, False])
def test_in_pieces_as_in_one_go(known):
    rng = np.random.default_rng(2)
    rates = rng.normal(size=(400, 3))
    start_up = StartUp()
    initial = rng.normal(size=3) * 0.1 if known else None
    whole = start_up.run(rates, 0.01, start_up.begin(initial))
    state = start_up.begin(initial)
    pieces = [start_up.run(piece, 0.01, state) for piece in np.array_split(rates, 7)]
    np.testing.assert_array_equal(np.concatenate(pieces), whole)


def test_no_start_up_takes_no_sample():
    start_up = StartUp(duration_s=0.0)
    assert not len(start_up.run(np.ones((5, 3)), 0.01, start_up.begin(None)))


def test_an_unknown_start_is_forgotten_by_the_gain_of_a_growing_memory():
    """angle' = -(l + g / (t + s)) angle: exp(-l (t - t0)) ((t0 + s) / (t + s))^g is left."""
    start_up = StartUp(duration_s=60.0, leak_rad_s=0.3, settling_gain=1.5, settling_s=0.7)
    second = round(RATE_HZ)
    rates = np.zeros((6 * second, 3))
    rates[: second // 2] = [0.5, -0.3, 0.2]
    estimate = start_up.run(rates, 1 / RATE_HZ, start_up.begin(None), coupled=False)
    left = np.exp(-0.3 * 4.0) * ((1.0 + 0.7) / (5.0 + 0.7)) ** 1.5
    np.testing.assert_allclose(estimate[5 * second - 1] / estimate[second - 1], left, rtol=5e-3)


def test_the_default_is_that_of_the_default_model():
    files = Path(__file__).parents[3] / "configs" / "model"
    written = yaml.safe_load((files / "coupled.yaml").read_text())
    del written["start_up"]["_target_"]
    assert vars(StartUp()) == written["start_up"]
    assert written["washout_s"] == WASHOUT_S
