import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.kinematics.joint_angles import grood_suntay, joint_angles, orientation_from_joint_angles
from narx.kinematics.segment_angles import mirror_quaternion, orientation_from_angles

angle = st.floats(-np.pi + 1e-3, np.pi - 1e-3)
abduction = st.floats(-1.5, 1.5)


def as_wxyz(rotation: Rotation) -> np.ndarray:
    return np.atleast_2d(rotation.as_quat(scalar_first=True))


def as_rotation(quaternion: np.ndarray) -> Rotation:
    return Rotation.from_quat(quaternion, scalar_first=True)


@given(angle, abduction, angle, st.integers(0, 2**32 - 1))
@settings(max_examples=200, deadline=None)
def test_round_trip_through_scipy(flexion, abduction, rotation, seed):
    proximal = Rotation.random(rng=np.random.default_rng(seed))
    distal = proximal * Rotation.from_euler("YXZ", [flexion, -abduction, rotation])
    found = grood_suntay(as_wxyz(proximal), as_wxyz(distal))
    np.testing.assert_allclose(found, [[flexion, abduction, rotation]], atol=1e-9)
    again = orientation_from_joint_angles(found, as_wxyz(proximal))
    assert (as_rotation(again) * distal.inv()).magnitude() < 1e-9


@given(angle, abduction, angle, st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_left_leg_is_the_mirror_image_of_the_right(flexion, abduction, rotation, seed):
    proximal = as_wxyz(Rotation.random(rng=np.random.default_rng(seed)))
    distal = orientation_from_joint_angles([[flexion, abduction, rotation]], proximal)
    right = joint_angles(proximal, distal, "right")
    left = joint_angles(mirror_quaternion(proximal), mirror_quaternion(distal), "left")
    np.testing.assert_allclose(right, [[flexion, abduction, rotation]], atol=1e-9)
    np.testing.assert_allclose(left, right, atol=1e-12)


@pytest.mark.parametrize(
    ("side", "axis", "far_end", "front"),
    [
        # how the far end (down) and the front of the shank move under +10 degrees of each angle,
        # with the thigh upright: x forward, y left
        ("right", 0, [-1, 0], None),
        ("left", 0, [-1, 0], None),
        ("right", 1, [0, -1], None),
        ("left", 1, [0, 1], None),
        ("right", 2, None, [0, 1]),
        ("left", 2, None, [0, -1]),
    ],
)
def test_signs_by_the_motion_of_the_shank(side, axis, far_end, front):
    angles = np.zeros((1, 3))
    angles[0, axis] = np.deg2rad(10)
    distal = orientation_from_joint_angles(angles)
    if side == "left":
        distal = mirror_quaternion(distal)
    upright = np.array([[1.0, 0.0, 0.0, 0.0]])
    np.testing.assert_allclose(joint_angles(upright, distal, side), angles, atol=1e-12)
    moved = np.sin(np.deg2rad(10))
    if far_end is not None:
        down = as_rotation(distal).apply([0, 0, -1])[0]
        np.testing.assert_allclose(down[:2], np.multiply(far_end, moved), atol=1e-12)
    if front is not None:
        ahead = as_rotation(distal).apply([1, 0, 0])[0]
        np.testing.assert_allclose(ahead[:2], [np.cos(np.deg2rad(10)), front[1] * moved])


def test_knee_flexion_is_thigh_less_shank_in_the_sagittal_plane():
    thigh = orientation_from_angles([[0.4, 0.0, 0.3]])
    shank = orientation_from_angles([[-0.5, 0.0, 0.3]])
    np.testing.assert_allclose(grood_suntay(thigh, shank), [[0.9, 0.0, 0.0]], atol=1e-12)


def test_turning_the_whole_leg_changes_nothing():
    generator = np.random.default_rng(1)
    thigh, shank, turn = (Rotation.random(20, rng=generator) for _ in range(3))
    before = grood_suntay(as_wxyz(thigh), as_wxyz(shank))
    after = grood_suntay(as_wxyz(turn * thigh), as_wxyz(turn * shank))
    np.testing.assert_allclose(after, before, atol=1e-9)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("distance", [0.0, 1e-12, 1e-9, 1e-8, 1e-6, 1e-3])
def test_near_gimbal_lock_the_angles_still_compose(sign, distance):
    generator = np.random.default_rng(2)
    proximal = Rotation.random(30, rng=generator)
    angles = generator.uniform(-3, 3, (30, 3))
    angles[:, 1] = sign * (np.pi / 2 - distance)
    distal = orientation_from_joint_angles(angles, as_wxyz(proximal))
    found = grood_suntay(as_wxyz(proximal), distal)
    assert np.isfinite(found).all()
    # near 90 degrees the accuracy is limited by double-precision quaternions
    np.testing.assert_allclose(found[:, 1], angles[:, 1], atol=1e-7)
    again = as_rotation(orientation_from_joint_angles(found, as_wxyz(proximal)))
    assert (again * as_rotation(distal).inv()).magnitude().max() < 3e-7
    if distance == 0.0:
        np.testing.assert_array_equal(found[:, 2], 0.0)


def test_missing_rows_stay_missing():
    quaternion = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    proximal, distal = quaternion.copy(), quaternion.copy()
    proximal[0] = np.nan
    distal[2, 1] = np.nan
    found = grood_suntay(proximal, distal)
    np.testing.assert_array_equal(np.isnan(found), [[True] * 3, [False] * 3, [True] * 3])
    composed = orientation_from_joint_angles([[np.nan, 0, 0], [0, 0, 0]])
    np.testing.assert_array_equal(np.isnan(composed).all(axis=1), [True, False])


def test_empty_and_wrong_input():
    assert grood_suntay(np.empty((0, 4)), np.empty((0, 4))).shape == (0, 3)
    with pytest.raises(ValueError, match="expected twice"):
        grood_suntay(np.ones((2, 4)), np.ones((3, 4)))
    with pytest.raises(ValueError, match="side is"):
        joint_angles(np.ones((1, 4)), np.ones((1, 4)), "both")
