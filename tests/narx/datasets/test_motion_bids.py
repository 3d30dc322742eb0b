"""Motion-BIDS folders, written here in small."""

import json

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets.motion_bids import MotionBids, segment_of
from narx.errors import RecordingError, UserError

_RATE_HZ = 128.0


def _channels(point, kind, components, units):
    return [
        {"name": f"{point}_{kind}_{c}", "component": c, "type": kind, "tracked_point": point,
         "units": units}
        for c in components
    ]  # fmt: skip


def _write(root, system, rate_hz, channels, values, run="_run-01"):
    folder = root / "sub-07" / "motion"
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / f"sub-07_task-walk_tracksys-{system}{run}"
    sidecar = {"SamplingFrequency": rate_hz, "TaskName": "walk"}
    stem.with_name(stem.name + "_motion.json").write_text(json.dumps(sidecar))
    pd.DataFrame(channels).to_csv(
        stem.with_name(stem.name + "_channels.tsv"), sep="\t", index=False
    )
    path = stem.with_name(stem.name + "_motion.tsv")
    pd.DataFrame(values).to_csv(path, sep="\t", index=False, header=False, na_rep="n/a")
    return path


def _motion(time):
    """Standing for 2 s, then a swinging thigh."""
    walk = np.maximum(time - 2.0, 0.0)
    phase = 2 * np.pi * 0.9 * walk
    ramp = np.clip(walk, 0.0, 1.0)
    return Rotation.from_euler(
        "ZXY",
        np.column_stack(
            [
                0.3 * ramp * np.sin(0.5 * phase),
                0.1 * ramp * np.sin(phase),
                -0.4 * ramp * np.sin(phase + 0.35 * np.sin(phase)),
            ]
        ),
    )


@pytest.fixture
def folder(tmp_path):
    time = np.arange(0.0, 20.0, 1 / _RATE_HZ)
    fine = 1e-4
    rate = (_motion(time - fine).inv() * _motion(time + fine)).as_rotvec() / (2 * fine)
    force = _motion(time).inv().apply([0.0, 0.0, 1.0])
    imu = _channels("LeftThigh", "GYRO", "xyz", "deg/s") + _channels(
        "LeftThigh", "ACCEL", "xyz", "g"
    )
    values = np.hstack([np.degrees(rate), force])
    values[1500:1600, 0] = np.nan
    _write(tmp_path, "imu", _RATE_HZ, imu, values)
    frames = np.arange(0.0, 20.0, 0.01)
    quaternion = _motion(frames).as_quat(scalar_first=True)
    optical = _channels("LeftThigh", "ORNT", ("quat_w", "quat_x", "quat_y", "quat_z"), "n/a")
    optical += _channels("Latency", "LATENCY", ("n/a",), "s")
    _write(tmp_path, "mocap", 100.0, optical, np.column_stack([quaternion, frames + 0.05]))
    return tmp_path


def test_inertial_and_optical_systems_become_one_trial(folder):
    source = MotionBids(root=folder)
    assert source.index().to_dict("records") == [
        {"subject": "07", "condition": "walk", "trial": "01"}
    ]
    trial = source.load("07", "walk", "01")
    assert trial.sampling_rate_hz == _RATE_HZ
    assert set(trial.imus) == {"thigh_left"}
    # latencies put the optical clock 50 ms ahead of what happened
    assert trial.clock_offset_s["thigh_left"] == pytest.approx(-0.05, abs=1e-3)
    imu = trial.imus["thigh_left"]
    assert np.isnan(imu.gyroscope_rad_s[1510:1590]).all()
    assert np.nanmedian(np.linalg.norm(imu.accelerometer_m_s2, axis=1)) == pytest.approx(9.80665)
    assert trial.still_s[0][1] == pytest.approx(2.0, abs=0.3)
    found = Rotation.from_quat(
        trial.reference["thigh_left"].quaternion_wxyz[100:-100], scalar_first=True
    )
    error = (found.inv() * _motion(trial.time_s[100:-100])).magnitude()
    assert np.degrees(error).max() < 0.7
    assert "walking" in " ".join(calibrate(trial)["thigh_left"].notes)


def test_without_orientations_there_is_no_reference(folder):
    for path in folder.rglob("*mocap*"):
        path.unlink()
    trial = MotionBids(root=folder, segments={"LeftThigh": "pelvis"}).load("07", "walk", "01")
    assert set(trial.imus) == {"pelvis"}
    assert not trial.reference


def _edit(path, old, new):
    path.write_text(path.read_text().replace(old, new))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda d: next(d.glob("*imu*.json")).unlink(), "no such file"),
        (lambda d: _edit(next(d.glob("*imu*.json")), "Frequency", "F"), "SamplingFrequency"),
        (lambda d: _edit(next(d.glob("*imu*channels*")), "units", "u"), "no column 'units'"),
        (lambda d: _edit(next(d.glob("*imu*channels*")), "deg/s", "rpm"), "unit 'rpm'"),
        (lambda d: _edit(next(d.glob("*imu*channels*")), "ACCEL", "MISC"), "0 channels ACCEL x"),
        (
            lambda d: _edit(next(d.glob("*imu*channels*")), "GYRO", "MISC"),
            "no channel of type GYRO",
        ),
        (
            lambda d: next(d.glob("*imu*motion.tsv")).write_text("1\t2\n3"),
            "line 2 has 1 values, expected 2",
        ),
        (
            lambda d: _edit(next(d.glob("*mocap*channels*")), "quat_w", "w"),
            "0 channels ORNT quat_w",
        ),
    ],
)
def test_damage_ends_in_one_line(folder, damage, message):
    damage(folder / "sub-07" / "motion")
    with pytest.raises(RecordingError, match=message) as caught:
        MotionBids(root=folder).load("07", "walk", "01")
    assert "\n" not in str(caught.value)


def test_a_global_frame_that_is_not_upright_is_refused(folder):
    path = next(folder.rglob("*mocap*_motion.tsv"))
    table = np.loadtxt(path)
    lying = Rotation.from_euler("x", 90, degrees=True)
    table[:, :4] = (lying * Rotation.from_quat(table[:, :4], scalar_first=True)).as_quat(
        scalar_first=True
    )
    np.savetxt(path, table, delimiter="\t")
    with pytest.raises(RecordingError, match="90 deg from z; expected a global frame with z up"):
        MotionBids(root=folder).load("07", "walk", "01")


def test_no_folder(tmp_path):
    with pytest.raises(UserError, match="no folder given"):
        len(MotionBids())
    with pytest.raises(UserError, match="no folder"):
        len(MotionBids(root=tmp_path / "nowhere"))
    with pytest.raises(UserError, match="no trial"):
        len(MotionBids(root=tmp_path))


@pytest.mark.parametrize(
    ("point", "segment"),
    [
        ("LeftThigh", "thigh_left"),
        ("shank_r", "shank_right"),
        ("imu l thigh", "thigh_left"),
        ("Pelvis", "pelvis"),
        ("t1", "t1"),
    ],
)
def test_segments_from_names(point, segment):
    assert segment_of(point) == segment
