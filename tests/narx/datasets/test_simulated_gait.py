"""The simulated data set: its physics, its names, its reproducibility."""

import tracemalloc
from dataclasses import fields
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets.simulated_gait import LEGS, SPEEDS_KM_H, SimulatedGait
from narx.errors import UserError
from narx.kinematics.joint_angles import joint_angles
from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.body import TABLE_1
from narx.simulation.sensor import sensor_model
from narx.simulation.session import ErrorSource, draw_session

SHORT = {"treadmill_duration_s": 25.0}


def _rotation(wxyz):
    return Rotation.from_quat(wxyz, scalar_first=True)


@pytest.fixture(scope="module")
def ideal():
    source = SimulatedGait(ideal=True, segments=[*LEGS, "pelvis"], **SHORT)
    return source.load("S1", "fast", "1"), source.truth("S1", "fast", "1")


@pytest.fixture(scope="module")
def trial():
    return SimulatedGait(**SHORT).load("S2", "normal", "1")


# physics


@pytest.mark.parametrize("segment", [*LEGS, "pelvis"])
def test_gyroscope_integrated_from_the_true_start_gives_the_true_orientation(
    ideal, segment, integrated
):
    trial, truth = ideal
    true = _rotation(truth.sensor_wxyz[segment])
    rate = trial.imus[segment].gyroscope_rad_s
    found = integrated(rate, trial.sampling_rate_hz, true[1])
    error = (found[-1].inv() * true[-2]).magnitude()
    assert np.degrees(error) < 0.01


@pytest.mark.parametrize("segment", [*LEGS, "pelvis"])
def test_specific_force_is_the_second_derivative_of_the_place(ideal, segment):
    trial, truth = ideal
    place = truth.sensor_position_m[segment]
    step = 1.0 / trial.sampling_rate_hz
    plain = (place[2:] - 2.0 * place[1:-1] + place[:-2]) / step**2
    force = _rotation(truth.sensor_wxyz[segment]).apply(trial.imus[segment].accelerometer_m_s2)
    difference = force[1:-1] - plain - [0.0, 0.0, GRAVITY_M_S2]
    # central differences are only of second order, so errors remain at heel strikes
    assert np.sqrt(np.mean(difference**2)) < 0.03
    assert np.abs(difference).max() < 0.4
    # for scale: the accelerations reach several m/s^2
    assert np.abs(plain[trial.time_s[1:-1] > 10.0]).max() > 3.0


def test_specific_force_at_rest_is_gravity(ideal):
    trial, truth = ideal
    still = trial.time_s < 3.5
    for segment, imu in trial.imus.items():
        force = imu.accelerometer_m_s2[still]
        # postural sway
        assert np.linalg.norm(force, axis=1).mean() == pytest.approx(GRAVITY_M_S2, abs=0.01)
        up = _rotation(truth.sensor_wxyz[segment][still]).apply(force)
        np.testing.assert_allclose(up.mean(axis=0), [0, 0, GRAVITY_M_S2], atol=0.02)


def test_ideal_reference_gives_the_true_knee_angles(ideal):
    trial, truth = ideal
    for side in ("right", "left"):
        thigh, shank = (
            trial.reference[f"{segment}_{side}"].quaternion_wxyz for segment in ("thigh", "shank")
        )
        np.testing.assert_allclose(
            joint_angles(thigh, shank, side), truth.joint_angles[f"knee_{side}"], atol=1e-9
        )


def test_gyroscope_and_place_are_those_of_walking(ideal):
    trial, truth = ideal
    walking = trial.time_s > 10.0
    shank = np.degrees(np.linalg.norm(trial.imus["shank_right"].gyroscope_rad_s, axis=1))[walking]
    assert 250.0 < shank.max() < 600.0
    # in mid-stance the shank's sensor is nearly at rest
    strikes = trial.events["heel_strike_right"]
    stride = np.diff(strikes).mean()
    middle = np.interp(strikes[strikes > 10.0][:-2] + 0.3 * stride, trial.time_s, trial.time_s)
    force = np.linalg.norm(trial.imus["shank_right"].accelerometer_m_s2, axis=1)
    assert np.abs(np.interp(middle, trial.time_s, force) - GRAVITY_M_S2).max() < 2.0
    place = truth.sensor_position_m["pelvis"][walking]
    assert 0.015 < np.ptp(place[:, 2]) < 0.08
    assert 0.02 < np.ptp(place[:, 1]) < 0.15
    # on a treadmill the walker stays in place
    assert np.ptp(place[:, 0]) < 0.15


def test_legs_take_turns(ideal):
    events = ideal[0].events
    for right in events["heel_strike_right"][4:-1]:
        gap = np.abs(events["heel_strike_left"] - right).min()
        stride = np.diff(events["heel_strike_right"])[4:].mean()
        assert gap == pytest.approx(0.5 * stride, rel=0.1)
    # the foot leaves the ground at 58-68 % of the stride
    for side in ("right", "left"):
        strikes, offs = events[f"heel_strike_{side}"], events[f"toe_off_{side}"]
        k = np.searchsorted(offs, strikes[4:-1])
        stance = (offs[k] - strikes[4:-1]) / np.diff(strikes)[4:]
        assert np.all((stance > 0.58) & (stance < 0.70))


def test_heel_strikes_follow_the_shank_s_swing(ideal):
    # the shank swings forwards until just before its heel strikes
    trial, truth = ideal
    up = _rotation(truth.segment_wxyz["shank_right"]).apply([0.0, 0.0, 1.0])
    pitch = np.arctan2(-up[:, 0], up[:, 2])
    for strike in trial.events["heel_strike_right"][5:-1]:
        window = (trial.time_s > strike - 0.25) & (trial.time_s < strike + 0.25)
        peak = trial.time_s[window][np.argmax(pitch[window])]
        assert abs(peak - strike) < 0.12


@pytest.mark.parametrize("rate_hz", [100.0, 200.0])
def test_the_same_motion_at_another_rate(ideal, rate_hz):
    fine, fine_truth = ideal
    source = SimulatedGait(ideal=True, sampling_rate_hz=rate_hz, **SHORT)
    coarse, truth = source.load("S1", "fast", "1"), source.truth("S1", "fast", "1")
    # every fifth sample at 500 Hz coincides with the 100 Hz clock and every second one at 200 Hz
    fine_part, coarse_part = slice(None, None, 5), slice(None, None, round(rate_hz / 100.0))
    for segment in LEGS:
        a = _rotation(fine_truth.sensor_wxyz[segment][fine_part])
        b = _rotation(truth.sensor_wxyz[segment][coarse_part])
        assert np.degrees((a.inv() * b).magnitude().max()) < 1e-6
        fine_imu, coarse_imu = fine.imus[segment], coarse.imus[segment]
        np.testing.assert_allclose(
            coarse_imu.gyroscope_rad_s[coarse_part], fine_imu.gyroscope_rad_s[fine_part], atol=1e-6
        )
        np.testing.assert_allclose(
            coarse_imu.accelerometer_m_s2[coarse_part],
            fine_imu.accelerometer_m_s2[fine_part],
            atol=0.05,
        )
    for name, times in fine.events.items():
        np.testing.assert_allclose(times, coarse.events[name], atol=1e-9)


# instruments


def test_readings_stay_within_the_sensor_s_range_and_on_its_grid(trial):
    for imu in trial.imus.values():
        for signal, full_range in (
            (imu.gyroscope_rad_s, np.radians(900.0)),
            (imu.accelerometer_m_s2, 11 * GRAVITY_M_S2),
        ):
            counts = signal / (2 * full_range / 2**16)
            np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
            assert np.abs(counts).max() <= 2**15
            # guard against a signal that lies on the grid only because it is zero
            assert len(np.unique(np.round(counts))) > 1000


def test_a_narrow_range_clips():
    source = SimulatedGait(sensor="mpu6150", sampling_rate_hz=100.0, **SHORT)
    shank = source.load("S4", "fast", "1").imus["shank_right"]
    assert np.degrees(np.abs(shank.gyroscope_rad_s)).max() == pytest.approx(250.0, abs=0.02)


def test_reference_is_relative_to_the_calibration_posture(trial):
    for reference in trial.reference.values():
        assert reference.frame == "anatomical"
        still = reference.quaternion_wxyz[trial.time_s < 3.5]
        tilt = _rotation(still[np.isfinite(still[:, 0])]).magnitude()
        assert np.degrees(tilt).mean() < 1.5


def test_reference_differs_from_the_bone_by_published_amounts(trial):
    truth = SimulatedGait(**SHORT).truth("S2", "normal", "1")
    error = []
    for side in ("right", "left"):
        thigh, shank = (
            trial.reference[f"{segment}_{side}"].quaternion_wxyz for segment in ("thigh", "shank")
        )
        difference = joint_angles(thigh, shank, side) - truth.joint_angles[f"knee_{side}"]
        error.append(np.degrees(difference[trial.time_s > 10.0]))
    rms = np.sqrt(np.nanmean(np.square(error), axis=(0, 1)))
    assert np.all((rms > 0.2) & (rms < 8.0))


def test_calibration_movements_have_all_imus_of_the_leg(trial):
    calibration = trial.calibration
    assert set(calibration["still"]) == set(calibration["standing"]) == set(LEGS)
    for side in ("right", "left"):
        for movement in ("hip_abduction", "knee_flexion"):
            assert set(calibration[f"{movement}_{side}"]) == {f"thigh_{side}", f"shank_{side}"}
    for part in calibration.values():
        for imu in part.values():
            assert imu.sampling_rate_hz == pytest.approx(500.0)
            assert np.isfinite(imu.gyroscope_rad_s).all()


def test_the_table_tells_the_bias_better_than_a_person_who_sways():
    source = SimulatedGait(subjects=["S1", "S2"], conditions=["normal"], treadmill_duration_s=20.0)
    error = {"still": [], "standing": []}
    for trial in source.select():
        for segment in LEGS:
            session = draw_session(
                0, trial.subject, TABLE_1[trial.subject], sensor_model("physilog"), "random", LEGS
            )
            true = session.gyroscopes[segment].bias
            for part, errors in error.items():
                rate = trial.calibration[part][segment].gyroscope_rad_s
                errors.append(np.degrees(rate.mean(axis=0) - true))
    rms = {part: np.sqrt(np.mean(np.square(errors))) for part, errors in error.items()}
    assert rms["still"] < 0.02
    assert 0.02 < rms["standing"] < 0.2
    force = trial.calibration["still"]["thigh_right"].accelerometer_m_s2.mean(axis=0)
    assert np.linalg.norm(force) == pytest.approx(9.81, abs=0.4)


def test_calibration_and_walk_have_the_same_sensor(trial):
    # the same orientation on the leg: gravity in standing agrees, up to sway and drift
    for segment, imu in trial.imus.items():
        there = trial.calibration["standing"][segment].accelerometer_m_s2.mean(axis=0)
        here = imu.accelerometer_m_s2[trial.time_s < 3.5].mean(axis=0)
        angle = np.arccos(there @ here / np.linalg.norm(there) / np.linalg.norm(here))
        assert np.degrees(angle) < 2.0
        bias = trial.calibration["standing"][segment].gyroscope_rad_s.mean(axis=0)
        now = imu.gyroscope_rad_s[trial.time_s < 3.5].mean(axis=0)
        assert np.degrees(np.abs(bias - now)).max() < 0.6


# names, protocols


def test_index_of_the_treadmill():
    source = SimulatedGait()
    index = source.index()
    assert len(source) == 15
    assert list(index.columns) == ["subject", "condition", "trial", "speed_km_h", "duration_s"]
    assert (index["duration_s"] == 300.0).all()
    for condition, (mean, spread) in SPEEDS_KM_H.items():
        speeds = index.loc[index["condition"] == condition, "speed_km_h"]
        assert speeds.mean() == pytest.approx(mean, abs=2.5 * spread)
        assert speeds.std() < 3.0 * spread
    by_subject = index.pivot_table(index="subject", columns="condition", values="speed_km_h")
    assert np.all(by_subject["slow"] < by_subject["normal"])
    assert np.all(by_subject["normal"] < by_subject["fast"])


def test_a_treadmill_trial_begins_standing(trial):
    assert trial.n_samples == 12_500
    assert trial.starts_in_calibration_posture
    assert trial.straight
    assert trial.still_s == ((0.0, 4.0),)
    assert trial.walking_s == pytest.approx((4.0, trial.time_s[-1]))
    still = trial.time_s < 4.0
    for imu in trial.imus.values():
        rate = imu.gyroscope_rad_s - imu.gyroscope_rad_s[still].mean(axis=0)
        assert np.degrees(np.abs(rate[still])).max() < 8.0
        assert np.degrees(np.abs(rate[trial.time_s > 8.0])).max() > 60.0


@pytest.mark.parametrize("condition", ["normal", "abnormal"])
def test_stand_walk_stand(condition):
    source = SimulatedGait(
        protocol="stand_walk_stand", sensor="mpu6150", sampling_rate_hz=100.0, subjects=["S3"]
    )
    assert len(source) == 6
    for trial in source.select(condition=condition):
        (a, b), (c, d) = trial.still_s
        assert a == 0.0
        assert 3.0 <= b <= 5.0
        assert 2.9 <= d - c <= 5.0
        assert trial.walking_s == (b, c)
        strikes = sum(len(trial.events[f"heel_strike_{side}"]) for side in ("right", "left"))
        assert 3 <= strikes + 1 <= 5


def test_fewest_and_most_steps_occur_and_times_count_the_hand():
    source = SimulatedGait(
        protocol="stand_walk_stand", steps=(2, 3), trials_per_condition=8, subjects=["S1"],
        conditions=["normal"], ideal=True, sampling_rate_hz=50.0, segments=["pelvis"],
        handling_s=10.0,
    )  # fmt: skip
    steps = set()
    for trial in source:
        begin, end = trial.still_s[0]
        assert begin == 10.0
        assert 13.0 <= end <= 15.0
        assert 3.0 - 0.02 <= trial.time_s[-1] - trial.walking_s[1] <= 5.0
        steps.add(1 + sum(len(trial.events[f"heel_strike_{s}"]) for s in ("right", "left")))
    assert steps == {2, 3}
    on_treadmill = SimulatedGait(handling_s=10.0, treadmill_duration_s=25.0)
    assert (on_treadmill.index()["duration_s"] == 35.0).all()


def test_over_ground_the_walker_gets_somewhere():
    source = SimulatedGait(protocol="stand_walk_stand", steps=(12, 12))
    truth = source.truth("S1", "normal", "1")
    place = truth.sensor_position_m["thigh_right"]
    # twelve steps of some 0.6 m, the first and last ones shorter
    assert 4.0 < place[-1, 0] - place[0, 0] < 9.0
    assert np.abs(place[-1, 1:] - place[0, 1:]).max() < 0.1


def test_abnormal_walking_swings_the_legs_outwards():
    source = SimulatedGait(protocol="stand_walk_stand", steps=(8, 8), subjects=["S1"])
    ranges = {
        condition: np.degrees(
            source.truth("S1", condition, "1").joint_angles["hip_right"][:, 1].max()
        )
        for condition in ("normal", "abnormal")
    }
    assert ranges["abnormal"] > ranges["normal"] + 6.0


def test_drawn_subjects_and_pelvis():
    source = SimulatedGait(subjects=["V1", "V2"], segments=["pelvis"], conditions=["slow"], **SHORT)
    trials = list(source)
    assert [t.subject for t in trials] == ["V1", "V2"]
    assert set(trials[0].imus) == {"pelvis"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"subjects": ["S6"]}, "subject 'S6'"),
        (
            {"protocol": "stairs"},
            "protocol is 'stairs', expected one of treadmill, stand",
        ),
        ({"conditions": ["abnormal"]}, "no condition 'abnormal'; known are slow, normal, fast"),
        ({"segments": ["foot_right"]}, "no segment 'foot_right'"),
        ({"sensor": "xsens"}, "sensor is 'xsens', expected one of physilog, mpu6150"),
        ({"mounting": "glued"}, "mounting is 'glued', expected one of random, strapped"),
        ({"sampling_rate_hz": 0.0}, "sampling_rate_hz is 0.0, expected a number from 10 to"),
        ({"treadmill_duration_s": -1.0}, "treadmill_duration_s is -1.0"),
        ({"treadmill_duration_s": 4.0}, "treadmill_duration_s is 4.0, expected a number above 8"),
        ({"stand_s": (5.0, 3.0)}, "stand_s"),
        ({"steps": (5, 3)}, "steps"),
        ({"segments": []}, "segments"),
    ],
)
def test_wrong_parameters_are_refused_in_one_line(wrong, message):
    with pytest.raises(UserError, match="simulated_gait") as error:
        SimulatedGait(**wrong)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_errors_can_be_left_out_one_by_one(trial):
    def without(*sources):
        source = SimulatedGait(without=sources, **SHORT)
        return source.load("S2", "normal", "1"), source.truth("S2", "normal", "1")

    def parts(of):
        return {
            "gyroscope": of.imus["thigh_left"].gyroscope_rad_s,
            "accelerometer": of.imus["thigh_left"].accelerometer_m_s2,
            "reference": of.reference["thigh_left"].quaternion_wxyz,
            "still": of.calibration["still"]["thigh_left"].gyroscope_rad_s,
            "movement": of.calibration["hip_abduction_left"]["thigh_left"].gyroscope_rad_s,
        }

    measured = {"gyroscope", "movement"}
    touches = {
        "sensor_tissue": measured | {"accelerometer"},
        "marker_tissue": {"reference"},
        "landmarks": {"reference"},
        "gyroscope_gain": measured,
        "gyroscope_bias": measured | {"still"},
        "accelerometer": {"accelerometer"},
        "movements": {"movement"},
    }
    assert set(touches) == set(get_args(ErrorSource))
    for source, touched in touches.items():
        for name, values in parts(without(source)[0]).items():
            same = np.array_equal(values, parts(trial)[name], equal_nan=True)
            assert same == (name not in touched), (source, name)
    # only noise remains when all error sources are removed
    exact, truth = without(*get_args(ErrorSource))
    for segment in LEGS:
        bone, tracked, sensor = (
            _rotation(wxyz)
            for wxyz in (
                truth.segment_wxyz[segment],
                np.nan_to_num(exact.reference[segment].quaternion_wxyz, nan=0.5),
                truth.sensor_wxyz[segment],
            )
        )
        there = np.isfinite(exact.reference[segment].quaternion_wxyz).all(axis=1)
        assert np.degrees((bone.inv() * tracked).magnitude()[there]).max() < 1.0
        mounting = bone.inv() * sensor
        assert np.degrees((mounting[0].inv() * mounting).magnitude()).max() < 1e-6
        still = exact.calibration["still"][segment].gyroscope_rad_s
        assert np.degrees(np.abs(still.mean(axis=0))).max() < 0.05


def test_an_unknown_trial_is_refused():
    with pytest.raises(UserError, match="no condition 'running'"):
        SimulatedGait().load("S1", "running", "1")


# reproducibility


def _signals(trial):
    return np.column_stack(
        [
            array
            for segment in trial.imus
            for array in (
                trial.imus[segment].gyroscope_rad_s,
                trial.imus[segment].accelerometer_m_s2,
                trial.reference[segment].quaternion_wxyz,
            )
        ]
    )


def test_a_trial_depends_only_on_its_name_and_the_seed(trial):
    source = SimulatedGait(subjects=["S3", "S2"], conditions=["fast", "normal"], **SHORT)
    list(source.select(subject="S3"))
    again = source.load("S2", "normal", "1")
    np.testing.assert_array_equal(_signals(trial), _signals(again))
    for part, recordings in trial.calibration.items():
        for segment, imu in recordings.items():
            np.testing.assert_array_equal(
                imu.gyroscope_rad_s, again.calibration[part][segment].gyroscope_rad_s
            )


def test_another_seed_another_walk(trial):
    other = SimulatedGait(seed=1, **SHORT).load("S2", "normal", "1")
    assert np.abs(np.nan_to_num(_signals(trial) - _signals(other))).max() > 1.0


def test_fewer_segments_change_nothing_for_the_rest(trial):
    alone = SimulatedGait(segments=["shank_left"], **SHORT).load("S2", "normal", "1")
    np.testing.assert_array_equal(
        alone.imus["shank_left"].gyroscope_rad_s, trial.imus["shank_left"].gyroscope_rad_s
    )


def test_repetitions_differ_but_not_in_the_sensor():
    source = SimulatedGait(trials_per_condition=2, subjects=["S1"], conditions=["slow"], **SHORT)
    first, second = source
    assert np.abs(_signals(first) - _signals(second))[np.isfinite(_signals(first))].size
    a, b = (t.imus["thigh_right"].accelerometer_m_s2[:1500].mean(axis=0) for t in (first, second))
    np.testing.assert_allclose(a, b, atol=0.3)
    assert not np.array_equal(first.events["heel_strike_right"], second.events["heel_strike_right"])


def test_trials_stream_through_memory():
    source = SimulatedGait(subjects=["S1", "S2", "S3"], segments=["shank_right"], **SHORT)
    size = 25 * 500 * (1 + 6 + 4) * 8
    tracemalloc.start()
    for trial in source:
        n_samples = trial.n_samples
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert n_samples == 12_500
    # nine trials are generated; peak memory is that of generating one
    assert peak < 60 * size


def test_a_trial_has_names_and_metadata(trial):
    assert trial.name == "simulated_gait/S2/normal/1"
    assert any("simulated" in note for note in trial.notes)
    assert {f.name for f in fields(trial)} >= {"events", "calibration", "still_s"}


# comparison with a real walk


@pytest.mark.recordings
def test_simulated_joint_angles_resemble_a_real_walk(data_root):
    path = data_root / "opensim_gait" / "subject01_walk1_ik.mot"
    if not path.is_file():
        pytest.skip(f"no {path}")
    lines = path.read_text().splitlines()
    header = next(k for k, line in enumerate(lines) if line.startswith("time"))
    names = lines[header].split()
    values = np.array([line.split() for line in lines[header + 1 :] if line.strip()], dtype=float)
    real = {name: values[:, names.index(name)] for name in dict.fromkeys(names)}
    # the left heel strikes at 1.21 s, the right one at 0.60 and 1.83 s (vertical ground force and
    # markers); the left leg is there from mid-stance to the next loading
    stride_s, strike_s = 1.23, 1.21
    source = SimulatedGait(ideal=True, treadmill_duration_s=30.0)
    phase = np.linspace(-0.65, 0.3, 96)
    recorded_s = strike_s + phase * stride_s
    for name, joint, axis, least_r, most_deg in (
        ("-knee_angle_l", "knee_left", 0, 0.94, 8.0),
        ("hip_flexion_l", "hip_left", 0, 0.97, 4.0),
        # frontal-plane curves vary between people
        ("-hip_adduction_l", "hip_left", 1, 0.3, 5.0),
    ):
        sign = -1.0 if name.startswith("-") else 1.0
        recorded = np.interp(recorded_s, real["time"], sign * real[name.removeprefix("-")])
        simulated = []
        for subject in source.index()["subject"].unique():
            truth = source.truth(subject, "fast", "1")
            strikes = source.load(subject, "fast", "1").events["heel_strike_left"]
            when = strikes[10] + phase * (strikes[11] - strikes[10])
            angle = truth.joint_angles[joint][:, axis]
            simulated.append(np.degrees(np.interp(when, truth.time_s, angle)))
        mean = np.mean(simulated, axis=0)
        assert np.corrcoef(mean, recorded)[0, 1] > least_r, name
        difference = (mean - mean.mean()) - (recorded - recorded.mean())
        assert np.sqrt(np.mean(difference**2)) < most_deg, name


def test_drawn30_stands_for_thirty_drawn_walkers():
    source = SimulatedGait(subjects=("S1", "drawn30"), conditions=("normal",))
    assert source.index()["subject"].tolist() == ["S1", *(f"V{k}" for k in range(1, 31))]
    with pytest.raises(UserError, match="subject 'drawn0'"):
        SimulatedGait(subjects=("drawn0",))
