"""Orientation from rates, against scipy's composition of the same small rotations."""

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.segment_angles import gyroscope_xyz, orientation_from_angles
from narx.kinematics.strapdown import strapdown_orientation


def test_each_interval_is_one_rotation_about_the_segments_own_axes():
    rates = np.random.default_rng(0).normal(size=(50, 3))
    start = np.array([0.3, -0.2, 0.1])
    found = strapdown_orientation(rates, 0.02, start)
    assert found.shape == (51, 4)
    orientation = Rotation.from_quat(orientation_from_angles(start)[0], scalar_first=True)
    for quaternion, rate in zip(found, [*gyroscope_xyz(rates), None], strict=True):
        here = Rotation.from_quat(quaternion, scalar_first=True)
        assert (here * orientation.inv()).magnitude() < 1e-9
        if rate is not None:
            orientation = orientation * Rotation.from_rotvec(0.02 * rate)
