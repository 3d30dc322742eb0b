"""Soft tissue, markers and mounting."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.simulation.body import Body
from narx.simulation.markers import FRAME_SD_DEG, NOISE_SD_DEG, Markers, draw_markers, track
from narx.simulation.sensor import sensor_model
from narx.simulation.session import draw_session
from narx.simulation.skeleton import move
from narx.simulation.soft_tissue import (
    MARKER_GAIN,
    SENSOR_GAIN,
    SHARED_VARIANCE,
    SoftTissue,
    draw_skin,
    draw_soft_tissue,
)
from narx.simulation.walker import JOINTS

BODY = Body(1.7, 65.0)
RATE_HZ = 100.0


def _motion(n, knee_deg=0.0):
    angles = {joint: np.zeros((n, 3)) for joint in JOINTS}
    angles["knee_right"][:, 0] = np.radians(knee_deg)
    return move(np.arange(n) / RATE_HZ, RATE_HZ, angles, BODY)


def _tissue(segment):
    rng = np.random.default_rng(0)
    return draw_soft_tissue(rng, segment, SENSOR_GAIN, draw_skin(rng, segment), True)


def test_sensor_and_markers_share_the_tissue_they_ride_on():
    model = sensor_model("physilog")
    gains = {"sensor": [], "markers": []}
    for seed in range(300):
        session = draw_session(seed, "S1", BODY, model, "random", ["thigh_right"])
        for name, tissue in (
            ("sensor", session.tissues["thigh_right"]),
            ("markers", session.markers["thigh_right"].tissue),
        ):
            gains[name].append(tissue.gains["knee_right"].ravel())
    sensor, markers = (np.array(gains[name]) for name in ("sensor", "markers"))
    np.testing.assert_allclose(sensor.std(axis=0), np.repeat(SENSOR_GAIN["thigh"], 3), rtol=0.15)
    np.testing.assert_allclose(markers.std(axis=0), np.repeat(MARKER_GAIN["thigh"], 3), rtol=0.15)
    correlation = [np.corrcoef(a, b)[0, 1] for a, b in zip(sensor.T, markers.T, strict=True)]
    assert np.mean(correlation) == pytest.approx(SHARED_VARIANCE, abs=0.06)


def test_tissue_rests_in_the_calibration_posture_and_follows_the_joint():
    tissue = _tissue("shank_right")
    assert tissue.rotation(_motion(3)).magnitude().max() == 0.0
    small, large = (tissue.rotation(_motion(1, a)).as_rotvec()[0] for a in (10.0, 60.0))
    np.testing.assert_allclose(large, 6.0 * small, atol=1e-12)


def test_tissue_of_the_thigh_follows_hip_and_knee():
    tissue = _tissue("thigh_left")
    assert set(tissue.gains) == {"hip_left", "knee_left"}


def test_markers_see_posture_as_zero_but_for_noise():
    rng = np.random.default_rng(0)
    markers = draw_markers(rng, "shank_right", draw_skin(rng, "shank_right"))
    wxyz = track(markers, _motion(2000), "shank_right", slice(None), rng)
    vector = 2.0 * wxyz[np.isfinite(wxyz[:, 0]), 1:]
    np.testing.assert_allclose(vector.mean(axis=0), 0.0, atol=np.radians(0.02))
    np.testing.assert_allclose(np.degrees(vector.std(axis=0)), NOISE_SD_DEG, rtol=0.1)


def test_markers_are_hidden_now_and_then_and_nan_as_a_row():
    rng = np.random.default_rng(0)
    markers = draw_markers(rng, "thigh_right", draw_skin(rng, "thigh_right"))
    hidden = []
    for _ in range(20):
        wxyz = track(markers, _motion(6000), "thigh_right", slice(None), rng)
        missing = np.isnan(wxyz)
        np.testing.assert_array_equal(missing.any(axis=1), missing.all(axis=1))
        hidden.append(missing[:, 0].mean())
    # one gap a minute, 0.2 s long
    assert np.mean(hidden) == pytest.approx(0.2 / 60.0, rel=0.7)


def test_a_misplaced_frame_turns_flexion_into_abduction():
    rng = np.random.default_rng(0)
    leaks = []
    for _ in range(200):
        markers = draw_markers(rng, "shank_right", draw_skin(rng, "shank_right"))
        wxyz = track(markers, _motion(5, 60.0), "shank_right", slice(None), rng)
        leaks.append(np.degrees(2.0 * wxyz[0, 1]))
    # the sine of the frame's error in a 60 degree turn, and the tissue on top
    expected = 2.0 * np.degrees(np.sin(np.radians(30.0))) * np.radians(FRAME_SD_DEG[2])
    assert np.std(leaks) == pytest.approx(
        np.hypot(expected, MARKER_GAIN["shank"][0] * 60.0), rel=0.2
    )


@pytest.mark.parametrize(("mounting", "least", "most"), [("random", 60, 180), ("strapped", 5, 40)])
def test_mounting(mounting, least, most):
    model = sensor_model("physilog")
    sizes, places = [], []
    for seed in range(60):
        session = draw_session(seed, "S1", BODY, model, mounting, ["thigh_right", "thigh_left"])
        right, left = session.mountings["thigh_right"], session.mountings["thigh_left"]
        sizes.append(np.degrees(right.orientation.magnitude()))
        places.append([right.offset_m, left.offset_m])
    assert least < np.mean(sizes) < most
    right, left = np.mean(places, axis=0)
    np.testing.assert_allclose(right, left * [1, -1, 1], atol=0.015)
    assert right[1] < -0.05  # lateral
    assert -BODY.thigh_m < right[2] < 0.0


def test_a_session_does_not_depend_on_the_segments_asked_for():
    model = sensor_model("physilog")
    one = draw_session(3, "S1", BODY, model, "random", ["shank_left"])
    all_ = draw_session(3, "S1", BODY, model, "random", ["pelvis", "thigh_left", "shank_left"])
    np.testing.assert_array_equal(
        one.gyroscopes["shank_left"].bias, all_.gyroscopes["shank_left"].bias
    )
    np.testing.assert_array_equal(
        one.mountings["shank_left"].offset_m, all_.mountings["shank_left"].offset_m
    )


def test_the_tissue_turns_by_the_gains_of_the_joint_and_wobbles_with_an_impact():
    """By hand: each axis is the sum over the joint's angles of gain times angle."""
    gain = np.array([[0.1, 0.2, 0.3], [0.0, 0.1, 0.0], [0.4, 0.0, 0.1]])
    tissue = SoftTissue("shank_right", {"knee_right": gain}, np.array([2.0, -1.0, 3.0]))
    motion = _motion(1, 60.0)
    motion.joint_angles["knee_right"][0, 1:] = [0.2, -0.1]
    flexion = np.radians(60.0)
    turned = np.array([0.1 * flexion + 0.04 - 0.03, 0.02, 0.4 * flexion - 0.01])
    np.testing.assert_allclose(tissue.rotation(motion).as_rotvec()[0], turned)
    hit = replace(motion, impact_m={"shank_right": np.array([[9.0, 9.0, 0.01]])})
    shaken = turned + np.array([0.02, -0.01, 0.03])
    np.testing.assert_allclose(tissue.rotation(hit).as_rotvec()[0], shaken)


def test_a_misplaced_frame_is_that_of_the_bone_and_still_in_the_posture():
    """By hand: the bone's rotation, seen from the frame."""
    frame = Rotation.from_rotvec([0.1, -0.2, 0.3])
    still = _tissue("shank_right").still()
    rng = np.random.default_rng(0)
    wxyz = track(Markers(still, frame), _motion(2000, 60.0), "shank_right", slice(None), rng)
    mean = Rotation.from_quat(wxyz[np.isfinite(wxyz[:, 0])], scalar_first=True).mean()
    bone = Rotation.from_euler("Y", 60.0, degrees=True)
    expected = frame.inv() * bone * frame
    assert np.degrees((expected.inv() * mean).magnitude()) < 0.05


def test_sensors_of_the_shank_are_on_its_inner_side_below_the_knee():
    model = sensor_model("physilog")
    sessions = [
        draw_session(seed, "S1", BODY, model, "random", ["shank_right", "shank_left"])
        for seed in range(60)
    ]
    right, left = (
        np.mean([s.mountings[f"shank_{side}"].offset_m for s in sessions], axis=0)
        for side in ("right", "left")
    )
    np.testing.assert_allclose(right, left * [1, -1, 1], atol=0.015)
    np.testing.assert_allclose(right[1:], [0.02 * BODY.girth, -0.4 * BODY.shank_m], atol=0.008)
    np.testing.assert_allclose(right[0], 0.035 * BODY.girth, atol=0.008)


@pytest.mark.parametrize(
    ("segment", "place_m", "length_m"),
    [
        ("pelvis", [-0.10, 0.0, 0.08], 0.0),
        ("thigh_right", [0.03, -0.075, 0.0], 0.245 * 1.7),
        ("thigh_left", [0.03, 0.075, 0.0], 0.245 * 1.7),
    ],
)
def test_sensors_are_behind_the_pelvis_and_half_way_down_the_side_of_the_thigh(
    segment, place_m, length_m
):
    """Of a stout person: thickness as the girth, length as the bone; 15 mm about each axis."""
    stout = Body(1.7, 4.0 * 22.0 * 1.7**2)
    model = sensor_model("physilog")
    places = np.array(
        [
            draw_session(seed, "S1", stout, model, "random", [segment]).mountings[segment].offset_m
            for seed in range(400)
        ]
    )
    expected = np.array(place_m) * [2.0, 2.0, 1.0] - [0.0, 0.0, 0.5 * length_m]
    np.testing.assert_allclose(places.mean(axis=0), expected, atol=0.003)
    np.testing.assert_allclose(places.std(axis=0), 0.015, rtol=0.12)


def test_only_a_sensor_wobbles_and_by_its_size():
    session = draw_session(0, "S1", BODY, sensor_model("physilog"), "random", ["shank_right"])
    assert session.tissues["shank_right"].wobble_axis.any()
    assert not session.markers["shank_right"].tissue.wobble_axis.any()
    rng = np.random.default_rng(0)
    skin = draw_skin(rng, "shank_right")
    axes = [
        [
            draw_soft_tissue(rng, "shank_right", SENSOR_GAIN, skin, wobbles).wobble_axis
            for _ in range(400)
        ]
        for wobbles in (True, False)
    ]
    # 20 rad per metre of the shock's displacement
    np.testing.assert_allclose(np.std(axes[0], axis=0), 20.0, rtol=0.1)
    assert np.abs(axes[1]).max() == 0.0


@pytest.mark.parametrize(("mass_kg", "girth"), [(22.0 * 1.7**2, 1.0), (88.0 * 1.7**2, 2.0)])
def test_girth_is_that_of_a_cylinder_as_tall(mass_kg, girth):
    assert Body(1.7, mass_kg).girth == pytest.approx(girth)
