"""Segments in space: angles are recovered, feet stay on the ground, sides are symmetric."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.kinematics.joint_angles import joint_angles
from narx.kinematics.segment_angles import mirror_quaternion, mirror_vector
from narx.simulation.body import Body
from narx.simulation.skeleton import (
    PRESSURE_CENTRE_PER_LEG,
    ROLL_RADIUS_PER_LEG,
    SIDES,
    forward_velocity,
    joint_centres,
    move,
    segment_orientations,
    stance_share,
)

BODY = Body(1.7, 65.0)
JOINTS = ("pelvis", "hip_right", "knee_right", "hip_left", "knee_left")


def _random_angles(n=50, size=0.6):
    rng = np.random.default_rng(0)
    return {joint: rng.uniform(-size, size, (n, 3)) for joint in JOINTS}


@pytest.mark.parametrize("side", SIDES)
def test_knee_angles_come_back_by_grood_and_suntay(side):
    angles = _random_angles()
    quaternions = {
        name: rotation.as_quat(scalar_first=True)
        for name, rotation in segment_orientations(angles).items()
    }
    knee = joint_angles(quaternions[f"thigh_{side}"], quaternions[f"shank_{side}"], side)
    np.testing.assert_allclose(knee, angles[f"knee_{side}"], atol=1e-12)


def test_signs_of_the_right_leg():
    angles = {joint: np.zeros((3, 3)) for joint in JOINTS}
    angles["hip_right"] = np.diag([0.3, 0.3, 0.3])
    thigh = segment_orientations(angles)["thigh_right"]
    down, front = thigh.apply([0.0, 0.0, -1.0]), thigh.apply([1.0, 0.0, 0.0])
    assert down[0, 0] > 0.2  # flexion: the knee goes forwards
    assert down[1, 1] < -0.2  # abduction: to the right
    assert front[2, 1] > 0.2  # internal rotation: the front turns to the left
    angles["pelvis"][:, 2] = 0.2
    hip = joint_centres(segment_orientations(angles), BODY)["thigh_right"]
    assert np.all(hip[:, 0] > 0.01)  # the right side of the pelvis goes forwards


def test_the_left_leg_mirrors_the_right_one():
    angles = _random_angles()
    angles["pelvis"][:, 1:] = 0.0
    angles["hip_left"], angles["knee_left"] = angles["hip_right"], angles["knee_right"]
    orientations = segment_orientations(angles)
    centres = joint_centres(orientations, BODY)
    for segment in ("thigh", "shank"):
        mirrored = mirror_quaternion(orientations[f"{segment}_left"].as_quat(scalar_first=True))
        difference = orientations[f"{segment}_right"].inv() * Rotation.from_quat(
            mirrored, scalar_first=True
        )
        assert difference.magnitude().max() < 1e-12
        np.testing.assert_allclose(
            centres[f"{segment}_right"], mirror_vector(centres[f"{segment}_left"]), atol=1e-12
        )


def test_standing_puts_the_ankles_where_they_belong():
    motion = move(np.arange(3.0), 1.0, {joint: np.zeros((3, 3)) for joint in JOINTS}, BODY)
    ankle = motion.position("shank_right", np.array([0.0, 0.0, -BODY.shank_m]))
    np.testing.assert_allclose(
        ankle, np.tile([0.0, -0.5 * BODY.hip_distance_m, BODY.ankle_height_m], (3, 1)), atol=1e-12
    )
    # Winter (2009), Fig. 4.1: the hip at 0.53 of the height
    assert BODY.leg_m == pytest.approx(0.530 * BODY.height_m, abs=0.001)
    # Bell et al. (1990): the hips a tenth of the height apart
    assert ankle[0, 1] == pytest.approx(-0.05 * BODY.height_m)


def test_stance_share_hands_over_in_double_support():
    toe_off, lag = 0.64, 0.51
    phase = np.linspace(-1.0, 2.0, 3001)
    share = stance_share(phase, toe_off, lag)
    stride = np.mod(phase, 1.0)
    right_alone = (stride > toe_off + lag - 1.0) & (stride < lag)
    left_alone = stride > toe_off
    np.testing.assert_allclose(share[right_alone], 1.0, atol=1e-12)
    np.testing.assert_allclose(share[left_alone], 0.0, atol=1e-12)
    assert np.abs(np.diff(share)).max() < 0.02
    assert share.min() >= -1e-12
    assert share.max() <= 1.0 + 1e-12


@pytest.mark.parametrize("window", [(0.0, 1.0), (0.1, 0.8), (-0.3, 1.0)])
def test_the_load_is_half_over_in_the_middle_of_its_window(window):
    """Double support lasts to the other foot's toe-off: 0.17 of the stride, then 0.11."""
    toe_off, lag = 0.64, 0.53
    middle, end = 0.5 * (window[0] + window[1]), window[1]
    to_right, to_left = toe_off + lag - 1.0, toe_off - lag
    moments = np.array(
        [
            1.0 + middle * to_right, 1.0 + window[0] * to_right, 1.0 + end * to_right,
            lag + middle * to_left, lag + window[0] * to_left, lag + end * to_left,
        ]
    )  # fmt: skip
    share = stance_share(moments, toe_off, lag, window)
    np.testing.assert_allclose(share, [0.5, 0.0, 1.0, 0.5, 1.0, 0.0], atol=1e-9)
    # just inside the window the transfer has begun, and is not over
    inside = 0.1 * (window[1] - window[0])
    early, late = (1.0 + (at + d) * to_right for at, d in ((window[0], inside), (end, -inside)))
    share = stance_share(np.array([early, late]), toe_off, lag, window)
    assert 0.0 < share[0] < 0.01 < 0.99 < share[1] < 1.0


def test_a_stance_foot_rolls_without_slipping():
    # the right leg as a rigid rod over its rolling foot, the left one in the air
    rate_hz, n = 500.0, 500
    pitch = np.linspace(-0.3, 0.3, n)
    angles = {joint: np.zeros((n, 3)) for joint in JOINTS}
    angles["hip_right"][:, 0] = -pitch
    velocity = forward_velocity(angles, np.full(n, 0.3), 0.62, 0.5, BODY, rate_hz)[20:-20]
    # analytic: hip over the centre of the arc, which moves by radius times pitch
    radius = ROLL_RADIUS_PER_LEG * BODY.leg_m
    above, ahead = BODY.leg_m - radius, PRESSURE_CENTRE_PER_LEG * BODY.leg_m
    speed = rate_hz * (pitch[1] - pitch[0])
    inner = pitch[20:-20]
    forwards = speed * (radius + above * np.cos(inner) + ahead * np.sin(inner))
    upwards = speed * (-above * np.sin(inner) + ahead * np.cos(inner))
    np.testing.assert_allclose(velocity[:, 0], forwards, atol=1e-8)
    np.testing.assert_allclose(velocity[:, 1], 0.0, atol=1e-8)
    np.testing.assert_allclose(velocity[:, 2], upwards, atol=1e-8)


def test_the_pelvis_turns_about_z_then_x_then_y():
    """Transverse, frontal, sagittal, each about the axis as turned by those before."""
    angles = {joint: np.zeros((1, 3)) for joint in JOINTS}
    angles["pelvis"][0] = [0.2, 0.3, 0.4]
    z, x, y = (Rotation.from_rotvec(v) for v in ([0, 0, 0.4], [0.3, 0, 0], [0, 0.2, 0]))
    found = segment_orientations(angles)["pelvis"][0]
    assert (found.inv() * (z * x * y)).magnitude() < 1e-12


def test_an_impact_moves_what_it_hits():
    motion = move(np.arange(3.0), 1.0, {joint: np.zeros((3, 3)) for joint in JOINTS}, BODY)
    hit = replace(motion, impact_m={"shank_right": np.full((3, 3), 0.01)})
    at = np.array([0.02, 0.0, -0.1])
    moved = hit.position("shank_right", at) - motion.position("shank_right", at)
    np.testing.assert_allclose(moved, 0.01)
    np.testing.assert_array_equal(hit.position("shank_left", at), motion.position("shank_left", at))


@pytest.mark.parametrize(("of_double_support", "level"), [(0.05, False), (0.9, True)])
def test_the_leading_foot_takes_over_level_motion_later_and_faster(of_double_support, level):
    """The right leg turns, the left one rests: which part of its demand is met."""
    rate_hz, n, toe_off, lag = 500.0, 100, 0.62, 0.5
    angles = {joint: np.zeros((n, 3)) for joint in JOINTS}
    angles["hip_right"][:, 0] = 0.2 - np.linspace(0.0, 0.1, n)

    def velocity(phase):
        return forward_velocity(angles, np.full(n, phase), toe_off, lag, BODY, rate_hz)[20:-20]

    share = velocity(of_double_support * (toe_off + lag - 1.0)) / velocity(0.3)
    if level:
        np.testing.assert_allclose(share[:, 0], 1.0)
        assert (share[:, 2] < 0.999).all()
    else:
        np.testing.assert_allclose(share[:, 0], 0.0, atol=1e-12)
        assert (share[:, 2] > 0.05).all()
