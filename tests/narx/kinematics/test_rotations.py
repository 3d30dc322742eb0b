"""Fast composition against scipy's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose, from_angles


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 5))
def test_compose_equals_scipy(seed, n):
    rng = np.random.default_rng(seed)
    many = Rotation.random(n, random_state=rng)
    more = Rotation.random(n, random_state=rng)
    one = Rotation.random(random_state=rng)
    ours = compose(one, many, more, one)
    assert np.degrees((ours.inv() * (one * many * more * one)).magnitude().max()) < 1e-6


@pytest.mark.parametrize("axes", ["ZXY", "YXZ", "X"])
def test_from_angles_equals_scipy(axes):
    angles = np.random.default_rng(0).uniform(-3, 3, (50, len(axes)))
    difference = from_angles(axes, angles).inv() * Rotation.from_euler(axes, angles)
    assert difference.magnitude().max() < 1e-12


def test_angles_of_single_precision_are_composed_in_double():
    angles = np.random.default_rng(0).uniform(-3, 3, (50, 3)).astype(np.float32)
    single, double = (from_angles("ZXY", one).as_quat() for one in (angles, angles.astype(float)))
    np.testing.assert_array_equal(single, double)
