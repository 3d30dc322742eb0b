"""Pocket walks: synthetic ones with known truth, and real ones."""

import shutil

import numpy as np
import pytest
import scipy.io
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets.mat_file import read_mat
from narx.datasets.registry import PUBLIC
from narx.datasets.smartphone_pocket import SmartphonePocket
from narx.errors import RecordingError, UserError
from narx.recordings.trial import GRAVITY_M_S2

_OFFSET_S = 0.0173
_ALIGNMENT_S = -1.25
_BOOT_S = 57728.3044
_MOUNTING = Rotation.from_euler("ZYX", [0.4, -0.2, 1.1])  # rigid body to phone
_BIAS = {"Nexus5": np.array([0.01, -0.005, 0.07]), "iPhone5": np.array([0.1, -0.02, 0.02])}
_CONDITION = "NoDist_FrontPocket"


def _walk(duration_s=20.0, rate_hz=1000.0):
    """Fine clock, body-to-lab orientation and body rates of a gait-like motion with a turn."""
    time = np.arange(0.0, duration_s, 1.0 / rate_hz)
    phase = 2 * np.pi * 0.9 * time
    angles = np.column_stack(
        [
            0.3 * time + 0.1 * np.sin(phase),
            0.08 * np.sin(phase + 1.0),
            -np.radians(20.0) * np.sin(phase + 0.35 * np.sin(phase)),
        ]
    )
    orientation = Rotation.from_euler("ZXY", angles)
    rate = (orientation[:-1].inv() * orientation[1:]).as_rotvec() * rate_hz
    return time, orientation, CubicSpline(time[:-1] + 0.5 / rate_hz, rate)


def _save(path, time, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, np.column_stack([time, values]), fmt="%.9f")


def write_walk(root, walker, phone, condition=_CONDITION):
    """Write a walk in the format of the published data set."""
    rng = np.random.default_rng(len(walker))
    ios = phone.startswith("iPhone")
    system = root / ("ios" if ios else "android")
    folder = system / f"{walker}_{phone}_{condition}"
    still = system / f"calib_gyr_{phone}_d3"
    fine, orientation, rate = _walk()
    truth = CubicSpline(fine, orientation.as_matrix().reshape(-1, 9))
    boot = _BOOT_S if ios else 0.0
    sign = -1.0 / GRAVITY_M_S2 if ios else 1.0
    for name, rate_hz in (("gyroscope", 97.0), ("accelerometer", 99.0)):
        # the phone's clock: late by the offset, and before timeAlignment.txt and boot time
        time = np.arange(0.2, 19.5, 1.0 / rate_hz)
        time += rng.uniform(-0.1, 0.1, len(time)) / rate_hz
        happened = time - _OFFSET_S
        if name == "gyroscope":
            values = _MOUNTING.apply(rate(happened)) + _BIAS[phone]
        else:
            matrices = truth(happened).reshape(-1, 3, 3)
            values = sign * _MOUNTING.apply(matrices[:, 2, :] * GRAVITY_M_S2)
        _save(folder / f"{name}.txt", time - _ALIGNMENT_S + boot, values)
        rest = np.tile(_BIAS[phone] if name == "gyroscope" else [0, 0, sign * 9.81], (900, 1))
        _save(still / f"{name}.txt", np.arange(900) / rate_hz + boot, rest)
    (folder / "timeAlignment.txt").write_text(f"  {_ALIGNMENT_S:.7e}\n")
    if ios:
        for place in (folder, still):
            (place / "description.txt").write_text(f"[Time]\nBootTime = {_BOOT_S}")
    frames = np.arange(0.0, 19.9, 1 / 60.0)
    rotations = truth(frames).reshape(-1, 3, 3).transpose(2, 1, 0).reshape(9, -1)
    rotations[:, 600:630] = np.nan
    measurement = {"FrameRate": 60.0, "RigidBodies": {"Rotations": rotations}}
    (root / "qualisys").mkdir(exist_ok=True)
    name = folder.name
    scipy.io.savemat(root / "qualisys" / f"{name}.mat", {name: measurement})
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("pocket")
    write_walk(root, "Ada", "Nexus5")
    write_walk(root, "Ada", "iPhone5")
    return root


@pytest.fixture
def copied(made, tmp_path):
    return shutil.copytree(made, tmp_path / "pocket")


@pytest.mark.parametrize("phone", ["Nexus5", "iPhone5"])
def test_clock_mounting_and_gap_of_a_known_walk(made, phone):
    trial = SmartphonePocket(root=made).load("Ada", _CONDITION, phone)
    assert trial.clock_offset_s["thigh"] == pytest.approx(_OFFSET_S, abs=5e-4)
    assert trial.sampling_rate_hz == 100.0
    _, orientation, _ = _walk()
    there = np.isfinite(trial.reference["thigh"].quaternion_wxyz).all(axis=1)
    happened = trial.time_s - _OFFSET_S
    lost = (happened > 600 / 60) & (happened < 629 / 60)
    assert not there[lost].any()
    assert there[(happened < 599 / 60) | (happened > 630 / 60)].all()
    index = np.round(happened[there] * 1000).astype(int)
    found = Rotation.from_quat(trial.reference["thigh"].quaternion_wxyz[there], scalar_first=True)
    error = (found.inv() * orientation[index] * _MOUNTING.inv()).magnitude()
    assert np.degrees(error).max() < 0.5
    # iOS or Android, at rest the specific force points up
    force = found.apply(trial.imus["thigh"].accelerometer_m_s2[there]).mean(axis=0)
    assert force == pytest.approx([0, 0, GRAVITY_M_S2], abs=0.05)
    still = trial.calibration["still"]["thigh"]
    assert still.gyroscope_rad_s.mean(axis=0) == pytest.approx(_BIAS[phone], abs=1e-6)
    assert any("deg removed" in n or "removed by Kabsch" in n for n in trial.notes)
    assert len(trial.sources) >= 5


def test_other_rates(made):
    trial = SmartphonePocket(root=made, sampling_rate_hz=50).load("Ada", _CONDITION, "Nexus5")
    assert trial.sampling_rate_hz == 50.0
    assert np.diff(trial.time_s) == pytest.approx(0.02)


def test_walkers_that_are_added_later_are_found(copied):
    write_walk(copied, "Zoe", "iPhone5")
    source = SmartphonePocket(root=copied)
    assert source.index().to_dict("list") == {
        "subject": ["Ada", "Ada", "Zoe"],
        "condition": [_CONDITION] * 3,
        "trial": ["Nexus5", "iPhone5", "iPhone5"],
        "device": ["Nexus5", "iPhone5", "iPhone5"],
        "motion": ["FrontPocket"] * 3,
    }
    assert [trial.subject for trial in source.select(subject="Zoe")] == ["Zoe"]


def test_a_phone_in_the_hand_is_no_thigh(copied):
    write_walk(copied, "Ada", "iPhone5", "Dist_Texting")
    source = SmartphonePocket(root=copied)
    (texting,) = source.select(condition="Dist_Texting")
    assert list(texting.imus) == list(texting.calibration["still"]) == ["hand"]
    assert "sensor" in calibrate(texting)["hand"].notes[1]
    assert len(source.select(condition=_CONDITION)) == 2


def _cut(path, share):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * share)])


_FOLDER = f"ios/Ada_iPhone5_{_CONDITION}"
_OPTICAL = f"qualisys/Ada_iPhone5_{_CONDITION}.mat"


def _rewrite(path, change):
    """Change the frame rate and the rotations of an optical file."""
    ((name, measurement),) = read_mat(path).items()
    rotations = np.array(measurement.RigidBodies.Rotations)
    rate_hz = change(rotations) or measurement.FrameRate
    bodies = {"Rotations": rotations}
    scipy.io.savemat(path, {name: {"FrameRate": rate_hz, "RigidBodies": bodies}})


def _mirror(rotations):
    rotations[:3, 6] *= -1.0


def _stretch(rotations):
    rotations[:, 6] *= 1.2


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda r: _cut(r / _FOLDER / "gyroscope.txt", 0.5), r"gyroscope\.txt: line \d+"),
        (lambda r: (r / _FOLDER / "accelerometer.txt").unlink(), r"accelerometer\.txt: no such"),
        (lambda r: (r / _FOLDER / "accelerometer.txt").write_text("1 2 3\n"), "3 columns"),
        (lambda r: (r / _FOLDER / "description.txt").write_text("[Time]\n"), "BootTime"),
        (lambda r: (r / _FOLDER / "description.txt").write_bytes(b"\xff\xfe"), "not UTF-8 text"),
        (lambda r: (r / _FOLDER / "timeAlignment.txt").write_text(""), "no data lines"),
        (
            lambda r: _cut(r / f"qualisys/Ada_iPhone5_{_CONDITION}.mat", 0.5),
            "not a whole MATLAB file",
        ),
        (
            lambda r: scipy.io.savemat(r / f"qualisys/Ada_iPhone5_{_CONDITION}.mat", {"a": 1.0}),
            r"no field 'a\.FrameRate'",
        ),
        (lambda r: _rewrite(r / _OPTICAL, _mirror), "of frame 7 is not a rotation"),
        (lambda r: _rewrite(r / _OPTICAL, _stretch), "of frame 7 is not a rotation"),
        (lambda r: _rewrite(r / _OPTICAL, lambda _: -100.0), "FrameRate"),
        (lambda r: _rewrite(r / _OPTICAL, lambda _: 1e-30), "FrameRate"),
        (lambda r: shutil.rmtree(r / "ios" / "calib_gyr_iPhone5_d3"), "calib_gyr_iPhone5"),
    ],
)
def test_damage_ends_in_one_clear_line(copied, damage, message):
    damage(copied)
    with pytest.raises(UserError, match=message) as caught:
        SmartphonePocket(root=copied).load("Ada", _CONDITION, "iPhone5")
    assert "\n" not in str(caught.value)


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(UserError, match="no trial; expected folders like"):
        len(SmartphonePocket(root=tmp_path))


@pytest.fixture(scope="module")
def walks(data_root):
    folder = data_root / "smartphone_pocket"
    if not folder.is_dir():
        pytest.skip("no smartphone_pocket")
    return list(SmartphonePocket(root=folder).select(condition=_CONDITION))


@pytest.mark.recordings
def test_real_clock_offsets_lie_where_others_found_them(walks):
    # published offsets: 8 to 24 ms, the phone lagging
    for trial in walks:
        assert 0.007 < trial.clock_offset_s["thigh"] < 0.026, trial.name


@pytest.mark.recordings
def test_real_biases_are_those_of_the_phones(walks):
    expected = {
        "Nexus5": [0.7, -0.3, 4.2],
        "iPhone5": [5.7, -1.1, 1.0],
        "iPhone4S": [-0.5, -0.1, 0.0],
    }
    for trial in walks:
        bias = np.degrees(calibrate(trial)["thigh"].static_bias_rad_s)
        if trial.trial in expected:
            assert bias == pytest.approx(expected[trial.trial], abs=0.35), trial.name


@pytest.mark.recordings
def test_real_reference_and_sagittal_rate_agree(walks):
    for trial in walks:
        calibrated = calibrate(trial)["thigh"]
        slope = np.gradient(calibrated.reference_angles_rad, 1 / trial.sampling_rate_hz, axis=0)
        rate = calibrated.signals.axis_rates_rad_s
        both = np.isfinite(slope[:, 0]) & np.isfinite(rate[:, 0])
        # a positive correlation: the forward direction, found from the gyroscope alone, is right
        assert 0.96 < np.corrcoef(slope[both, 0], rate[both, 0])[0, 1] <= 1.0, trial.name
        # the global frame is upright
        there = np.isfinite(calibrated.reference_wxyz).all(axis=1)
        lab = Rotation.from_quat(calibrated.reference_wxyz[there], scalar_first=True)
        up = lab.apply(calibrated.signals.specific_force_m_s2[there]).mean(axis=0)
        assert np.degrees(np.arccos(up[2] / np.linalg.norm(up))) < 0.5


@pytest.mark.recordings
def test_a_real_file_cut_off_at_a_line_is_noticed(data_root, tmp_path):
    root = data_root / "smartphone_pocket"
    if not root.is_dir():
        pytest.skip("no smartphone_pocket")
    name = f"Thibaud_iPhone5_{_CONDITION}"
    for file in PUBLIC["smartphone_pocket"].sha256:
        if name in file or "calib_gyr_iPhone5" in file:
            (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / file).write_bytes((root / file).read_bytes())
    gyroscope = tmp_path / "ios" / name / "gyroscope.txt"
    lines = gyroscope.read_text().splitlines(keepends=True)
    gyroscope.write_text("".join(lines[: len(lines) // 2]))
    with pytest.raises(RecordingError, match=r"gyroscope\.txt: not as published"):
        SmartphonePocket(root=tmp_path).load("Thibaud", _CONDITION, "iPhone5")
