"""Rate and specific force against motions with closed-form solutions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.calculus import EDGE, second_derivative
from narx.simulation.inertial import angular_rate, specific_force

RATE_HZ = 500.0
TIME_S = np.arange(2000) / RATE_HZ
INNER = slice(EDGE, -EDGE)


@pytest.mark.parametrize("turns", [1.0, 40.0])
def test_rate_of_a_steady_turn_over_many_turns(turns):
    rate = np.array([0.3, -0.5, 0.2]) * turns
    orientation = Rotation.random(random_state=1) * Rotation.from_rotvec(TIME_S[:, None] * rate)
    found = angular_rate(orientation, RATE_HZ)[INNER]
    np.testing.assert_allclose(found, np.tile(rate, (len(found), 1)), atol=1e-7 * turns)


def test_rate_of_a_tumble():
    # R = Rz(a) Rx(b): the body rate is (b', a' sin b, a' cos b)
    a, b = np.sin(5.0 * TIME_S), 0.8 * np.cos(7.0 * TIME_S)
    orientation = Rotation.from_euler("ZX", np.column_stack([a, b]))
    slope = 5.0 * np.cos(5.0 * TIME_S)
    expected = np.column_stack([-5.6 * np.sin(7.0 * TIME_S), slope * np.sin(b), slope * np.cos(b)])
    np.testing.assert_allclose(
        angular_rate(orientation, RATE_HZ)[INNER], expected[INNER], atol=1e-8
    )


def test_specific_force_at_rest_points_up():
    orientation = Rotation.random(10, random_state=0)
    force = specific_force(orientation, np.zeros((10, 3)))
    np.testing.assert_allclose(
        orientation.apply(force), np.tile([0, 0, GRAVITY_M_S2], (10, 1)), atol=1e-12
    )


def test_specific_force_in_free_fall_is_zero():
    falling = np.tile([0.0, 0.0, -GRAVITY_M_S2], (5, 1))
    assert np.abs(specific_force(Rotation.random(5, random_state=0), falling)).max() < 1e-12


def test_specific_force_of_a_pendulum():
    angle = 0.5 * np.sin(4.0 * TIME_S)
    rate, acceleration = 2.0 * np.cos(4.0 * TIME_S), -8.0 * np.sin(4.0 * TIME_S)
    orientation = Rotation.from_euler("Y", angle[:, None])
    arm = np.array([0.0, 0.0, -0.4])
    force = specific_force(orientation, second_derivative(orientation.apply(arm), RATE_HZ))
    # about y, hanging down: tangential -l alpha along x, centripetal l omega^2 along +z
    expected = np.column_stack(
        [
            -0.4 * acceleration - GRAVITY_M_S2 * np.sin(angle),
            np.zeros_like(angle),
            0.4 * rate**2 + GRAVITY_M_S2 * np.cos(angle),
        ]
    )
    np.testing.assert_allclose(force[INNER], expected[INNER], atol=1e-7)
