"""A walker who stands, walks, and turns at a known time."""

import numpy as np
import pytest

from narx.gait.straight_walk import straight_walk_s, walk_before_turn_s
from narx.recordings.trial import ImuRecording, Trial

RATE_HZ = 50.0
UP = np.array([0.0, 0.6, 0.8])


def _rates(turn_at_s, drift_rad_s=0.0):
    time = np.arange(0.0, 40.0, 1 / RATE_HZ)
    step = np.where((time > 4), 0.5 * np.sin(2 * np.pi * 0.9 * time), 0.0)
    turn = np.where((time > turn_at_s) & (time < turn_at_s + 2), np.pi / 2, 0.0)
    return (step + turn + drift_rad_s)[:, None] * UP


def test_the_walk_ends_where_the_turn_begins():
    begin, end = straight_walk_s([_rates(20.0), _rates(20.0)], [UP, UP], RATE_HZ, 4.0)
    assert begin == 4.0
    assert end == pytest.approx(20.0, abs=0.5)


@pytest.mark.parametrize(("turn_at_s", "drift_rad_s"), [(100.0, 0.0), (100.0, 0.05), (5.0, 0.0)])
def test_without_a_turn_or_without_a_walk_there_is_none(turn_at_s, drift_rad_s):
    assert straight_walk_s([_rates(turn_at_s, drift_rad_s)], [UP], RATE_HZ, 4.0) is None


def test_a_fast_swing_about_a_horizontal_axis_is_no_turn():
    across = np.array([0.0, 0.8, -0.6])
    time = np.arange(0.0, 40.0, 1 / RATE_HZ)
    leaning = np.where((time > 20.0) & (time < 22.0), np.pi / 2, 0.0)[:, None] * across
    assert straight_walk_s([leaning], [UP], RATE_HZ, 4.0) is None
    # two sensors that disagree turn by their mean: 18 degrees are too little
    half = [np.radians(x) * UP * (leaning @ across)[:, None] / np.pi for x in (36.0, 0.0)]
    assert straight_walk_s(half, [UP, UP], RATE_HZ, 4.0) is None


@pytest.mark.parametrize("clockwise", [1.0, -1.0])
def test_bias_and_vertical_are_those_of_standing_on_the_clock_of_the_trial(clockwise):
    """A bias of 20 deg/s about the vertical would be a turn at once."""
    time = 100.0 + np.arange(0.0, 40.0, 1 / RATE_HZ)
    gyroscope = clockwise * _rates(20.0) + np.radians(20.0) * UP
    force = np.tile(9.81 * UP, (len(time), 1))
    gyroscope[10], force[11] = np.nan, np.nan
    imus = {"thigh": ImuRecording("thigh", time, gyroscope, force)}
    trial = Trial("d", "s", "c", "t", RATE_HZ, imus)
    begin, end = walk_before_turn_s(trial, (100.0, 104.0))
    assert begin == pytest.approx(104.0)
    assert end == pytest.approx(120.0, abs=0.5)
    imus["thigh"].accelerometer_m_s2[:] = np.nan
    assert walk_before_turn_s(trial, (100.0, 104.0)) is None


def test_turning_within_a_stride_is_no_turn():
    """Thirty degrees to and fro: a tenth is left by averaging over 0.9 of a stride."""
    time = np.arange(0.0, 40.0, 1 / RATE_HZ)
    omega = 2 * np.pi * 0.9
    swing = np.where(time > 4, np.pi / 6 * omega * np.cos(omega * time), 0.0)
    assert straight_walk_s([swing[:, None] * UP], [UP], RATE_HZ, 4.0) is None
