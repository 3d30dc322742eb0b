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


def test_movements_are_neither_exact_nor_identical():
    _, angles = _perform("hip_abduction_right")
    moving = np.degrees(angles["hip_right"])
    assert 0.3 < np.ptp(moving[:, 0]) < 15.0
    _, again = _perform("hip_abduction_right", seed=1)
    assert np.abs(moving - np.degrees(again["hip_right"])).max() > 1.0
