"""Optically tracked sensors: faults, common clock and frame; joint and BROAD files."""

import functools
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets.broad import Broad
from narx.datasets.joint_1to3dof import Joint1To3Dof
from narx.datasets.tracked_sensor import (
    RawSensor,
    align_sensors,
    turn_frame,
)
from narx.datasets.tracking_faults import tracked_poses, without_spikes
from narx.errors import RecordingError, UserError
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import gyroscope_xyz, orientation_from_angles

_RATE_HZ = 100.0
_OFFSET_S = 0.0145
_REST_S = 2.0


@functools.cache
def _hand_motion(seed, duration_s=20.0):
    """Rest, then a smooth random motion: orientation and body rate as functions of time."""
    rng = np.random.default_rng(seed)
    fine = np.arange(-1.0, duration_s, 0.002)
    knots = np.arange(-1.0, duration_s + 2.0, 0.3)
    rate = CubicSpline(knots, rng.normal(scale=1.2, size=(len(knots), 3)))(fine)
    rate *= np.clip((fine - _REST_S) / 0.5, 0.0, 1.0)[:, None]
    orientation = [Rotation.random(random_state=seed)]
    for step in Rotation.from_rotvec(0.5 * (rate[1:] + rate[:-1]) / 500.0):
        orientation.append(orientation[-1] * step)
    matrices = Rotation.concatenate(orientation).as_matrix().reshape(-1, 9)
    to_matrix = CubicSpline(fine, matrices)
    return (
        lambda time: Rotation.from_matrix(to_matrix(time).reshape(-1, 3, 3)),
        CubicSpline(fine, rate),
    )


def _sensor_and_reference(seed, bias):
    time = np.arange(0.0, 18.0, 1 / _RATE_HZ)
    orientation, rate = _hand_motion(seed)
    mounting = Rotation.from_euler("XYZ", [0.02, -0.03, 0.01])
    happened = time - _OFFSET_S
    gyroscope = mounting.apply(rate(happened)) + bias
    force = mounting.apply(orientation(happened).inv().apply([0, 0, 9.80665]))
    return time, gyroscope, force, orientation(time).as_quat(scalar_first=True)


def test_spikes_are_taken_out_and_turns_are_not():
    time = np.arange(1000) / 50.0
    turn = Rotation.from_rotvec(np.outer(time, [0.0, 0.0, 4.0]))
    clean = turn.as_quat(scalar_first=True)
    spiked = clean.copy()
    for begin, length in ((100, 1), (300, 3), (700, 6)):
        away = Rotation.from_rotvec([2.0, 0.5, 0.0])
        spiked[begin : begin + length] = (turn[begin : begin + length] * away).as_quat(
            scalar_first=True
        )
    found, removed = without_spikes(time, spiked, 4.0)
    lost = np.isnan(found).all(axis=1)
    assert removed == lost.sum() == 10
    assert np.allclose(found[~lost], clean[~lost])
    untouched, none = without_spikes(time, clean, 4.0)
    assert none == 0
    assert np.array_equal(untouched, clean)


@pytest.mark.parametrize(
    ("angle_rad", "samples", "removed"),
    [(0.15, 1, 0), (0.25, 1, 1), (0.25, 9, 9), (0.25, 12, 0)],
)
def test_a_spike_is_short_and_twice_as_fast_as_the_gyroscope(angle_rad, samples, removed):
    """At 50 Hz, of a gyroscope that measures up to 4 rad/s: 0.16 rad a sample, up to 0.2 s."""
    away = np.zeros((200, 3))
    away[100 : 100 + samples, 0] = angle_rad
    poses = Rotation.from_rotvec(away).as_quat(scalar_first=True)
    found, n = without_spikes(np.arange(200) / 50.0, poses, 4.0)
    assert n == removed
    assert np.flatnonzero(np.isnan(found[:, 0])).tolist() == list(range(100, 100 + removed))


def test_turned_frame_keeps_vectors():
    body = Rotation.random(5, random_state=1)
    to_sensor = Rotation.random(random_state=2)
    sensor = Rotation.from_quat(
        turn_frame(body.as_quat(scalar_first=True), to_sensor), scalar_first=True
    )
    vector = np.array([1.0, 2.0, 3.0])
    assert np.allclose(sensor.apply(to_sensor.apply(vector)), body.apply(vector))


def save_joint(path, **changes):
    """Write a recording of two sensors in the format of the published data set."""
    columns, references = [], []
    for seed in (1, 2):
        _, gyroscope, force, quaternion = _sensor_and_reference(seed, [0.01, 0.0, -0.005])
        columns += [force, gyroscope]
        references.append(quaternion)
    data = {
        "rate": _RATE_HZ,
        "sensorData": np.hstack(columns),
        "ref": np.hstack(references),
    } | changes
    scipy.io.savemat(path, {"data": {k: v for k, v in data.items() if v is not None}})


def test_joint_file_with_known_offset_and_mounting(tmp_path):
    save_joint(tmp_path / "data_2D_07.mat")
    trial = next(iter(Joint1To3Dof(root=tmp_path)))
    assert trial.name == "joint_1to3dof/device/2D/07"
    assert trial.clock_offset_s["imu2"] == pytest.approx(_OFFSET_S, abs=5e-4)
    assert trial.still_s[0][1] == pytest.approx(_REST_S, abs=0.2)
    for segment, calibrated in calibrate(trial).items():
        assert calibrated.static_bias_rad_s == pytest.approx([0.01, 0, -0.005], abs=1e-3), segment
        assert np.degrees(np.abs(calibrated.reference_angles_rad[:50, :2])).max() < 0.3
    joint = grood_suntay(*(c.reference_wxyz for c in calibrate(trial).values()))
    assert np.degrees(np.abs(joint[:50])).max() < 0.5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensorData": None}, "no field 'data.sensorData'"),
        ({"ref": np.zeros((10, 7))}, r"data.ref has shape \(10, 7\)"),
        ({"ref": np.zeros((10, 8))}, "ref has 10"),
        ({"rate": 0.0}, "data_1D_09.mat: data.rate is 0.0, expected a positive number"),
    ],
)
def test_damaged_joint_files(tmp_path, changes, message):
    save_joint(tmp_path / "data_1D_09.mat", **changes)
    with pytest.raises(UserError, match=message):
        Joint1To3Dof(root=tmp_path).load("device", "1D", "09")


def save_broad(path, **changes):
    """Write a recording of one sensor in the format of the published data set."""
    time, gyroscope, force, quaternion = _sensor_and_reference(3, [0.0, 0.001, 0.008])
    data = {
        "imu_gyr": gyroscope,
        "imu_acc": force,
        "opt_quat": quaternion,
        "sampling_rate": _RATE_HZ,
        "movement": (time > _REST_S).astype(np.uint8),
    } | changes
    scipy.io.savemat(path, {k: v for k, v in data.items() if v is not None})


def test_a_gyroscope_without_a_sample_is_refused(tmp_path):
    gyroscope = _sensor_and_reference(3, [0.0, 0.001, 0.008])[1]
    save_broad(tmp_path / "99_lost.mat", imu_gyr=np.full_like(gyroscope, np.nan))
    with pytest.raises(RecordingError, match=r"99_lost.mat: 'imu': no sample of the gyroscope"):
        Broad(root=tmp_path).load("device", "lost", "99")


def test_a_quaternion_whose_length_overflows_is_refused():
    body = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))
    body[2, 0] = 1e300
    with pytest.raises(RecordingError, match=r"'imu': .* sample 3 has length inf, expected a unit"):
        tracked_poses("imu", np.arange(5.0), body)


def test_broad_file_scores_the_movement(tmp_path):
    save_broad(tmp_path / "99_made_up_motion.mat")
    trial = Broad(root=tmp_path).load("device", "made_up_motion", "99")
    assert trial.clock_offset_s["imu"] == pytest.approx(_OFFSET_S, abs=5e-4)
    assert (trial.scored == (trial.time_s > _REST_S)).mean() > 0.999
    half = Broad(root=tmp_path, sampling_rate_hz=50.0).load("device", "made_up_motion", "99")
    assert half.sampling_rate_hz == 50.0
    assert half.scored.mean() == pytest.approx(trial.scored.mean(), abs=0.01)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"movement": None}, "no variable 'movement'"),
        ({"imu_acc": np.zeros((3, 3))}, r"imu_acc has shape \(3, 3\)"),
        ({"movement": np.ones(1800)}, "does not begin with a rest"),
        ({"movement": 1.0}, r"imu_gyr has shape \(1800, 3\), expected \(1, 3\)"),
        ({"sampling_rate": [50.0, 60.0]}, "sampling_rate is .*, expected a positive number"),
    ],
)
def test_damaged_broad_files(tmp_path, changes, message):
    save_broad(tmp_path / "98_made_up.mat", **changes)
    with pytest.raises(UserError, match=message):
        Broad(root=tmp_path).load("device", "made_up", "98")


def _rates_agree(trial):
    """Correlation of reference and gyroscope body rates, an axis at a time."""
    worst = 1.0
    for calibrated in calibrate(trial).values():
        quaternion = calibrated.reference_wxyz
        there = np.isfinite(quaternion).all(axis=1)
        k = np.flatnonzero(there[:-2] & there[2:])
        before, after = (Rotation.from_quat(quaternion[i], scalar_first=True) for i in (k, k + 2))
        body = (before.inv() * after).as_rotvec() * trial.sampling_rate_hz / 2
        clinical = np.column_stack([-body[:, 1], -body[:, 0], body[:, 2]])
        gyroscope = calibrated.signals.axis_rates_rad_s[k + 1]
        worst = min(worst, *(np.corrcoef(clinical[:, a], gyroscope[:, a])[0, 1] for a in range(3)))
    return worst


@pytest.mark.recordings
def test_real_joint_recordings(data_root):
    root = data_root / "joint_1to3dof"
    if not root.is_dir():
        pytest.skip("no joint_1to3dof")
    source = Joint1To3Dof(root=root)
    assert len(source) >= 12
    for name in (("1D", "01"), ("3D", "03"), ("2D", "02")):
        trial = source.load("device", *name)
        # the clocks differ by one sample of 20 ms, in 3D_03 by two
        expected = 0.032 if name == ("3D", "03") else 0.018
        assert trial.clock_offset_s["imu1"] == pytest.approx(expected, abs=0.006)
        assert _rates_agree(trial) > 0.99
        if name == ("1D", "01"):
            assert any("tracking faults" in note for note in trial.notes)
            # a hinge: all in the sagittal plane
            joint = grood_suntay(*(c.reference_wxyz for c in calibrate(trial).values()))
            spread = np.nanpercentile(np.degrees(joint), [2, 98], axis=0)
            assert spread[1, 0] - spread[0, 0] > 150
            assert np.abs(spread[:, 1:]).max() < 5


@pytest.mark.recordings
def test_real_broad_recordings(data_root):
    root = data_root / "broad"
    if not root.is_dir():
        pytest.skip("no broad")
    trial = Broad(root=root).load("device", "undisturbed_slow_rotation_A", "01")
    assert trial.clock_offset_s["imu"] == pytest.approx(1 / 285.7, abs=0.002)
    assert trial.scored.mean() == pytest.approx(126.0 / 199.3, abs=0.01)
    assert _rates_agree(trial) > 0.99


def _raw_sensors():
    sensors = {}
    for segment, seed in (("thigh_right", 1), ("shank_right", 2)):
        time, gyroscope, force, quaternion = _sensor_and_reference(seed, np.zeros(3))
        sensors[segment] = [time, gyroscope, force, time.copy(), quaternion.copy()]
    return sensors


def _align(sensors):
    return align_sensors(
        {
            segment: RawSensor(
                np.column_stack([time, gyroscope]), np.column_stack([time, force]), np.zeros(3),
                optical_time, quaternion,
            )
            for segment, (time, gyroscope, force, optical_time, quaternion) in sensors.items()
        },
        _RATE_HZ, max_gap_s=0.03, max_optical_gap_s=0.03, where="sub-01_motion.tsv",
    )  # fmt: skip


@pytest.mark.parametrize(("length", "accepted"), [(0.88, False), (0.92, True), (1.12, False)])
def test_a_unit_quaternion_is_one_within_a_tenth(length, accepted):
    poses = np.tile([length, 0.0, 0.0, 0.0], (5, 1))
    if accepted:
        assert tracked_poses("imu", np.arange(5.0), poses)[1] == []
    else:
        with pytest.raises(RecordingError, match="expected a unit quaternion"):
            tracked_poses("imu", np.arange(5.0), poses)


@pytest.mark.parametrize(
    ("factor", "accepted"), [(0.45, False), (0.55, True), (1.9, True), (2.1, False)]
)
def test_a_gyroscope_is_at_most_a_factor_of_two_off(factor, accepted):
    sensors = _raw_sensors()
    sensors["thigh_right"][1] *= factor
    if accepted:
        assert set(_align(sensors).imus) == set(sensors)
    else:
        with pytest.raises(RecordingError, match=f"turns {factor:.3g}[0-9]* times as fast"):
            _align(sensors)


def test_sensors_share_the_mean_of_their_clock_offsets():
    sensors = _raw_sensors()
    sensors["shank_right"][0] = sensors["shank_right"][0] + 0.004
    aligned = _align(sensors)
    for offset_s in aligned.clock_offset_s.values():
        assert offset_s == pytest.approx(_OFFSET_S + 0.002, abs=5e-4)
    # the reference is on the clock of the sensors
    clock = aligned.imus["thigh_right"].time_s
    _, rate = _hand_motion(1)
    speed = np.linalg.norm(aligned.imus["thigh_right"].gyroscope_rad_s, axis=1)
    inner = slice(300, -300)
    true = np.linalg.norm(rate(clock - _OFFSET_S), axis=1)
    np.testing.assert_allclose(speed[inner], true[inner], atol=0.02)
    turned = Rotation.from_quat(
        aligned.reference["thigh_right"].quaternion_wxyz[inner], scalar_first=True
    )
    optical = (turned[:-1].inv() * turned[1:]).magnitude() * _RATE_HZ
    moved = np.linalg.norm(rate(clock - _OFFSET_S - 0.002 + 0.5 / _RATE_HZ), axis=1)
    assert np.sqrt(np.mean((optical - moved[inner][:-1]) ** 2)) < 0.01


def test_a_static_bias_does_not_turn_the_frame():
    """Alignment with a bias that is known gives what it gives without one."""
    plain = _align(_raw_sensors())
    sensors = {
        segment: RawSensor(
            np.column_stack([time, gyroscope + 0.4]), np.column_stack([time, force]),
            np.full(3, 0.4), optical_time, quaternion,
        )
        for segment, (time, gyroscope, force, optical_time, quaternion) in _raw_sensors().items()
    }  # fmt: skip
    biased = align_sensors(sensors, _RATE_HZ, max_gap_s=0.03, max_optical_gap_s=0.03)
    for segment, one in plain.reference.items():
        other = biased.reference[segment].quaternion_wxyz
        there = np.isfinite(one.quaternion_wxyz[:, 0])
        np.testing.assert_allclose(other[there], one.quaternion_wxyz[there], atol=1e-6)


def test_poses_of_zeros_are_missing():
    sensors = _raw_sensors()
    sensors["thigh_right"][4][500:510] = 0.0
    aligned = _align(sensors)
    assert any("10 optical samples of zeros are lost poses" in note for note in aligned.notes)
    quaternion = aligned.reference["thigh_right"].quaternion_wxyz
    assert 8 <= np.isnan(quaternion).all(axis=1).sum() <= 13


def _degrees(sensors):
    sensors["thigh_right"][1] *= 57.3


def _axes(sensors):
    sensors["thigh_right"][1] = sensors["thigh_right"][1][:, [1, 0, 2]]


def _mirrored(sensors):
    sensors["thigh_right"][1] = sensors["thigh_right"][1] * [1.0, -1.0, 1.0]


def _conjugate(sensors):
    sensors["thigh_right"][4] *= [1.0, -1.0, -1.0, -1.0]


def _exchanged(sensors):
    thigh, shank = sensors.values()
    thigh[1], shank[1] = shank[1], thigh[1]


def _latency(sensors):
    sensors["thigh_right"][3][700] = sensors["thigh_right"][3][699]


def _length(sensors):
    sensors["thigh_right"][4][300] *= 3.0


def _apart(sensors):
    for sensor in sensors.values():
        sensor[0] = sensor[0] + 1000.0


@pytest.mark.parametrize(
    ("contradict", "message"),
    [
        (_degrees, "'thigh_right': the gyroscope turns 57.3 times .*; deg/s in a column of rad/s"),
        (_axes, "'thigh_right': the gyroscope does not turn as its reference does .* exchanged"),
        (_mirrored, "'thigh_right': the gyroscope does not turn as its reference does .* mirrored"),
        (_conjugate, "'thigh_right': the gyroscope does not turn as .* or conjugate quaternions"),
        (_exchanged, "'thigh_right': (clock alignment: no offset|the gyroscope does not turn as)"),
        (_latency, "'thigh_right': the reference's time does not increase at its sample 701"),
        (_length, "'thigh_right': the orientation at the reference's sample 301 has length 3"),
        (_apart, "clock alignment|no common time"),
    ],
)
def test_a_sensor_and_a_reference_that_contradict_are_refused_by_file(contradict, message):
    sensors = _raw_sensors()
    contradict(sensors)
    with pytest.raises(RecordingError, match=message) as error:
        _align(sensors)
    assert str(error.value).startswith("sub-01_motion.tsv: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "change",
    [
        lambda rates: rates[:, [2, 1, 0]],
        lambda rates: rates * [-1.0, 1.0, 1.0],
        lambda rates: rates * [1.0, 1.0, -1.0],
    ],
)
def test_exchanged_axes_of_a_leg_are_refused_although_it_mostly_swings_about_one(motion, change):
    """A rotation explains most of what a leg measures, a reflection all of it."""
    walk = motion("walking", duration_s=20.0)
    body = orientation_from_angles(walk.angles_rad)
    rates = gyroscope_xyz(walk.signals.axis_rates_rad_s)

    up = Rotation.from_quat(body, scalar_first=True).inv().apply([0.0, 0.0, 9.80665])

    def align(rates):
        time = walk.time_s
        table, force = np.column_stack([time, rates]), np.column_stack([time, up])
        sensors = {"thigh": RawSensor(table, force, np.zeros(3), time, body)}
        return align_sensors(sensors, 100.0, max_gap_s=0.03, max_optical_gap_s=0.03, where="a.mat")

    align(rates)
    with pytest.raises(RecordingError, match=r"a.mat: 'thigh': .* exchanged or mirrored axes"):
        align(change(rates))


def _swinging(heading_rad_s):
    """A sensor lying at 70 degrees on a leg that swings about one axis while its person turns."""
    time = np.arange(0.0, 20.0, 0.01)
    inclination = Rotation.from_euler("x", 70.0, degrees=True)

    def orientation(at):
        angles = [heading_rad_s * at, 0.5 * np.sin(6.0 * at), 0.02 * np.sin(12.0 * at + 1.0)]
        return Rotation.from_euler("ZYX", np.column_stack(angles)) * inclination

    turn = orientation(time - 5e-4).inv() * orientation(time + 5e-4)
    force = orientation(time).inv().apply([0.0, 0.0, 9.80665])
    rates = turn.as_rotvec() / 1e-3 + np.random.default_rng(0).normal(scale=0.04, size=(2000, 3))
    tables = (np.column_stack([time, xyz]) for xyz in (rates, force))
    return RawSensor(*tables, np.zeros(3), time, orientation(time).as_quat(scalar_first=True))


def _align_one(sensor):
    return align_sensors(
        {"thigh": sensor}, 100.0, max_gap_s=0.03, max_optical_gap_s=0.03, where="a.mat"
    )


def test_conjugate_quaternions_of_a_leg_are_refused_by_gravity():
    """Conjugates of a swing about one axis are the swing seen from the body: down is its own z."""
    sensor = _swinging(heading_rad_s=0.0)
    _align_one(sensor)
    conjugate = replace(sensor, body_wxyz=sensor.body_wxyz * [1.0, -1.0, -1.0, -1.0])
    with pytest.raises(RecordingError, match=r"a.mat: .*'thigh' puts gravity (6[5-9]|7[0-5]) deg"):
        _align_one(conjugate)


def test_axes_in_another_order_are_refused_of_a_person_who_turns_round():
    """Two turns average the horizontal part of gravity; sin 70 cos 70 of it is along z."""
    sensor = _swinging(heading_rad_s=0.2 * np.pi)
    _align_one(sensor)
    exchanged = replace(sensor, gyroscope=sensor.gyroscope[:, [0, 2, 3, 1]])
    with pytest.raises(RecordingError, match=r"a.mat: .*'thigh' leaves [23]\.\d of 9.81 m/s\^2"):
        _align_one(exchanged)
