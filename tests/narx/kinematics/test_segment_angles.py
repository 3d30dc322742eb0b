"""Frames, signs and rates of segment angles, against scipy and finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.kinematics.segment_angles import (
    angles_from_orientation,
    axis_rates,
    clinical_rates,
    coupled_rates,
    gyroscope_xyz,
    mirror_angular_rate,
    mirror_quaternion,
    mirror_vector,
    orientation_from_angles,
    tilt_from_specific_force,
)

angles = st.tuples(st.floats(-3.0, 3.0), st.floats(-1.4, 1.4), st.floats(-3.0, 3.0))
MIRROR = np.diag([1.0, -1.0, 1.0])


def rotation(angles_rad):
    """``Rz(transverse) Rx(-frontal) Ry(-sagittal)``, one elementary rotation after another."""
    sagittal, frontal, transverse = angles_rad
    return (
        Rotation.from_rotvec([0, 0, transverse])
        * Rotation.from_rotvec([-frontal, 0, 0])
        * Rotation.from_rotvec([0, -sagittal, 0])
    )


@settings(max_examples=100, deadline=None)
@given(angles)
def test_there_and_back(angles_rad):
    quaternion = orientation_from_angles([angles_rad])
    found = Rotation.from_quat(quaternion[0], scalar_first=True)
    assert (found * rotation(angles_rad).inv()).magnitude() < 1e-9
    np.testing.assert_allclose(angles_from_orientation(quaternion), [angles_rad], atol=1e-7)


@settings(max_examples=100, deadline=None)
@given(angles, st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_rates_of_the_angles_are_those_of_a_small_rotation(angles_rad, rate_xyz):
    """A turn by the gyroscope for a short time changes the angles by their rates times it."""
    step_s = 1e-5
    half = Rotation.from_rotvec(np.multiply(rate_xyz, step_s / 2))
    now = rotation(angles_rad)
    both = [(now * turn).as_quat(scalar_first=True) for turn in (half.inv(), half)]
    change = np.diff(angles_from_orientation(both), axis=0)[0]
    change = (change + np.pi) % (2 * np.pi) - np.pi
    found = coupled_rates(axis_rates(rate_xyz), angles_rad)
    np.testing.assert_allclose(found, change / step_s, atol=1e-3)


def test_the_heading_is_continuous_beyond_half_a_turn():
    heading = np.linspace(0.0, 6 * np.pi, 500)
    turning = orientation_from_angles(np.column_stack([0 * heading + 0.3, 0 * heading, heading]))
    np.testing.assert_allclose(angles_from_orientation(turning)[:, 2], heading, atol=1e-9)
    turning[100:110] = np.nan  # unwrapped over the valid samples
    found = angles_from_orientation(turning)
    assert np.isnan(found[100:110]).all()
    np.testing.assert_allclose(found[110:, 2], heading[110:], atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(angles)
def test_tilt_of_a_resting_segment_is_its_angles(angles_rad):
    sagittal, frontal, transverse = angles_rad
    # sagittal beyond a quarter turn is the same posture by atan2, too
    force = rotation((sagittal, frontal, transverse)).inv().apply([0.0, 0.0, 9.81])
    found = tilt_from_specific_force(force)
    np.testing.assert_allclose(found, [sagittal, frontal], atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_mirrored_motion_is_seen_by_mirrored_sensors(seed):
    """``M R M`` turns mirrored vectors; its angular rate is the mirrored pseudovector."""
    rng = np.random.default_rng(seed)
    one = Rotation.random(rng=rng)
    turn = Rotation.from_rotvec(0.3 * rng.normal(size=3))
    mirrored, after = (
        Rotation.from_quat(mirror_quaternion(r.as_quat(scalar_first=True)), scalar_first=True)
        for r in (one, one * turn)
    )
    np.testing.assert_allclose(mirrored.as_matrix(), MIRROR @ one.as_matrix() @ MIRROR, atol=1e-12)
    vector = rng.normal(size=3)
    np.testing.assert_allclose(mirror_vector(vector), MIRROR @ vector)
    np.testing.assert_allclose(
        (mirrored.inv() * after).as_rotvec(), mirror_angular_rate(turn.as_rotvec()), atol=1e-9
    )


def test_rates_about_the_clinical_axes():
    np.testing.assert_array_equal(axis_rates([1.0, 2.0, 3.0]), [-2.0, -1.0, 3.0])
    np.testing.assert_array_equal(gyroscope_xyz([-2.0, -1.0, 3.0]), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(clinical_rates([1.0, 2.0, 3.0], "right"), [-2.0, -1.0, 3.0])
    np.testing.assert_array_equal(clinical_rates([1.0, 2.0, 3.0], "left"), [-2.0, 1.0, -3.0])
    np.testing.assert_array_equal(clinical_rates([1.0, 2.0, 3.0], None), [-2.0, -1.0, 3.0])


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_an_angle_that_is_missing_leaves_no_orientation(missing):
    known = np.zeros((3, 3))
    known[1, missing] = np.nan
    assert np.isnan(orientation_from_angles(known)).all(axis=1).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("function", "shapes"),
    [
        (axis_rates, [(9, 3)]),
        (gyroscope_xyz, [(9, 3)]),
        (angles_from_orientation, [(9, 4)]),
        (orientation_from_angles, [(9, 3)]),
        (tilt_from_specific_force, [(9, 3)]),
        (coupled_rates, [(9, 3), (9, 3)]),
    ],
)
def test_samples_of_single_precision_are_computed_in_double(function, shapes):
    rng = np.random.default_rng(0)
    values = [rng.normal(size=shape).astype(np.float32) for shape in shapes]
    found = function(*values)
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, function(*(one.astype(float) for one in values)))
