"""The pieces of an anatomical frame, each against a case whose answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.calibration.axes import (
    excursion_rad,
    frame_from_gravity,
    frame_from_left,
    principal_horizontal_axis,
    swing_sign,
    up_from_gravity,
    walking_band,
)
from narx.errors import RecordingError

RATE_HZ = 100.0


@pytest.mark.parametrize(
    ("frequency_hz", "gain"),
    # half of the power is left at a cut-off, and the filter runs forwards and backwards
    # 1 / (1 + ((f f - 0.5 h) / (f (h - 0.5)))^4) for second order, frequencies warped by the
    # bilinear transform: h is that of 10 Hz
    [
        (0.05, 0.0),
        (0.35, 0.178),
        (0.5, 0.5),
        (1.0, 0.97),
        (3.0, 1.0),
        (10.0, 0.5),
        (14.0, 0.17),
        (25.0, 0.0),
    ],
)
def test_the_band_of_walking(frequency_hz, gain):
    time_s = np.arange(0.0, 120.0, 1 / RATE_HZ)
    rate = np.sin(2 * np.pi * frequency_hz * time_s)[:, None] * [1.0, -2.0, 0.5]
    inside = slice(3000, -3000)
    found = walking_band(rate, RATE_HZ)[inside]
    expected = rate[inside]
    np.testing.assert_allclose(found, gain * expected, atol=0.06)


def test_gaps_and_short_pieces_have_no_band():
    rate = np.random.default_rng(0).normal(size=(1000, 3))
    rate[500] = rate[590] = rate[701] = np.nan
    found = np.isfinite(walking_band(rate, RATE_HZ)).all(axis=1)
    assert found[:500].all()
    assert not found[500:591].any()  # 0.9 s
    assert found[591:701].all()  # 1.1 s
    assert not found[701]
    assert found[702:].all()


def test_a_slow_sensor_has_the_part_of_the_band_that_it_measures():
    """At 16 Hz there is nothing above 8 Hz; 2 Hz pass."""
    rate = np.sin(2 * np.pi * 2.0 * np.arange(1600) / 16.0)[:, None] * [1.0, -2.0, 0.5]
    np.testing.assert_allclose(walking_band(rate, 16.0)[200:-200], rate[200:-200], atol=0.02)


@pytest.mark.parametrize("size", [8.1, 9.81, 11.9])
def test_up_is_the_mean_specific_force(size):
    force = np.tile([0.6 * size, 0.0, 0.8 * size], (5, 1))
    force[2, 1] = np.nan
    np.testing.assert_allclose(up_from_gravity(force, "x"), [0.6, 0.0, 0.8])


def test_a_fifth_of_the_samples_turns_the_mean():
    force = np.array([[0.0, 0.0, 9.81]] * 4 + [[9.81, 0.0, 0.0]])
    np.testing.assert_allclose(up_from_gravity(force, "x"), np.array([1, 0, 4]) / np.sqrt(17))


@pytest.mark.parametrize(("size", "message"), [(7.9, "7.90"), (12.1, "12.10"), (np.nan, "no acc")])
def test_a_mean_force_other_than_gravity_is_refused(size, message):
    with pytest.raises(RecordingError, match=f"x: .*{message}"):
        up_from_gravity(np.full((3, 3), [0.0, size, 0.0]), "x")


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_horizontal_axis_is_not_the_long_one(seed):
    """Most of the motion is about the long axis; the axis sought is horizontal."""
    rng = np.random.default_rng(seed)
    frame = Rotation.random(rng=rng)
    up, axis, third = frame.as_matrix().T
    turns = rng.normal(size=(400, 3)) * [5.0, 1.0, 0.1]
    found = principal_horizontal_axis(turns @ np.array([up, axis, third]), up)
    assert abs(found @ up) < 1e-9
    assert abs(found @ axis) > np.cos(np.radians(5.0))
    np.testing.assert_allclose(np.linalg.norm(found), 1.0)


def test_the_leg_swings_forward_faster_than_back():
    """Flexion is about minus left: a rate skewed to positive flexion gives an axis to the left."""
    left = np.array([0.0, 1.0, 0.0])
    phase = np.linspace(0.0, 20 * np.pi, 4000, endpoint=False)
    flexion = np.cos(phase) + 0.3 * np.cos(2 * phase)  # skewness 0.77
    rate = np.outer(-flexion, left)
    assert swing_sign(rate, left) == 1
    assert swing_sign(rate, -left) == -1
    # third moment 0.75 a, power (1 + a^2) / 2: for a = 0.03 the skewness is 0.06, below 0.1
    weak = np.outer(-(np.cos(phase) + 0.03 * np.cos(2 * phase)), left)
    assert swing_sign(weak, left) == 0
    stronger = np.outer(-(np.cos(phase) + 0.06 * np.cos(2 * phase)), left)
    assert swing_sign(stronger, left) == 1
    assert swing_sign(np.zeros((0, 3)), left) == swing_sign(np.zeros((9, 3)), left) == 0


def test_the_excursion_of_a_constant_rate_is_half_its_angle():
    axis = np.array([0.6, 0.8, 0.0])
    rate = np.tile(0.4 * axis, (1000, 1))
    assert excursion_rad(rate, axis, RATE_HZ) == pytest.approx(0.5 * 0.4 * 10.0, rel=2e-3)
    assert excursion_rad(-rate, axis, RATE_HZ) == pytest.approx(-2.0, rel=2e-3)


def test_a_frame_of_up_and_left():
    up, left = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    frame = frame_from_left(up, left)
    np.testing.assert_allclose(frame.apply(up), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(frame.apply(left), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(frame.apply(np.cross(left, up)), [1, 0, 0], atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_smallest_rotation_aligns_up_with_z(seed):
    up = np.random.default_rng(seed).normal(size=3)
    up /= np.linalg.norm(up)
    frame = frame_from_gravity(up)
    np.testing.assert_allclose(frame.apply(up), [0, 0, 1], atol=1e-9)
    assert frame.magnitude() == pytest.approx(np.arccos(up[2]), abs=1e-6)


def test_upright_and_upside_down():
    assert frame_from_gravity(np.array([0.0, 0.0, 1.0])).magnitude() == 0.0
    turned = frame_from_gravity(np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(turned.apply([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0], atol=1e-12)
