"""Small Motion-BIDS folders, written by the tests."""

import json

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets.motion_bids import MotionBids
from narx.datasets.segment_names import segment_of
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


def write_bids(root):
    """Write a walk of one thigh, recorded by an inertial and an optical system."""
    time = np.arange(0.0, 20.0, 1 / _RATE_HZ)
    fine = 1e-4
    rate = (_motion(time - fine).inv() * _motion(time + fine)).as_rotvec() / (2 * fine)
    force = _motion(time).inv().apply([0.0, 0.0, 1.0])
    imu = _channels("LeftThigh", "GYRO", "xyz", "deg/s") + _channels(
        "LeftThigh", "ACCEL", "xyz", "g"
    )
    values = np.hstack([np.degrees(rate), force])
    values[1500:1600, 0] = np.nan
    _write(root, "imu", _RATE_HZ, imu, values)
    frames = np.arange(0.0, 20.0, 0.01)
    quaternion = _motion(frames).as_quat(scalar_first=True)
    optical = _channels("LeftThigh", "ORNT", ("quat_w", "quat_x", "quat_y", "quat_z"), "n/a")
    optical += _channels("Latency", "LATENCY", ("n/a",), "s")
    _write(root, "mocap", 100.0, optical, np.column_stack([quaternion, frames + 0.05]))


@pytest.fixture
def folder(tmp_path):
    write_bids(tmp_path)
    return tmp_path


def test_inertial_and_optical_systems_become_one_trial(folder):
    source = MotionBids(root=folder)
    assert source.index().to_dict("records") == [
        {"subject": "07", "condition": "walk", "trial": "01"}
    ]
    trial = source.load("07", "walk", "01")
    assert trial.sampling_rate_hz == _RATE_HZ
    assert set(trial.imus) == {"thigh_left"}
    # with the latencies, the optical time stamps are 50 ms early
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
        (lambda d: _edit(next(d.glob("*imu*channels*")), "deg/s", "knots"), "unit 'knots'"),
        (
            lambda d: _edit(next(d.glob("*imu*channels*")), "GYRO", "MISC"),
            "no channel of type GYRO",
        ),
        (
            lambda d: next(d.glob("*imu*motion.tsv")).write_text("1\t2\n3"),
            "line 2 has 1 values, expected 2",
        ),
        (lambda d: _edit(next(d.glob("*imu*.json")), "128.0", "0"), "expected a positive number"),
        (lambda d: _edit(next(d.glob("*imu*.json")), "128.0", "NaN"), "expected a positive number"),
        (lambda d: _edit(next(d.glob("*imu*.json")), "128.0", "[1, 2]"), "expected a positive"),
        (lambda d: next(d.glob("*imu*.json")).write_bytes(b"\xff\xfe{"), "not JSON"),
        (lambda d: next(d.glob("*imu*channels*")).write_bytes(b"\xff\xfe{"), "not a table"),
        (
            lambda d: _edit(next(d.glob("*imu*channels*")), "GYRO", "GYRO\tsurplus"),
            "a row has more cells than the header",
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
        ("LThigh", "thigh_left"),
        ("RShank", "shank_right"),
        ("lThigh", "thigh_left"),
        ("rshank", "shank_right"),
        ("Thigh_L", "thigh_left"),
        ("RightUpperLeg", "thigh_right"),
        ("LeftLowerLeg", "shank_left"),
        ("leftFoot", "foot_left"),
        ("THIGH RIGHT", "thigh_right"),
        ("sacrum", "pelvis"),
        ("head", "head"),
        ("../../etc/x", "_.._etc_x"),
        ("a" * 300, "a" * 52 + "-9835fa6"),
        ("\x00..", "_"),
        ("...", "unnamed"),
    ],
)
def test_segments_from_names(point, segment):
    assert segment_of(point) == segment


def _rename(folder, old, new):
    for path in folder.rglob("*"):
        if path.is_file() and old in path.name:
            path.rename(path.with_name(path.name.replace(old, new)))


def test_entities_stand_in_any_order(folder):
    _rename(folder, "_tracksys-imu_run-01", "_tracksys-imu_acq-fast_run-01")
    _rename(folder, "_tracksys-mocap_run-01", "_acq-fast_run-01_tracksys-mocap")
    trial = MotionBids(root=folder).load("07", "walk_fast", "01")
    assert set(trial.reference) == {"thigh_left"}


def test_metadata_are_inherited_and_the_nearer_wins(folder):
    own = next(folder.rglob("*imu*motion.json"))
    own.rename(folder / "task-walk_tracksys-imu_motion.json")
    assert MotionBids(root=folder).load("07", "walk", "01").sampling_rate_hz == _RATE_HZ
    (folder / "motion.json").write_text(json.dumps({"SamplingFrequency": 64.0}))
    (folder / "task-run_motion.json").write_text(json.dumps({"SamplingFrequency": 32.0}))
    assert MotionBids(root=folder).load("07", "walk", "01").sampling_rate_hz == _RATE_HZ
    channels = next(folder.rglob("*imu*channels.tsv"))
    channels.rename(folder / "tracksys-imu_channels.tsv")
    assert set(MotionBids(root=folder).load("07", "walk", "01").imus) == {"thigh_left"}


def test_derived_recordings_are_not_trials(folder):
    for name in ("derivatives/clean", "sourcedata", "code", ".git"):
        copied = folder / name / "sub-07" / "motion"
        copied.mkdir(parents=True)
        for path in (folder / "sub-07" / "motion").iterdir():
            (copied / path.name).write_bytes(path.read_bytes())
    source = MotionBids(root=folder)
    assert len(source) == 1
    assert set(source.load("07", "walk", "01").imus) == {"thigh_left"}


@pytest.mark.parametrize("unit", ["seconds", "sec", "n/a", "", "s"])
def test_the_unit_of_latencies_is_fixed(folder, unit):
    channels = next(folder.rglob("*mocap*channels.tsv"))
    table = pd.read_csv(channels, sep="\t", keep_default_na=False)
    table.loc[table.type == "LATENCY", "units"] = unit
    table.to_csv(channels, sep="\t", index=False)
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert trial.clock_offset_s["thigh_left"] == pytest.approx(-0.05, abs=1e-3)


def test_unneeded_channels_do_not_prevent_reading(folder):
    """Euler orientation recorded by a second sensor, which has no accelerometer."""
    _edit(next(folder.rglob("*imu*channels.tsv")), "ACCEL", "MISC")
    channels = next(folder.rglob("*mocap*channels.tsv"))
    _edit(channels, "quat_w", "x")
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert not trial.reference
    assert np.isnan(trial.imus["thigh_left"].accelerometer_m_s2).all()
    notes = " ".join(trial.notes)
    assert "the orientation (ORNT) of 'LeftThigh' is given by Euler angles" in notes
    assert "no accelerometer x, y, z of 'LeftThigh'" in notes
    assert "no reference" in notes


def test_two_systems_on_one_point(folder):
    _write(folder, "second", _RATE_HZ, _channels("LeftThigh", "GYRO", "xyz", "deg/s"),
           np.degrees(np.random.default_rng(0).normal(0, 0.5, (2560, 3))))  # fmt: skip
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert set(trial.imus) == {"thigh_left"}
    assert any("a second sensor on 'thigh_left', not read" in note for note in trial.notes)


def test_two_points_on_one_segment_keep_their_names(folder):
    channels = next(folder.rglob("*imu*channels.tsv"))
    path = next(folder.rglob("*imu*_motion.tsv"))
    table = pd.read_csv(channels, sep="\t")
    second = table.assign(tracked_point="left_thigh_lower")
    pd.concat([table, second]).to_csv(channels, sep="\t", index=False)
    values = pd.read_csv(path, sep="\t", header=None)
    pd.concat([values, values], axis=1).to_csv(
        path, sep="\t", header=False, index=False, na_rep="n/a"
    )
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert set(trial.imus) == {"LeftThigh", "left_thigh_lower"}


def test_short_side_names(folder):
    for path in folder.rglob("*channels.tsv"):
        _edit(path, "LeftThigh", "LThigh")
    assert set(MotionBids(root=folder).load("07", "walk", "01").imus) == {"thigh_left"}


def test_a_bad_channel_is_missing(folder):
    channels = next(folder.rglob("*imu*channels.tsv"))
    table = pd.read_csv(channels, sep="\t")
    table["status"] = ["good"] * 3 + ["bad"] + ["good"] * 2
    table.to_csv(channels, sep="\t", index=False)
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert np.isnan(trial.imus["thigh_left"].accelerometer_m_s2).all()
    assert any("status bad, not read: ACCEL of LeftThigh" in note for note in trial.notes)


@pytest.mark.parametrize(
    "damage",
    [
        lambda d: next(d.glob("*mocap*.json")).write_text("{"),
        lambda d: next(d.glob("*mocap*channels*")).unlink(),
        lambda d: next(d.glob("*mocap*motion.tsv")).write_text("x\ty\n1\t2\n"),
        lambda d: next(d.glob("*mocap*.json")).write_text('{"SamplingFrequency": 1}'),
    ],
)
def test_a_damaged_system_without_gyroscope_does_not_prevent_reading(folder, damage):
    whole = MotionBids(root=folder).load("07", "walk", "01")
    damage(folder / "sub-07" / "motion")
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert trial.imus.keys() == whole.imus.keys()
    assert not trial.reference
    assert sum(note.startswith("not read: ") and "mocap" in note for note in trial.notes) == 1


@pytest.mark.parametrize("as_written", [float, str, "{:e}".format])
def test_the_effective_rate_is_the_rate(folder, as_written):
    sidecar = next(folder.rglob("*imu*motion.json"))
    sidecar.write_text(
        json.dumps({"SamplingFrequency": 100, "SamplingFrequencyEffective": as_written(_RATE_HZ)})
    )
    trial = MotionBids(root=folder).load("07", "walk", "01")
    assert trial.sampling_rate_hz == _RATE_HZ
    assert trial.time_s[-1] == pytest.approx(20.0, abs=0.1)


def test_acquisition_times_bring_systems_together(tmp_path):
    """The shank's system started 2 s after the thigh's; both record the same motion."""
    for system, point, rate_hz, begin in (
        ("imuS", "shank_right", 25.6, 2.0),
        ("imuT", "thigh_right", 25.0, 0.0),
    ):
        time = np.arange(begin, 22.0, 1 / rate_hz)
        rate = (_motion(time - 1e-4).inv() * _motion(time + 1e-4)).as_rotvec() / 2e-4
        force = _motion(time).inv().apply([0.0, 0.0, 9.81])
        channels = _channels(point, "GYRO", "xyz", "rad/s") + _channels(
            point, "ACCEL", "xyz", "m/s^2"
        )
        _write(tmp_path, system, rate_hz, channels, np.hstack([rate, force]), run="")
    scans = tmp_path / "sub-07" / "sub-07_scans.tsv"
    scans.write_text(
        "filename\tacq_time\n"
        "./motion/sub-07_task-walk_tracksys-imuT_motion.tsv\t2024-05-01T10:00:00.000\n"
        "motion\\sub-07_task-walk_tracksys-imuS_motion.tsv\t2024-05-01T10:00:02.000\n"
    )
    source = MotionBids(root=tmp_path)
    trial = source.load("07", "walk", "1")
    rates = [imu.gyroscope_rad_s[50:-50, 1] for imu in trial.imus.values()]
    assert np.corrcoef(*rates)[0, 1] > 0.999
    assert any("imuS_motion.tsv begins 2 s later, by acq_time" in note for note in trial.notes)
    scans.write_text(scans.read_text().replace("2024-05-01T10:00:02", "yesterday"))
    with pytest.raises(RecordingError, match=r"scans.tsv: acq_time of .* is 'yesterday.000'"):
        source.load("07", "walk", "1")


def test_a_wrong_unit_is_refused(folder):
    _edit(next(folder.rglob("*imu*channels.tsv")), "deg/s", "rad/s")
    with pytest.raises(RecordingError, match=r"'LeftThigh': .* beyond any gyroscope|no leg does"):
        MotionBids(root=folder).load("07", "walk", "01")


# facts of a public example (bids-examples, motion_systemvalidation, subject pp002): its points,
# the order of its columns, its rates and times; the signals are made up here
_EXAMPLE_POINTS = (
    "head", "sternum", "leftUpperArm", "leftForeArm", "rightUpperArm", "rightForeArm", "pelvis",
    "leftThigh", "leftShank", "leftFoot", "rightThigh", "rightShank", "rightFoot", "leftAnkle",
    "rightAnkle", "pocket",
)  # fmt: skip


def test_the_form_of_a_public_example(tmp_path):
    rate_hz = 199.905882352941
    time = np.arange(0.0, 12.0, 1 / rate_hz)
    rate = (_motion(time - 1e-4).inv() * _motion(time + 1e-4)).as_rotvec() / 2e-4
    force = _motion(time).inv().apply([0.0, 0.0, 9.81])
    field = np.full_like(force, 2e-5)
    kinds = (("ACCEL", "m/s^2", force), ("GYRO", "rad/s", rate), ("MAGN", "T", field))
    channels, columns = [], []
    for kind, units, values in kinds:
        for point in _EXAMPLE_POINTS:
            channels += [
                {"name": f"{point}_{kind}_{c}", "type": kind, "units": units,
                 "sampling_frequency": rate_hz, "tracked_point": point, "component": c,
                 "orientation_component": c}
                for c in "xyz"
            ]  # fmt: skip
            columns.append(values)
    _write(tmp_path, "imu", rate_hz, channels, np.hstack(columns), run="")
    markers = [
        {"name": f"{point}_POS_{c}", "type": "POS", "units": "m", "tracked_point": point,
         "component": c}
        for point in ("lToe", "lSk1", "lTh1", "rTh1") for c in "xyz"
    ]  # fmt: skip
    _write(tmp_path, "omc", 199.900398406375, markers, np.zeros((2000, 12)), run="")
    (tmp_path / "sub-07" / "sub-07_scans.tsv").write_text(
        "filename\tacq_time\n"
        + "".join(
            f"motion/sub-07_task-walk_tracksys-{system}_motion.tsv\t2022-12-05T19:23:27.866Z\n"
            for system in ("imu", "omc")
        )
    )
    trial = MotionBids(root=tmp_path).load("07", "walk", "1")
    assert len(trial.imus) == 16
    assert {"thigh_left", "shank_right", "foot_left", "pelvis", "head"} <= set(trial.imus)
    assert trial.sampling_rate_hz == rate_hz


# bids-examples, motion_spotrotation (HTCVive) and motion_dualtask (PhaseSpace1): points, kinds and
# components of their channels, units, rates and the latency's unit; the signals are made up here
_QUATERNION = ("quat_w", "quat_x", "quat_y", "quat_z")


@pytest.mark.parametrize(
    ("system", "point", "angles", "unit", "rate_hz"),
    [
        ("HTCVive", "headRigid", _QUATERNION, "n/a", 89.3015261895807),
        ("PhaseSpace1", "Rigid1", ("x", "y", "z"), "rad", 480.118858611427),
    ],
)
def test_public_examples_without_a_gyroscope(tmp_path, system, point, angles, unit, rate_hz):
    channels = _channels(point, "ORNT", angles, unit) + _channels(point, "POS", "xyz", "m")
    channels += _channels(point, "MISC", ("n/a",), "n/a")
    channels += _channels(system, "LATENCY", ("n/a",), "seconds")
    values = np.zeros((200, len(channels)))
    values[:, 0] = 1.0
    values[:, -1] = np.arange(200) / rate_hz
    _write(tmp_path, system, rate_hz, channels, values, run="")
    source = MotionBids(root=tmp_path)
    with pytest.raises(
        UserError, match=rf"tracksys-{system}_motion.tsv: no channel of type GYRO"
    ) as refused:
        source.load("07", "walk", "1")
    assert "\n" not in str(refused.value)
