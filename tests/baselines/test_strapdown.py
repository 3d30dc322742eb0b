import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.strapdown import Strapdown
from narx.errors import UserError
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import angles_from_orientation
from narx.method import SegmentSignals


def test_it_gives_the_true_angles_where_axis_by_axis_does_not(motion):
    walk = motion("half_turn", 500.0)
    angles = Strapdown().estimate(walk.signals)
    np.testing.assert_allclose(angles, walk.angles_rad, atol=np.deg2rad(0.02))
    axis_by_axis = GyroIntegration().estimate(walk.signals)
    assert np.abs(axis_by_axis - walk.angles_rad).max() > np.deg2rad(3.0)


def test_a_constant_rate_is_one_rotation():
    rates = np.tile([0.4, -0.3, 0.7], (101, 1))
    force = np.zeros((101, 3))
    angles = Strapdown().estimate(SegmentSignals("s", 100.0, rates, force))
    # sagittal is -y and frontal is -x in the anatomical frame
    turned = Rotation.from_rotvec(np.linspace(0.0, 1.0, 101)[:, None] * [0.3, -0.4, 0.7])
    expected = angles_from_orientation(turned.as_quat(scalar_first=True))
    np.testing.assert_allclose(angles, expected, atol=1e-12)


def test_the_heading_starts_where_it_was_even_beyond_half_a_turn():
    start = np.array([0.1, 0.2, 7.5])
    signals = SegmentSignals("s", 100.0, np.zeros((5, 3)), np.zeros((5, 3)), start)
    np.testing.assert_allclose(Strapdown().estimate(signals), np.tile(start, (5, 1)), atol=1e-12)


@pytest.mark.parametrize("rule", ["trapezoid", "rectangle"])
def test_sample_by_sample_it_is_the_same_beyond_half_a_turn(rule):
    """Two and a half turns to one side and back, with some tilt."""
    time_s = np.arange(800) / 100.0
    rates = np.stack([0.3 * np.sin(time_s), 0.2 * np.cos(time_s), 4.0 * np.sin(time_s)], axis=1)
    start = np.array([0.1, -0.2, 3.0])
    signals = SegmentSignals("s", 100.0, rates, np.zeros((800, 3)), start)
    angles = Strapdown(rule).estimate(signals)
    assert np.ptp(angles[:, 2]) > 7.0
    stream = OrientationStream(Strapdown(rule), 100.0, initial_angles_rad=start)
    np.testing.assert_allclose(stream.update_block(rates).angles_rad, angles, atol=1e-9)


def test_a_rectangle_is_of_the_later_rate():
    rates = np.zeros((3, 3))
    rates[:, 0] = [5.0, 1.0, 3.0]
    signals = SegmentSignals("s", 10.0, rates, np.zeros((3, 3)))
    for rule, expected in (("rectangle", [0.0, 0.1, 0.4]), ("trapezoid", [0.0, 0.3, 0.5])):
        np.testing.assert_allclose(Strapdown(rule).estimate(signals)[:, 0], expected, atol=1e-12)


def test_a_wrong_rule_is_one_clear_line():
    with pytest.raises(UserError, match=r"strapdown: rule is 'simpson', expected one of"):
        Strapdown(rule="simpson")
