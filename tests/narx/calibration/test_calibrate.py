"""Calibration recovers a known mounting from movements, on both sides, without a reference."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.calibration.reference import _heading_rad
from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import RecordingError, UserError
from narx.kinematics.segment_angles import coupled_rates, orientation_from_angles
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, ReferenceOrientation, Trial, kind_of

_RATE_HZ = 100.0
_BIAS = np.radians([0.7, -0.4, 1.1])


def _time(duration_s):
    return np.arange(0.0, duration_s, 1.0 / _RATE_HZ)


def _imu(segment, anatomical, mounting, bias=_BIAS):
    """Sensor that sees a motion of the (unmirrored) anatomical frame; no linear acceleration.

    `mounting` takes anatomical vectors to sensor vectors.
    """
    steps = anatomical[:-1].inv() * anatomical[1:]
    rate = steps.as_rotvec() * _RATE_HZ
    rate = np.vstack([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    force = anatomical.inv().apply([0.0, 0.0, GRAVITY_M_S2])
    return ImuRecording(
        segment,
        _time(len(rate) / _RATE_HZ)[: len(rate)],
        mounting.apply(rate) + bias,
        mounting.apply(force),
    )


def _lifts(angle_rad):
    """From neutral to an angle and back, three times, after a second of rest."""
    time = _time(10.0)
    return angle_rad * np.where(time > 1.0, 0.5 - 0.5 * np.cos(2 * np.pi * (time - 1.0) / 3.0), 0)


def _walk_angles(seconds=30.0, stand=3.0):
    """Sagittal, frontal, transverse of a walking right thigh; swing faster than stance."""
    time = _time(seconds)
    phase = 2 * np.pi * 0.9 * np.maximum(time - stand, 0.0)
    ramp = np.clip((time - stand) / 2.0, 0.0, 1.0)
    sagittal = np.radians(20.0) * (np.sin(phase + 0.35 * np.sin(phase)))
    frontal = np.radians(4.0) * np.sin(phase + 1.0)
    transverse = np.radians(6.0) * np.sin(phase + 2.0)
    return ramp[:, None] * np.column_stack([sagittal, frontal, transverse])


def _orientation(angles, side):
    """Unmirrored orientation of a right or left segment from clinical angles."""
    quaternion = orientation_from_angles(angles)
    if side == "left":
        quaternion = quaternion * np.array([1.0, -1.0, 1.0, -1.0])
    return Rotation.from_quat(quaternion, scalar_first=True)


def _trial(segment, mounting, *, heading=0.0, movements=True, frame="sensor", **changes):
    part, side = segment.split("_")
    still = np.zeros((500, 3))
    walk = _walk_angles()
    movement = np.zeros((len(_time(10.0)), 3))
    if part == "thigh":
        movement[:, 1] = _lifts(np.radians(30.0))  # abduction is positive on either side
        name = f"hip_abduction_{side}"
    else:
        movement[:, 0] = _lifts(np.radians(50.0))  # the dangling foot swings forward
        name = f"knee_flexion_{side}"
    turn = Rotation.from_euler("Z", heading)
    walked = turn * _orientation(walk, side)
    calibration = {"standing": {segment: _imu(segment, _orientation(still, side), mounting)}}
    if movements:
        calibration[name] = {segment: _imu(segment, _orientation(movement, side), mounting)}
    tracked = walked * mounting.inv() if frame == "sensor" else walked
    fields = {
        "straight": True,
        "starts_in_calibration_posture": True,
        "still_s": ((0.0, 2.9),),
        "calibration": calibration,
        "reference": {
            segment: ReferenceOrientation(segment, tracked.as_quat(scalar_first=True), frame)
        },
    } | changes
    trial = Trial(
        "made", "s", "c", "t", _RATE_HZ, {segment: _imu(segment, walked, mounting)}, **fields
    )
    return trial, walk


def _error_deg(found, mounting):
    """Angle between the found sensor-to-anatomical rotation and the true one."""
    return np.degrees((found * mounting).magnitude())


_seeds = st.integers(0, 2**31 - 1)


@settings(max_examples=15, deadline=None)
@given(
    seed=_seeds, side=st.sampled_from(["left", "right"]), part=st.sampled_from(["thigh", "shank"])
)
def test_functional_calibration_recovers_any_mounting(seed, side, part):
    mounting = Rotation.random(random_state=seed)
    segment = f"{part}_{side}"
    trial, walk = _trial(segment, mounting)
    calibrated = calibrate(trial, "functional")[segment]
    assert _error_deg(calibrated.sensor_to_anatomical, mounting) < 0.2
    assert calibrated.static_bias_rad_s == pytest.approx(_BIAS, abs=1e-6)
    # a left leg is mirrored: same angles, same signs
    assert np.degrees(np.abs(calibrated.reference_angles_rad - walk)).max() < 0.5
    assert calibrated.signals.initial_angles_rad is not None
    movement = {"thigh": "x hip abduction", "shank": "y passive knee flexion"}[part]
    assert f"functional: z standing, {movement}" in calibrated.notes


@settings(max_examples=10, deadline=None)
@given(seed=_seeds, side=st.sampled_from(["left", "right"]))
def test_walking_calibration_recovers_any_mounting(seed, side):
    mounting = Rotation.random(random_state=seed)
    segment = f"thigh_{side}"
    trial, walk = _trial(segment, mounting, movements=False)
    calibrated = calibrate(trial)[segment]
    # the walk's own frontal and transverse motion turns the principal axis a little
    assert _error_deg(calibrated.sensor_to_anatomical, mounting) < 9.0
    error = np.degrees(np.abs(calibrated.reference_angles_rad - walk))
    assert error[:, :2].max() < 3.0
    assert "walking" in " ".join(calibrated.notes)


def test_forward_and_backward_are_distinguished_without_the_reference():
    for side in ("left", "right"):
        for turned in (0.0, np.pi):
            mounting = Rotation.from_euler("Z", turned)
            trial, walk = _trial(f"thigh_{side}", mounting, movements=False, reference={})
            signals = calibrate(trial, "walking")[f"thigh_{side}"].signals
            truth = np.gradient(walk[:, 0], 1.0 / _RATE_HZ)
            assert np.corrcoef(signals.axis_rates_rad_s[:, 0], truth)[0, 1] > 0.97


@pytest.mark.parametrize("side", ["left", "right"])
def test_signals_are_the_derivatives_of_the_angles_in_all_axes(side):
    trial, walk = _trial(f"thigh_{side}", Rotation.random(random_state=2))
    signals = calibrate(trial)[f"thigh_{side}"].signals
    slope = np.gradient(walk, 1.0 / _RATE_HZ, axis=0)
    from_signals = coupled_rates(signals.axis_rates_rad_s, walk)
    assert np.abs(from_signals - slope)[350:-5].max() < 0.02 * np.abs(slope).max()
    # the bias is removed in the frame of the sensor
    assert np.abs(signals.axis_rates_rad_s[:250]).max() < 1e-9
    # the accelerometer shows a forward tilt as gravity along x; a left leg is mirrored as above
    expected = GRAVITY_M_S2 * np.sin(walk[:, 0])
    assert np.allclose(signals.specific_force_m_s2[:, 0], expected, atol=0.3)


@settings(max_examples=8, deadline=None)
@given(heading=st.floats(-3.1, 3.1), frame=st.sampled_from(["sensor", "anatomical"]))
def test_heading_of_the_calibration_posture_is_removed(heading, frame):
    trial, walk = _trial(
        "shank_left", Rotation.random(random_state=7), heading=heading, frame=frame
    )
    angles = calibrate(trial)["shank_left"].reference_angles_rad
    assert np.degrees(np.abs(angles - walk)).max() < 0.5


@pytest.mark.parametrize("frame", ["sensor", "anatomical"])
def test_the_posture_is_that_of_the_first_still_part(frame):
    """At the end the person stands leaning, and faces another way."""
    mounting = Rotation.random(random_state=3)
    trial, walk = _trial("thigh_right", mounting, frame=frame)
    walk = walk + np.clip((_time(30.0)[:, None] - 25.0) / 2.0, 0.0, 1.0) * [0.3, 0.1, 1.2]
    walk[2700:] = walk[2700]
    walked = _orientation(walk, "right")
    tracked = walked * mounting.inv() if frame == "sensor" else walked
    reference = ReferenceOrientation("thigh_right", tracked.as_quat(scalar_first=True), frame)
    lifts = {name: part for name, part in trial.calibration.items() if name != "standing"}
    trial = replace(
        trial, imus={"thigh_right": _imu("thigh_right", walked, mounting)},
        reference={"thigh_right": reference}, calibration=lifts,
        still_s=((0.0, 2.9), (27.2, 29.8)), starts_in_calibration_posture=False,
    )  # fmt: skip
    calibrated = calibrate(trial, "functional")["thigh_right"]
    assert _error_deg(calibrated.sensor_to_anatomical, mounting) < 0.5
    assert np.degrees(np.abs(calibrated.reference_angles_rad - walk)).max() < 1.0


def test_a_posture_that_the_reference_has_not_seen_is_none():
    """The first sample is the posture, and missing: the walk's heading stays."""
    trial, walk = _trial("thigh_right", Rotation.identity(), heading=0.3, still_s=())
    trial.reference["thigh_right"].quaternion_wxyz[0] = np.nan
    angles = calibrate(trial, "functional")["thigh_right"].reference_angles_rad
    assert np.degrees(np.abs(angles - walk - [0.0, 0.0, 0.3])[1:]).max() < 0.5


def test_standing_is_preferred_to_the_walk_for_the_vertical():
    """The thigh is flexed by 12 degrees on average in the walk, as most are."""
    mounting = Rotation.random(random_state=4)
    trial, walk = _trial("thigh_right", mounting, movements=False)
    walk = walk + np.clip((_time(30.0)[:, None] - 3.0) / 2.0, 0.0, 1.0) * [0.2, 0.0, 0.0]
    leaning = _imu("thigh_right", _orientation(walk, "right"), mounting)
    found = calibrate(replace(trial, imus={"thigh_right": leaning}), "walking")["thigh_right"]
    up = found.sensor_to_anatomical.apply(mounting.apply([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(up, [0.0, 0.0, 1.0], atol=1e-6)


def test_a_sensor_without_standing_is_upright_over_its_first_second():
    tilt = np.clip(_time(20.0) - 1.0, 0.0, 0.5)
    mounting = Rotation.from_euler("XY", [0.4, -0.2])
    leaning = _imu("imu1", Rotation.from_rotvec(np.outer(tilt, [0.0, 1.0, 0.0])), mounting)
    (found,) = calibrate(Trial("d", "s", "c", "t", _RATE_HZ, {"imu1": leaning}), "sensor").values()
    up = found.sensor_to_anatomical.apply(mounting.apply([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(up, [0.0, 0.0, 1.0], atol=1e-6)


def test_anatomical_reference_is_made_upright_in_the_posture():
    trial, walk = _trial("thigh_right", Rotation.identity(), frame="anatomical")
    markers = Rotation.from_euler("ZYX", [0.0, 0.12, -0.08])  # joint centres are not vertical
    reference = Rotation.from_quat(
        trial.reference["thigh_right"].quaternion_wxyz, scalar_first=True
    )
    tilted = ReferenceOrientation(
        "thigh_right", (reference * markers).as_quat(scalar_first=True), "anatomical"
    )
    trial = _trial("thigh_right", Rotation.identity(), reference={"thigh_right": tilted})[0]
    angles = calibrate(trial)["thigh_right"].reference_angles_rad
    assert np.degrees(np.abs(angles - walk)).max() < 0.6


def test_heading_misalignment_of_markers_is_removed_on_request():
    trial, walk = _trial("thigh_right", Rotation.identity(), frame="anatomical")
    reference = trial.reference["thigh_right"].quaternion_wxyz
    turned = Rotation.from_quat(reference, scalar_first=True) * Rotation.from_euler("Z", 0.2)
    tracked = turned.as_quat(scalar_first=True)
    tracked[500:730] = np.nan  # the rest keeps its time
    trial = _trial(
        "thigh_right",
        Rotation.identity(),
        reference={"thigh_right": ReferenceOrientation("thigh_right", tracked, "anatomical")},
    )[0]
    kept = calibrate(trial)["thigh_right"].reference_angles_rad
    removed = calibrate(trial, remove_heading_misalignment=True)["thigh_right"]
    assert np.degrees(np.nanmax(np.abs(kept - walk))) > 2.0
    assert np.degrees(np.nanmax(np.abs(removed.reference_angles_rad - walk))) < 0.5
    assert any("deg about the vertical" in note for note in removed.notes)


def test_turning_walk_has_no_transverse_reference_but_tilt():
    trial, walk = _trial("thigh_right", Rotation.identity(), straight=False)
    angles = calibrate(trial)["thigh_right"].reference_angles_rad
    assert np.isnan(angles[:, 2]).all()
    assert np.degrees(np.abs(angles - walk))[:, :2].max() < 0.5


def test_without_a_posture_the_heading_is_that_of_the_first_sample():
    trial, walk = _trial(
        "thigh_right", Rotation.identity(), heading=0.5, straight=False, still_s=(),
        starts_in_calibration_posture=False,
    )  # fmt: skip
    calibrated = calibrate(trial, "functional")["thigh_right"]
    orientation = Rotation.from_quat(calibrated.reference_wxyz, scalar_first=True)
    heading = orientation[[0, 1000]].as_euler("ZXY")[:, 0]
    np.testing.assert_allclose(heading, walk[[0, 1000], 2], atol=np.radians(0.3))
    assert abs(heading[0]) < 1e-9
    assert "heading of the first sample removed" in calibrated.notes


def test_the_heading_is_that_of_the_transverse_angle_however_tilted():
    tilted = orientation_from_angles([[0.5, 0.4, 0.7]])[0]
    assert _heading_rad(Rotation.from_quat(tilted, scalar_first=True)) == pytest.approx(0.7)


def test_a_short_walk_in_a_long_recording_is_refused():
    trial, _ = _trial("thigh_right", Rotation.identity(), movements=False, walking_s=(10.0, 10.5))
    with pytest.raises(RecordingError, match=r"0.5 s of walking by 'thigh_right' to calibrate"):
        calibrate(trial, "walking")


def test_missing_samples_stay_missing():
    trial, _ = _trial("thigh_right", Rotation.identity())
    imu = trial.imus["thigh_right"]
    imu.gyroscope_rad_s[700:720] = np.nan
    trial.reference["thigh_right"].quaternion_wxyz[900:950] = np.nan
    calibrated = calibrate(trial)["thigh_right"]
    assert np.isnan(calibrated.signals.axis_rates_rad_s[700:720]).all()
    assert np.isfinite(calibrated.signals.axis_rates_rad_s[:700]).all()
    assert np.isnan(calibrated.reference_angles_rad[900:950]).all()
    assert np.isfinite(calibrated.reference_angles_rad[:900]).all()


def test_sensors_that_are_no_legs_share_their_heading_at_rest():
    time = _time(20.0)
    ramp = np.clip((time - 2.0) / 2.0, 0.0, 1.0)
    first = Rotation.from_rotvec(np.outer(ramp * 0.6 * np.sin(time), [0.0, 1.0, 0.0]))
    second = Rotation.from_rotvec(np.outer(ramp * 0.9 * np.sin(0.7 * time), [0.0, 1.0, 0.0]))
    mountings = [Rotation.random(random_state=k) for k in (8, 9)]
    imus, reference = {}, {}
    for name, motion, mounting in zip(("imu1", "imu2"), (first, second), mountings, strict=True):
        imus[name] = _imu(name, motion, mounting)
        tracked = (motion * mounting.inv()).as_quat(scalar_first=True)
        reference[name] = ReferenceOrientation(name, tracked, "sensor")
    trial = Trial(
        "made",
        "s",
        "c",
        "t",
        _RATE_HZ,
        imus,
        reference,
        still_s=((0.0, 1.9),),
        starts_in_calibration_posture=True,
    )
    calibrated = calibrate(trial)
    a, b = (Rotation.from_quat(calibrated[name].reference_wxyz, scalar_first=True) for name in imus)
    assert np.degrees((a[:100].inv() * b[:100]).magnitude()).max() < 0.1
    true = (first.inv() * second).magnitude()
    assert (a.inv() * b).magnitude() == pytest.approx(true, abs=1e-3)
    # both segments rotate about the same axis, so the joint does too
    joint = (a.inv() * b).as_rotvec()
    axes = joint[true > 0.3] / np.linalg.norm(joint[true > 0.3], axis=1, keepdims=True)
    assert np.abs(axes @ axes[0]).min() > 0.999


def test_without_a_still_part_the_bias_stays_and_is_noted():
    trial, _ = _trial("thigh_right", Rotation.identity(), still_s=(), calibration={})
    calibrated = calibrate(trial, "walking")["thigh_right"]
    assert (calibrated.static_bias_rad_s == 0).all()
    assert any("bias unknown, not removed" in note for note in calibrated.notes)


def test_what_cannot_be_calibrated_is_refused_in_one_line():
    trial, _ = _trial("thigh_right", Rotation.identity(), movements=False)
    with pytest.raises(UserError, match="mode is 'magic', expected one of auto"):
        calibrate(trial, "magic")
    with pytest.raises(RecordingError, match="no hip abduction"):
        calibrate(trial, "functional")
    standing = trial.calibration["standing"]["thigh_right"]
    lazy, _ = _trial(
        "thigh_right",
        Rotation.identity(),
        calibration={
            "standing": {"thigh_right": standing},
            "hip_abduction_right": {"thigh_right": standing},
        },
    )
    with pytest.raises(RecordingError, match="deg away from the neutral posture"):
        calibrate(lazy)
    whole, _ = _trial("thigh_right", Rotation.identity())
    lift = whole.calibration["hip_abduction_right"]["thigh_right"]
    bias = standing.gyroscope_rad_s.mean(axis=0)
    for share, enough in ((0.1, False), (0.4, True)):  # of 30 deg, less than half on average
        smaller = replace(lift, gyroscope_rad_s=bias + share * (lift.gyroscope_rad_s - bias))
        weak = {"standing": {"thigh_right": standing},
                "hip_abduction_right": {"thigh_right": smaller}}  # fmt: skip
        if enough:
            calibrate(replace(whole, calibration=weak), "functional")
            continue
        with pytest.raises(RecordingError, match=r"leads -?1\.\d deg away"):
            calibrate(replace(whole, calibration=weak), "functional")
    in_g = ImuRecording(
        "thigh_right",
        standing.time_s,
        standing.gyroscope_rad_s,
        standing.accelerometer_m_s2 / GRAVITY_M_S2,
    )
    wrong_unit, _ = _trial(
        "thigh_right", Rotation.identity(), calibration={"standing": {"thigh_right": in_g}}
    )
    with pytest.raises(RecordingError, match=r"mean specific force is 1.00 m/s\^2"):
        calibrate(wrong_unit)


@pytest.mark.parametrize(
    ("duration_s", "size_rad", "message"),
    [
        (20.0, 0.3, "forward and backward cannot be distinguished"),
        (20.0, 0.003, r"hardly turns \(.* deg/s RMS\)"),
        (0.5, 0.3, "0.0 s of walking by 'thigh' .* in a recording of 0.5 s, expected at least 1 s"),
        (2.0, 0.3, "2.0 s of walking by 'thigh' are too short .* expected at least 3 s"),
    ],
)
def test_something_that_does_not_walk_is_refused(duration_s, size_rad, message):
    time = _time(duration_s)
    # the rate is not skewed: forward and backward swing are equally fast
    swing = Rotation.from_rotvec(np.outer(size_rad * np.sin(6 * np.pi * time), [0.0, 1.0, 0.0]))
    trial = Trial(
        "made", "s", "c", "t", _RATE_HZ, {"thigh": _imu("thigh", swing, Rotation.identity())}
    )
    with pytest.raises(RecordingError, match=message):
        calibrate(trial)


def test_kind_of():
    assert kind_of("thigh_left") == "thigh"
    assert kind_of("thigh") == "thigh"
    assert kind_of("imu1") == "imu1"


def _leg_trial(side, mountings, abduction_off=0.0, thigh_tissue=0.0, flexion_off=0.0, bias=_BIAS):
    """A leg that abducts and flexes its knee about axes rotated about z (angles in rad)."""
    still = np.zeros((500, 3))
    lift, swing = np.zeros((len(_time(10.0)), 3)), np.zeros((len(_time(10.0)), 3))
    lift[:, 1] = _lifts(np.radians(30.0))
    swing[:, 0] = _lifts(np.radians(50.0))

    def imu(segment, anatomical):
        return _imu(segment, anatomical, mountings[segment], bias)

    def turned(angles, off):
        turn = Rotation.from_euler("Z", off)
        return turn * _orientation(angles, side) * turn.inv()

    thigh, shank = f"thigh_{side}", f"shank_{side}"
    calibration = {
        "standing": {s: imu(s, _orientation(still, side)) for s in mountings},
        f"hip_abduction_{side}": {
            thigh: imu(thigh, turned(lift, abduction_off + thigh_tissue)),
            shank: imu(shank, turned(lift, abduction_off)),
        },
        f"knee_flexion_{side}": {
            thigh: imu(thigh, _orientation(0 * swing, side)),
            shank: imu(shank, turned(swing, flexion_off)),
        },
    }
    walk = {s: imu(s, _orientation(_walk_angles(), side)) for s in mountings}
    return Trial("made", "s", "c", "t", _RATE_HZ, walk, calibration=calibration)


@settings(max_examples=10, deadline=None)
@given(seed=_seeds, side=st.sampled_from(["left", "right"]))
def test_leg_calibration_recovers_any_mounting_and_halves_the_error_of_one_movement(seed, side):
    names = (f"thigh_{side}", f"shank_{side}")
    mountings = dict(zip(names, Rotation.random(2, random_state=seed), strict=True))
    exact = calibrate(_leg_trial(side, mountings))
    for segment, calibrated in exact.items():
        assert _error_deg(calibrated.sensor_to_anatomical, mountings[segment]) < 0.2
        assert any(note.startswith("leg:") for note in calibrated.notes)
    errors = {"abduction_off": 6.0, "thigh_tissue": 2.0, "flexion_off": -3.0}
    imperfect = _leg_trial(side, mountings, **{k: np.radians(v) for k, v in errors.items()})
    expected = {"leg": (3.5, 1.5), "functional": (8.0, -3.0)}
    for mode, degrees in expected.items():
        for (segment, calibrated), off in zip(
            calibrate(imperfect, mode).items(), degrees, strict=True
        ):
            # a rotation of the axis by `off` rotates the estimated frame by -off about z
            error = (calibrated.sensor_to_anatomical * mountings[segment]).as_rotvec(degrees=True)
            assert error == pytest.approx([0.0, 0.0, -off], abs=0.3), (mode, segment)


def test_the_bias_of_each_sensor_of_the_leg_is_removed():
    """Six deg/s are further than any movement leads, in ten seconds."""
    mountings = {"thigh_left": Rotation.identity(), "shank_left": Rotation.identity()}
    for sign in (1.0, -1.0):
        trial = _leg_trial("left", mountings, bias=np.full(3, sign * 0.1))
        for segment, calibrated in calibrate(trial, "leg").items():
            assert _error_deg(calibrated.sensor_to_anatomical, mountings[segment]) < 0.2


def test_an_abduction_that_the_shank_did_not_record_is_one_of_the_thigh():
    mountings = {"thigh_left": Rotation.identity(), "shank_left": Rotation.identity()}
    trial = _leg_trial("left", mountings)
    del trial.calibration["hip_abduction_left"]["shank_left"]
    for calibrated in calibrate(trial).values():
        assert any(note.startswith("functional:") for note in calibrated.notes)


def test_a_leg_without_its_other_sensor_falls_back_with_a_note():
    trial, _ = _trial("shank_right", Rotation.identity())
    assert any("functional" in note for note in calibrate(trial)["shank_right"].notes)
    with pytest.raises(RecordingError, match="leg of 'shank_right' lacks"):
        calibrate(trial, "leg")


@pytest.mark.parametrize(
    ("mode", "how"),
    [
        ("auto", "leg:"),
        ("leg", "leg:"),
        ("knee", "to minimise knee abduction"),
        ("functional", "functional:"),
    ],
)
def test_simulated_sensors_are_calibrated_to_their_bones(mode, how):
    source = SimulatedGait(subjects=["S2"], conditions=["normal"], treadmill_duration_s=20.0)
    trial = next(iter(source))
    truth = source.truth(trial.subject, trial.condition, trial.trial)
    for segment, calibrated in calibrate(trial, mode).items():
        assert how in " ".join(calibrated.notes)
        bone, sensor = (
            Rotation.from_quat(of[segment][:500], scalar_first=True)
            for of in (truth.segment_wxyz, truth.sensor_wxyz)
        )
        error = (calibrated.sensor_to_anatomical * (sensor.inv() * bone)).mean().as_rotvec()
        # gravity fixes two angles well; the third depends on how well the movement follows its axis
        assert np.degrees(np.abs(error[:2])).max() < 4.0, segment
        assert np.degrees(abs(error[2])) < 12.0, segment
