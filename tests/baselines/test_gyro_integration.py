import numpy as np
import pytest

from narx.baselines.gyro_integration import GyroIntegration
from narx.errors import UserError
from narx.method import SegmentSignals


def one_axis(rate, rate_hz=100.0, initial=None):
    rates = np.zeros((len(rate), 3))
    rates[:, 0] = rate
    force = np.tile([0.0, 0.0, 9.80665], (len(rate), 1))
    return SegmentSignals("thigh_right", rate_hz, rates, force, initial)


def test_the_trapezoid_integrates_a_ramp_exactly():
    t = np.arange(200) / 100.0
    angles = GyroIntegration().estimate(one_axis(3.0 * t, initial=np.array([0.5, 0.1, -0.2])))
    np.testing.assert_allclose(angles[:, 0], 0.5 + 1.5 * t**2, atol=1e-12)
    np.testing.assert_allclose(angles[:, 1:], np.tile([0.1, -0.2], (200, 1)), atol=1e-15)


def test_the_rectangle_runs_half_a_sample_ahead():
    t = np.arange(200) / 100.0
    angles = GyroIntegration(rule="rectangle").estimate(one_axis(3.0 * t))
    np.testing.assert_allclose(angles[:, 0], 1.5 * t**2 + 3.0 * t * 0.005, atol=1e-12)


def test_coupled_integration_gives_the_true_angles_where_axis_by_axis_does_not(motion):
    walk = motion("half_turn", 500.0)
    coupled = GyroIntegration(coupled=True).estimate(walk.signals)
    np.testing.assert_allclose(coupled, walk.angles_rad, atol=np.deg2rad(0.05))
    axis_by_axis = GyroIntegration().estimate(walk.signals)
    assert np.abs(axis_by_axis - walk.angles_rad).max() > np.deg2rad(3.0)


def test_a_wrong_rule_is_one_clear_line():
    with pytest.raises(UserError, match=r"gyro_integration: rule is 'simpson', expected one of"):
        GyroIntegration(rule="simpson")
