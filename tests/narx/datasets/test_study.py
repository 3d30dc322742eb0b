"""A user's own study is read as its description specifies, or refused with a one-line reason."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets import write_recording
from narx.datasets.study import Study
from narx.datasets.study_draft import draft_study
from narx.datasets.study_patterns import FilePattern
from narx.errors import RecordingError, UserError
from narx.recordings.trial import ImuRecording

_RATE_HZ = 100.0
_TO_SENSOR = Rotation.from_euler("ZYX", [0.4, -0.2, 0.3])


def _motion(time, phase):
    """Standing for 2 s, then a swinging segment, in a global frame with z up."""
    walk = np.maximum(time - 2.0, 0.0)
    ramp = np.clip(walk, 0.0, 1.0)
    turn = 2 * np.pi * 0.9 * walk
    angles = [0.1 * np.sin(turn), 0.05 * np.sin(turn + 1), -0.4 * np.sin(turn - phase)]
    return Rotation.from_euler("ZXY", np.column_stack([ramp * a for a in angles]))


def _sensor(time, phase, segment="imu"):
    fine = 1e-4
    rate = (_motion(time - fine, phase).inv() * _motion(time + fine, phase)).as_rotvec()
    force = _motion(time, phase).inv().apply([0.0, 0.0, 9.81])
    return ImuRecording(
        segment, time, _TO_SENSOR.inv().apply(rate / (2 * fine)), _TO_SENSOR.inv().apply(force)
    )


def _markers(time, phase, lag_s=0.0):
    return (_motion(time - lag_s, phase) * _TO_SENSOR).as_quat(scalar_first=True)


def write_study(root):
    """Write a study of two people, thigh and shank, with a reference."""
    time = np.arange(0.0, 20.0, 1 / _RATE_HZ)
    frames = np.arange(0.0, 20.0, 0.01)
    for subject in ("anna", "bert"):
        for segment, phase in (("thigh_right", 0.0), ("shank_right", 0.9)):
            stem = root / subject / f"walk1_{segment}"
            write_recording(stem.with_suffix(".csv"), _sensor(time, phase))
            columns = {f"quaternion_{c}": v for c, v in zip("wxyz", _markers(frames, phase).T,
                                                           strict=True)}  # fmt: skip
            pd.DataFrame({"time_s": frames + 0.02, **columns}).to_csv(
                stem.with_name(f"{stem.name}_markers.csv"), index=False
            )
            write_recording(root / subject / f"standing_{segment}.csv", _sensor(time[:150], phase))
    _describe(root, _WHOLE)


@pytest.fixture
def folder(tmp_path):
    write_study(tmp_path)
    return tmp_path


_WHOLE = """
files: "{subject}/{trial}_{segment}.csv"
calibration: {standing: "{subject}/standing_{segment}.csv"}
reference: {files: "{subject}/{trial}_{segment}_markers.csv"}
"""


def _describe(folder, text):
    (folder / "study.yaml").write_text(text, encoding="utf-8")


def test_a_study_is_read_as_described(folder):
    source = Study(root=folder)
    assert source.index().to_dict("records") == [
        {
            "subject": s,
            "condition": "walk",
            "trial": "walk1",
            "segments": "shank_right, thigh_right",
            "has_reference": True,
        }
        for s in ("anna", "bert")
    ]
    trial = source.load("anna", "walk", "walk1")
    expected = _sensor(trial.time_s, 0.0)
    np.testing.assert_allclose(
        trial.imus["thigh_right"].gyroscope_rad_s, expected.gyroscope_rad_s, atol=1e-6
    )
    # the markers' clock is 20 ms late; the sensor's own frame is found from the angular rates
    found = Rotation.from_quat(
        trial.reference["shank_right"].quaternion_wxyz[300:1500], scalar_first=True
    )
    true = _motion(trial.time_s[300:1500], 0.9) * _TO_SENSOR
    assert np.degrees((found.inv() * true).magnitude().max()) < 0.5
    assert trial.calibration["standing"]["thigh_right"].n_samples == 150
    assert trial.still_s[0][1] == pytest.approx(2.0, abs=0.2)
    assert trial.starts_in_calibration_posture
    assert set(trial.sources) == {
        f"anna/{name}_{segment}{more}.csv"
        for segment in ("thigh_right", "shank_right")
        for name, more in (("walk1", ""), ("walk1", "_markers"), ("standing", ""))
    }


@pytest.mark.parametrize("rotates", ["to_global", "from_global"])
def test_a_reference_of_the_segment_keeps_its_own_frame(folder, rotates):
    for path in folder.rglob("*_markers.csv"):
        table = pd.read_csv(path)
        phase = 0.0 if "thigh" in path.name else 0.9
        quaternion = _motion(table.time_s.to_numpy() - 0.02, phase)
        if rotates == "from_global":
            quaternion = quaternion.inv()
        table[[f"quaternion_{c}" for c in "wxyz"]] = quaternion.as_quat(scalar_first=True)
        table.iloc[700:710, 1:] = 0.0
        table.rename(columns={"quaternion_w": "q0"}).to_csv(path, index=False)
    _describe(
        folder,
        'files: "{subject}/{trial}_{segment}.csv"\n'
        'calibration: {standing: "{subject}/standing_{segment}.csv"}\n'
        'reference: {files: "{subject}/{trial}_{segment}_markers.csv", frame: anatomical,\n'
        f"  rotates: {rotates}, quaternion: [q0, quaternion_x, quaternion_y, quaternion_z]}}",
    )
    trial = Study(root=folder).load("bert", "walk", "walk1")
    reference = trial.reference["thigh_right"]
    assert reference.frame == "anatomical"
    lost = np.isnan(reference.quaternion_wxyz).any(axis=1)
    assert 5 <= lost[600:800].sum() <= 14
    inside = np.flatnonzero(~lost)[300:1400]
    found = Rotation.from_quat(reference.quaternion_wxyz[inside], scalar_first=True)
    assert np.degrees((found.inv() * _motion(trial.time_s[inside], 0.0)).magnitude().max()) < 0.5


def test_values_of_some_trials_and_parts_within_the_walk(folder):
    _describe(
        folder,
        """
files: "{subject}/walk1_{segment}.csv"
segments: {thigh_right: thigh_left, shank_right: shank_left}
condition: level
trial: 7
sampling_rate_hz: 50
still_s: [0, 1]
calibration: {standing: [0, 1.5]}
trials:
  - {subject: bert, walking_s: [3, 12], straight: yes, start_pose: unknown}
  - {subject: bert, still_s: [[0, 1], [1, 2]]}
""",
    )
    source = Study(root=folder)
    anna, bert = (source.load(name, "level", "7") for name in ("anna", "bert"))
    assert anna.sampling_rate_hz == 50
    assert set(anna.imus) == {"thigh_left", "shank_left"}
    assert (anna.still_s, anna.walking_s, anna.straight) == (((0, 1),), None, False)
    assert anna.calibration["standing"]["shank_left"].time_s[-1] == pytest.approx(1.5, abs=0.011)
    assert anna.starts_in_calibration_posture
    assert not anna.reference
    assert "no reference" in " ".join(anna.notes)
    assert (bert.still_s, bert.walking_s, bert.straight) == (((0, 1), (1, 2)), (3, 12), True)
    assert not bert.starts_in_calibration_posture


def test_files_named_one_by_one(folder):
    _describe(
        folder,
        "trials: [{subject: A, files: {thigh_right: anna/walk1_thigh_right.csv}},"
        " {subject: B, files: {thigh_right: bert/walk1_thigh_right.csv}},"
        " {subject: A, left_out: on}]",
    )
    assert Study(root=folder).index().subject.tolist() == ["B"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("files: [", "not YAML"),
        ("columns: &a {time: *a}\nfiles: x", "contains itself"),
        ("- a", "holds no mapping"),
        ("segments: {}", "no files, expected a pattern"),
        ("file: a.csv", "file: unknown key, the closest is files"),
        ('files: "{who}.csv"', "no field {who}, expected {subject}"),
        ('files: "*a*b*c*d*e*f*g*h*.csv"', "expected at most 8 of {any}, * and **"),
        ('files: "{subject}/x_{segment}.csv"', "which no file matches; there are anna/"),
        ('files: "**/*_{segment}.csv"', "are both 'shank_right' of one trial"),
        (_WHOLE + "still_s: [3, 1]", "does not start before it ends"),
        (_WHOLE + "sampling_rate_hz: 1", "sampling_rate_hz is 1,"),
        (_WHOLE + "trials: [{subject: carl}]", "trials.0 matches none; there are anna/walk/walk1"),
        (_WHOLE + "trials: [{left_out: true}]", "all trials are left out"),
        ("trials: [{files: {thigh_right: none.csv}}]", "no file 'none.csv'"),
        (_WHOLE + "columns: {time: t}\ndevice: x.yaml", "columns and device are both given"),
    ],
)
def test_a_wrong_description_is_one_line(folder, text, message):
    _describe(folder, text)
    with pytest.raises(UserError) as caught:
        Study(root=folder).index()
    assert message in str(caught.value)
    assert "study.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_wrong_recording_is_named(folder):
    path = folder / "anna" / "walk1_thigh_right_markers.csv"
    table = pd.read_csv(path)
    table.assign(quaternion_w=2.0).to_csv(path, index=False)
    with pytest.raises(RecordingError, match=r"walk1_thigh_right_markers\.csv: the quaternion of"):
        Study(root=folder).load("anna", "walk", "walk1")
    table.drop(columns="quaternion_z").to_csv(path, index=False)
    with pytest.raises(RecordingError, match="0 columns 'quaternion_z', expected one"):
        Study(root=folder).load("anna", "walk", "walk1")
    _describe(folder, _WHOLE.replace("standing: ", "standing: [30, 40] #"))
    _describe(folder, 'files: "{subject}/walk1_{segment}.csv"\ncalibration: {standing: [30, 40]}')
    with pytest.raises(RecordingError, match=r"calibration.standing is 30 to 40 s, the recording"):
        Study(root=folder).load("anna", "walk", "1")
    _describe(folder, 'files: "{subject}/walk1_{segment}.csv"\nstart_pose: known')
    late = _sensor(np.arange(6.0, 20.0, 0.01), 0.0)
    write_recording(folder / "anna" / "walk1_thigh_right.csv", late)
    write_recording(folder / "anna" / "walk1_shank_right.csv", late)
    with pytest.raises(RecordingError, match="does not begin with"):
        Study(root=folder).load("anna", "walk", "1")


def test_no_folder_and_no_description(tmp_path):
    with pytest.raises(UserError, match="no folder given; set data_root"):
        Study().index()
    with pytest.raises(UserError, match="narx-draft-study input="):
        Study(root=tmp_path).index()


@pytest.mark.parametrize(
    ("pattern", "path", "fields"),
    [
        ("{subject}/{trial}_{segment}.csv", "a/slow_walk_r_thigh.csv",
         {"subject": "a", "trial": "slow_walk", "segment": "thigh_right"}),
        ("{subject}_{trial}_{segment}.*", "P1_2_ShankLeft.parquet",
         {"subject": "P1", "trial": "2", "segment": "shank_left"}),
        ("{subject}/{subject}-{segment}.csv", "a/b-pelvis.csv", None),
        ("**/{segment}/{trial}.csv", "x/y/foot_l/3.csv", {"segment": "foot_left", "trial": "3"}),
        ("{any}_{segment}.csv", "x/y_foot.csv", None),
        ("{segment}.csv", "hip_abduction_right_shank_right.csv", None),
        ("hip_abduction_right_{segment}.csv", "hip_abduction_right_shank_right.csv",
         {"segment": "shank_right"}),
    ],
)  # fmt: skip
def test_patterns(pattern, path, fields):
    assert FilePattern(pattern, {}, "files").fields(path) == fields


def test_wildcards_that_follow_each_other_are_one():
    pattern = FilePattern("**/" * 30 + "{any}" * 30 + "x.csv", {}, "files")
    assert pattern.fields("a/b/" + "z" * 200) is None
    assert pattern.fields("a/b/zx.csv") == {}
    mixed = FilePattern("{any}*" * 30 + "/" + "*{any}**" * 30 + "x.csv", {}, "files")
    assert mixed.fields("b/" + "z" * 200) is None
    assert mixed.fields("b/c/zx.csv") == {}


@pytest.mark.parametrize(
    ("pattern", "subject"),
    [("{any}{subject}.csv", "abc"), ("*{subject}.csv", "c"), ("{any}*{subject}.csv", "c"),
     ("*{any}{subject}.csv", "c"), ("**/{any}**{subject}.csv", "c")],
)  # fmt: skip
def test_merged_wildcards_leave_to_a_field_what_they_left_alone(pattern, subject):
    assert FilePattern(pattern, {}, "files").fields("abc.csv") == {"subject": subject}


def test_names_of_sensors_in_a_pattern():
    pattern = FilePattern(
        "{trial}-{segment}.txt", {"S1": "thigh_left", "S10": "foot_left"}, "files"
    )
    assert pattern.fields("walk-s10.txt") == {"trial": "walk", "segment": "foot_left"}
    assert pattern.fields("walk-S2.txt") is None


def test_a_draft_equals_a_manual_description(folder):
    (folder / "notes.md").write_text("not a recording")
    (folder / "anna" / "broken.csv").write_text("a,b\n1,2\n3,4\n")
    for part in ("hip_abduction_right", "still"):
        write_recording(
            folder / "anna" / f"{part}_thigh_right.csv", _sensor(np.arange(3.0, 6, 0.01), 0)
        )
    (folder / "study.yaml").unlink()
    draft = draft_study(folder)
    _describe(folder, draft.text)
    source = Study(root=folder)
    assert source.index().segments.tolist() == 2 * ["shank_right, thigh_right"]
    trial = source.load("anna", "walk", "walk1")
    assert set(trial.calibration) == {"standing", "hip_abduction_right", "still"}
    assert set(trial.reference) == {"thigh_right", "shank_right"}
    said = "\n".join(draft.guesses)
    assert "4 files as {subject}/{trial}_{segment}.csv: sensors on shank_right, thigh_right" in said
    assert "not used: notes.md" in said
    assert "not used: 1 file as {subject}/{trial}.csv (" in said


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("P01_walk_2_thigh_right.csv", "{subject}_{trial}_{segment}.csv"),
        ("thigh_right.csv", "{segment}.csv"),
        ("thigh_right_walk2.csv", "{segment}_{trial}.csv"),
        ("anna/slow/shank_l.csv", "{subject}/{condition}/{segment}.csv"),
        ("anna/LeftThigh/walk.csv", "{subject}/{segment}/{trial}.csv"),
    ],
)
def test_a_draft_finds_the_fields(tmp_path, name, pattern):
    write_recording(tmp_path / name, _sensor(np.arange(0.0, 6, 0.01), 0))
    assert f"as {pattern}: sensors on" in draft_study(tmp_path).guesses[0]
    _describe(tmp_path, draft_study(tmp_path).text)
    assert len(Study(root=tmp_path)) == 1


def test_a_draft_without_body_parts_is_reported(tmp_path):
    write_recording(tmp_path / "00B40C3C.csv", _sensor(np.arange(0.0, 6, 0.01), 0))
    assert "no body part in the names" in draft_study(tmp_path).guesses[0]
    with pytest.raises(UserError, match="no folder"):
        draft_study(tmp_path / "none")
    (tmp_path / "00B40C3C.csv").unlink()
    with pytest.raises(UserError, match="no file with a gyroscope"):
        draft_study(tmp_path)
