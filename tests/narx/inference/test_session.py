"""A leg from its sensors, against the simulator's truth and against the benchmark."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.calibration import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import RecordingError, UserError
from narx.inference import pretrained
from narx.inference.session import predict_session
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import orientation_from_angles
from narx.recordings.trial import ImuRecording

LEG = ("thigh_right", "shank_right")


@pytest.fixture(scope="module")
def trial():
    source = SimulatedGait(subjects=["S1"], conditions=["normal"], treadmill_duration_s=40)
    return next(iter(source))


@pytest.fixture(scope="module")
def method():
    return pretrained().method()


def _sensors(trial, segments=LEG):
    return {segment: trial.imus[segment] for segment in segments}


@pytest.fixture(scope="module")
def predicted(trial, method):
    return predict_session(_sensors(trial), method)


def test_the_knee_is_close_to_the_markers(trial, predicted):
    calibrated = calibrate(trial)
    truth = grood_suntay(*(calibrated[segment].reference_wxyz for segment in LEG))
    error = np.degrees(predicted.angles_rad["knee_right"] - truth)[trial.time_s > 8.0]
    rmse = np.sqrt(np.nanmean(error**2, axis=0))
    # flexion, abduction, rotation after calibration by walking (docs/generalisation.md)
    assert (rmse < [5.0, 5.0, 8.0]).all(), rmse


def test_strides_are_those_of_the_simulator(trial, predicted):
    true = trial.events["heel_strike_right"]
    found = predicted.contacts_s["right"]
    assert len(found) > 20
    inside = found[(found > true[0] - 0.1) & (found < true[-1] + 0.1)]
    off = np.array([np.abs(true - contact).min() for contact in inside])
    assert np.median(off) < 0.08


def test_exchanged_thigh_and_shank_are_noted(trial, method, predicted):
    """The shank turns more than the thigh, and a knee does not bend backwards."""
    exchanged = {
        segment: replace(trial.imus[other], segment=segment)
        for segment, other in zip(LEG, LEG[::-1], strict=True)
    }
    assert not any("exchanged" in note for note in predicted.notes)
    found = predict_session(exchanged, method)
    assert any("knee_right: the thigh turns" in note for note in found.notes)


def test_a_part_declared_still_has_to_be(trial, method):
    with pytest.raises(RecordingError, match=r"w: shank_right|w: thigh_right") as refused:
        predict_session(_sensors(trial), method, still_s=[(20.0, 25.0)], where="w")
    assert "still_s 20-25 s is not at rest" in str(refused.value)


def test_standard_deviations_add_up(predicted):
    squares = sum(predicted.std_rad[segment] ** 2 for segment in LEG)
    np.testing.assert_allclose(predicted.std_rad["knee_right"] ** 2, squares)


def test_a_filled_gap_is_added_to_the_standard_deviations(trial, method, predicted):
    sensors = _sensors(trial)
    thigh = sensors["thigh_right"]
    rates = thigh.gyroscope_rad_s.copy()
    rates[(trial.time_s > 25.0) & (trial.time_s < 25.4)] = np.nan
    sensors["thigh_right"] = replace(thigh, gyroscope_rad_s=rates)
    found = predict_session(sensors, method)
    assert any("of up to 0.4" in note and "filled" in note for note in found.notes)
    at = np.searchsorted(found.time_s, 25.45)
    for name in ("thigh_right", "knee_right"):
        before, now = predicted.std_rad[name][at], found.std_rad[name][at]
        added_deg = np.degrees(np.sqrt(np.maximum(now**2 - before**2, 0.0)))
        assert (added_deg > [4.0, 2.5, 30.0]).all(), (name, added_deg)
    np.testing.assert_allclose(
        found.std_rad["shank_right"][at], predicted.std_rad["shank_right"][at], rtol=0.2
    )


def test_mounting_and_shifted_clocks_change_nothing(trial, method, predicted):
    mounting = Rotation.from_euler("xyz", [50.0, -110.0, 20.0], degrees=True)
    sensors = _sensors(trial)
    shank = sensors["shank_right"]
    sensors["shank_right"] = replace(
        shank,
        gyroscope_rad_s=mounting.apply(shank.gyroscope_rad_s),
        accelerometer_m_s2=mounting.apply(shank.accelerometer_m_s2),
        time_s=shank.time_s + 1000.0,
    )
    other = predict_session(sensors, method)
    n = min(len(other.time_s), len(predicted.time_s))
    knees = [one.angles_rad["knee_right"][:n] for one in (other, predicted)]
    assert np.degrees(np.nanmax(np.abs(knees[0] - knees[1]))) < 2.5
    assert any("moved by -1000" in note for note in other.notes)


def test_all_joints_of_both_legs(method):
    segments = ("pelvis", "thigh_right", "shank_right", "thigh_left", "shank_left")
    source = SimulatedGait(
        subjects=["S1"], conditions=["normal"], treadmill_duration_s=30, segments=segments
    )
    result = predict_session(dict(next(iter(source)).imus), method)
    assert set(result.angles_rad) == {*segments, "hip_right", "hip_left", "knee_right", "knee_left"}
    assert set(result.contacts_s) == {"right", "left"}
    hip, pelvis, thigh = (
        result.angles_rad[name][:, 0] for name in ("hip_right", "pelvis", "thigh_right")
    )
    # nearly in the sagittal plane the hip's flexion is the thigh's against the pelvis
    assert np.degrees(np.abs(hip + pelvis - thigh).max()) < 3.0


def test_without_rest_the_start_is_unknown(trial, method):
    walking = {
        segment: ImuRecording(segment, imu.time_s[4000:], imu.gyroscope_rad_s[4000:],
                              imu.accelerometer_m_s2[4000:])
        for segment, imu in _sensors(trial).items()
    }  # fmt: skip
    notes = " ".join(predict_session(walking, method).notes)
    assert "start unknown" in notes
    with pytest.raises(RecordingError, match="start_pose=known needs the recording to begin with"):
        predict_session(walking, method, start_pose="known")


def test_a_bias_from_a_standing_recording_is_removed_once(trial, method):
    bias = np.radians([2.0, -3.0, 1.0])
    sensors, standing = {}, {}
    for segment, imu in _sensors(trial).items():
        # a walk that pauses, without standing at its begin and end
        rows = np.r_[4000:10_000, 0:1500, 10_000:16_000]
        values = imu.gyroscope_rad_s[rows] + bias, imu.accelerometer_m_s2[rows]
        sensors[segment] = ImuRecording(segment, imu.time_s[: len(rows)], *values)
        values = imu.gyroscope_rad_s[:1500] + bias, imu.accelerometer_m_s2[:1500]
        standing[segment] = ImuRecording(segment, imu.time_s[:1500], *values)
    notes = predict_session(sensors, method, parts={"standing": standing}).notes
    of_bias = [note for note in notes if "bias" in note]
    assert len(of_bias) == 2
    assert all("deg/s from recording 'standing' removed" in note for note in of_bias)
    # without that recording from the pause, which is not reported as unknown in addition
    notes = predict_session(sensors, method).notes
    of_bias = [note for note in notes if "bias" in note]
    assert len(of_bias) == 2
    assert all("from the quietest" in note for note in of_bias)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (lambda s: {"elbow": s["thigh_right"]}, {}, "segment 'elbow', expected some of foot_left"),
        (lambda s: {}, {}, "no recording given"),
        (lambda s: s, {"start_pose": "lying"}, "start_pose is 'lying', expected one of auto"),
        (lambda s: s, {"align": "x"}, "align is 'x'"),
        (lambda s: s, {"calibration": "x"}, "calibration is 'x', expected one of auto"),
        (lambda s: s | {"shank_right": replace(
            s["shank_right"], accelerometer_m_s2=s["shank_right"].accelerometer_m_s2 * np.nan)},
         {}, "'shank_right' has no accelerometer"),
        (lambda s: s | {"shank_right": replace(
            s["shank_right"], accelerometer_m_s2=s["shank_right"].accelerometer_m_s2 / 9.80665)},
         {}, "session: shank_right: the accelerometer's median size is .*; g"),
        (lambda s: s | {"shank_right": replace(
            s["shank_right"], gyroscope_rad_s=np.degrees(s["shank_right"].gyroscope_rad_s))},
         {}, "session: shank_right: the gyroscope reaches"),
        (lambda s: s | {"shank_right": replace(
            s["shank_right"], time_s=s["shank_right"].time_s + 1e4)},
         {"align": "stamps"}, "no common time"),
    ],
)  # fmt: skip
def test_invalid_input_is_refused_in_one_line(trial, method, change, options, message):
    with pytest.raises(UserError, match=message) as caught:
        predict_session(change(_sensors(trial)), method, **options)
    assert "\n" not in str(caught.value)


@pytest.mark.recordings
def test_the_knee_of_raw_files_is_the_benchmarks(data_root, tmp_path, method):
    """Raw files as plain CSV, nothing else given, within 0.1 degrees."""
    import pandas as pd

    from narx.datasets import NeuraSample, read_recording
    from narx.datasets.neura_sample import _SENSORS, _read_sensor

    root = data_root / "neura_sample"
    trial = next(iter(NeuraSample(root=root)))
    calibrated = calibrate(trial)
    sensors = {}
    columns = ["time_s"] + [
        f"{sensor}_{axis}_{unit}"
        for sensor, unit in (("gyroscope", "rad_s"), ("accelerometer", "m_s2"))
        for axis in "xyz"
    ]
    for segment, number in _SENSORS.items():
        raw = _read_sensor(root / "rawimu" / f"S02-Trial-Walk-1-000_{number}.txt")
        pd.DataFrame(raw, columns=columns).to_csv(tmp_path / f"{segment}.csv", index=False)
        sensors[segment] = read_recording(tmp_path / f"{segment}.csv", segment)
    result = predict_session(sensors, method)
    rows = np.searchsorted(result.time_s, trial.time_s - 1e-6)
    for side in ("right", "left"):
        benchmark = grood_suntay(
            *(
                orientation_from_angles(method.estimate(calibrated[f"{part}_{side}"].signals))
                for part in ("thigh", "shank")
            )
        )
        difference = np.degrees(result.angles_rad[f"knee_{side}"][rows] - benchmark)
        assert np.sqrt(np.nanmean(difference**2, axis=0)).max() < 0.1
