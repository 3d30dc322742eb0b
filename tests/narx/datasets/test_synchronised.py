"""Sensors and anatomical orientations on two clocks."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets.synchronised import synchronised
from narx.kinematics.segment_angles import gyroscope_xyz, orientation_from_angles
from narx.recordings.trial import ImuRecording


def test_all_segments_share_the_mean_offset_and_long_gaps_of_the_markers_stay(motion):
    """Optical clocks that are 10 and 20 ms ahead: 15 ms are taken off both."""
    walk = motion("walking", duration_s=20.0)
    wxyz = orientation_from_angles(walk.angles_rad)
    hidden = wxyz.copy()
    hidden[1000:1003] = np.nan  # four intervals
    gyroscope = gyroscope_xyz(walk.signals.axis_rates_rad_s)
    force = walk.signals.specific_force_m_s2
    inertial = {
        name: ImuRecording(name, walk.time_s, gyroscope, force)
        for name in ("thigh_right", "shank_right")
    }
    optical = {
        "thigh_right": (walk.time_s + 0.010, hidden),
        "shank_right": (walk.time_s + 0.020, wxyz),
    }
    aligned = synchronised(inertial, optical, 100.0, "x", anatomical=True)
    for offset_s in aligned.clock_offset_s.values():
        assert offset_s == pytest.approx(-0.015, abs=5e-4)
    clock = aligned.imus["thigh_right"].time_s
    thigh = aligned.reference["thigh_right"]
    assert thigh.frame == "anatomical"
    # stamps 10 ms ahead, of which 15 are taken off: each pose is 5 ms early
    inner = np.flatnonzero((clock > 2.0) & (clock < 9.0))
    found = Rotation.from_quat(thigh.quaternion_wxyz[inner], scalar_first=True)
    late = [np.interp(clock[inner] + 0.005, walk.time_s, angle) for angle in walk.angles_rad.T]
    expected = Rotation.from_quat(orientation_from_angles(np.transpose(late)), scalar_first=True)
    assert np.degrees((found.inv() * expected).magnitude()).max() < 0.15
    missing = np.flatnonzero(np.isnan(thigh.quaternion_wxyz[:, 0]))
    assert 3 <= len(missing[(clock[missing] > 9.9) & (clock[missing] < 10.1)]) <= 5


def test_the_slower_of_two_optical_systems_has_no_gaps(motion):
    walk = motion("walking", duration_s=20.0)
    wxyz = orientation_from_angles(walk.angles_rad)
    gyroscope = gyroscope_xyz(walk.signals.axis_rates_rad_s)
    inertial = {
        name: ImuRecording(name, walk.time_s, gyroscope, walk.signals.specific_force_m_s2)
        for name in ("thigh_right", "shank_right")
    }
    optical = {
        "thigh_right": (walk.time_s, wxyz),
        "shank_right": (walk.time_s[::4], wxyz[::4]),
    }
    aligned = synchronised(inertial, optical, 100.0, "x")
    for one in aligned.reference.values():
        assert np.isfinite(one.quaternion_wxyz[50:-50]).all()
