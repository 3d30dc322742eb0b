"""Two files in, angles, strides and a picture out."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from narx.datasets import SimulatedGait, read_recording, write_recording
from narx.datasets.segment_names import segment_in_name
from narx.errors import UserError
from narx.experiments.predictions.angle_files import write_angles
from narx.experiments.predictions.motion_bids_files import files_beside

INPUT = "input={thigh_right: thigh.csv, shank_right: shänk.csv}"


@pytest.fixture(scope="module")
def trial():
    source = SimulatedGait(subjects=["S1"], conditions=["normal"], treadmill_duration_s=30)
    return next(iter(source))


@pytest.fixture
def folder(tmp_path, trial, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_recording("thigh.csv", trial.imus["thigh_right"])
    write_recording("shänk.csv", trial.imus["shank_right"])
    return tmp_path


def test_a_leg(run_command, folder):
    status, out, err, _ = run_command("predict", INPUT, "output=knee.csv")
    assert (status, err) == (0, "")
    table = pd.read_csv("knee.csv")
    assert list(table)[:4] == [
        "time_s", "thigh_right_sagittal_deg", "thigh_right_frontal_deg",
        "thigh_right_transverse_deg",
    ]  # fmt: skip
    assert "knee_right_sagittal_std_deg" in table
    strides = pd.read_csv("knee_strides.csv")
    knee = strides[(strides.name == "knee_right") & (strides.axis == "sagittal")]
    assert len(knee) > 10
    assert (knee.range_deg - (knee.maximum_deg - knee.minimum_deg)).abs().max() < 2e-3
    assert knee.range_deg.median() == pytest.approx(55, abs=15)
    assert (knee.cadence_steps_per_min * knee.duration_s).median() == pytest.approx(120, abs=1)
    cycle = pd.read_csv("knee_cycle.csv")
    one = cycle[(cycle.name == "knee_right") & (cycle.axis == "sagittal")]
    assert len(one) == 101
    assert one.n_strides.iloc[0] == len(knee)
    # the range of the mean cycle is at most the mean range of the strides
    assert np.ptp(one.mean_deg) <= knee.range_deg.mean() + 1e-6
    assert (folder / "knee_cycle.png").stat().st_size > 10_000
    assert "knee_cycle.png: right" in out


def test_storage_files_of_opensim(run_command, folder):
    for name in ("knee.sto", "knee.mot", "knee.parquet", "knee.csv"):
        status, _, err, _ = run_command("predict", INPUT, f"output={name}")
        assert (status, err) == (0, "")
    expected = pd.read_csv("knee.csv")
    pd.testing.assert_frame_equal(
        pd.read_parquet("knee.parquet"),
        expected,
        check_dtype=False,  # quality takes a byte
    )
    for name in ("knee", "knee.sto", "knee.mot"):  # each has its own
        assert (folder / f"{name}_strides.csv").is_file()
        assert (folder / f"{name}_cycle.png").is_file()
    for name in ("knee.sto", "knee.mot"):
        lines = (folder / name).read_text().splitlines()
        end = lines.index("endheader")
        header = dict(line.split("=") for line in lines[1:end])
        assert header["inDegrees"] == "yes"
        table = pd.read_csv(name, sep="\t", skiprows=end + 1)
        assert table.shape == (int(header["nRows"]), int(header["nColumns"]))
        assert next(iter(table)) == "time"
        np.testing.assert_allclose(table.to_numpy(), expected.to_numpy(), atol=1e-9)


def test_opensim_reads_its_storage_files(tmp_path):
    opensim = pytest.importorskip("opensim")
    table = pd.DataFrame({"time_s": [0.0, 0.01, 0.02], "knee_right_sagittal_deg": [1.0, 2.5, -3.0]})
    for name in ("knee.sto", "knee.mot"):
        write_angles(table, tmp_path / name)
        read = opensim.TimeSeriesTable(str(tmp_path / name))
        assert read.getTableMetaDataString("inDegrees") == "yes"
        assert list(read.getIndependentColumn()) == list(table.time_s)
        column = read.getDependentColumn("knee_right_sagittal").to_numpy()
        np.testing.assert_array_equal(column, table.knee_right_sagittal_deg)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["output=knee.doc"], "output: 'knee.doc', expected a name ending in .csv"),
        (["output=thigh.csv"], "output: 'thigh.csv' is also the input"),
        (["output=k.csv", "frame=anatomical"], "frame is 'anatomical', which is an option of one"),
        (["output=k.csv", "remove_bias=false"], "remove_bias is false, which is an option of one"),
        (["output=k.csv", "format=sto"], "format is 'sto', which is an option of many recordings"),
        (["output=k.csv", "walking_s=3"], "walking_s is 3, expected [begin, end] in s"),
        (["output=k.csv", "align=x"], "align is 'x'"),
        (["output=k.csv", "columns=x"], "columns is 'x', expected a section with time, gyroscope"),
        (["output=k.csv", "device=none.yaml"], "none.yaml: no such file"),
        (["output=k.csv", "input={thigh_right: thigh.csv, shank_right: thigh.csv}"],
         "input: 'thigh.csv' is given for two segments"),
        (["output=k.csv", "input={thigh_right: [1, 2]}"], "expected a path or a section of names"),
        (["output=k.csv", "input={knie: thigh.csv}"], "segment 'knie', expected some of"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line(run_command, folder, overrides, message):
    own = [INPUT] if not any(o.startswith("input") for o in overrides) else []
    status, _, err, _ = run_command("predict", *own, *overrides)
    assert status == 2
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert not (folder / "k.csv").exists()


def test_columns_are_mapped_on_the_spot(run_command, folder, trial):
    imu = trial.imus["thigh_right"]
    table = pd.DataFrame({"t": imu.time_s * 1e3})
    for k, axis in enumerate("xyz"):
        table[f"w{axis}"] = np.degrees(imu.gyroscope_rad_s[:, k])
        table[f"a{axis}"] = imu.accelerometer_m_s2[:, k]
    table.to_csv("own.csv", index=False, sep=";")
    columns = (
        "columns={time: {names: t, unit: ms}, gyroscope: {names: 'w{axis}', unit: deg/s}, "
        "accelerometer: {names: 'a{axis}', unit: 'm/s^2'}}"
    )
    status, _, err, _ = run_command("predict", "input=own.csv", "output=own_angles.csv", columns)
    assert (status, err) == (0, "")
    status, out, err, _ = run_command("predict", "input=thigh.csv", "output=angles.csv")
    assert (status, err) == (0, "")
    assert "s of rest, which is not used as the zero of the angles" in out
    own, plain = pd.read_csv("own_angles.csv"), pd.read_csv("angles.csv")
    np.testing.assert_allclose(own.to_numpy(), plain.to_numpy(), atol=1e-4)


def test_motion_bids(run_command, folder):
    name = "derived/sub-01/motion/sub-01_task-walk_tracksys-narx_run-1"
    (folder / "derived").mkdir()
    (folder / "derived" / ".bidsignore").write_text("*_notes.txt\n*_cycle.csv")
    for output in (f"{name}_motion.tsv", "knee.csv"):
        status, _, err, _ = run_command("predict", INPUT, f"output={output}")
        assert (status, err) == (0, "")
    expected = pd.read_csv("knee.csv")
    channels = pd.read_csv(f"{name}_channels.tsv", sep="\t", keep_default_na=False)
    samples = pd.read_csv(f"{name}_motion.tsv", sep="\t", header=None, names=channels.name)
    pd.testing.assert_frame_equal(samples, expected, check_dtype=False, check_names=False)
    of = channels.set_index("name")
    assert list(of.loc["time_s", ["type", "units"]]) == ["LATENCY", "s"]
    knee = of.loc["knee_right_sagittal_deg"]
    assert (knee.type, knee.units, knee.tracked_point) == ("JNTANG", "deg", "knee_right")
    assert of.loc["thigh_right_sagittal_deg", "type"] == "MISC"
    assert of.loc["knee_right_sagittal_std_deg", "type"] == "MISC"
    about = json.loads((folder / f"{name}_motion.json").read_text())
    assert about["SamplingFrequency"] == pytest.approx(500.0)
    assert about["MotionChannelCount"] == len(channels)
    assert about["JNTANGChannelCount"] == 3
    assert about["TrackedPointsCount"] == 3
    assert about["TaskName"] == "walk"
    root = folder / "derived"
    described = json.loads((root / "dataset_description.json").read_text())
    assert described["DatasetType"] == "derivative"
    ignored = (root / ".bidsignore").read_text().splitlines()
    assert ignored[0] == "*_notes.txt"  # another program's line
    assert len(set(ignored)) == len(ignored)
    for path in (root / "sub-01" / "motion").iterdir():
        named = path.name.endswith(("_motion.tsv", "_motion.json", "_channels.tsv"))
        assert named != any(path.match(pattern) for pattern in ignored)
    flat = "output=sub-01_task-walk_tracksys-narx_motion.tsv"
    status, _, err, _ = run_command("predict", INPUT, flat)
    assert (status, len(err.splitlines())) == (2, 1)
    assert "expected DATASET/sub-01/motion/sub-01_task-walk" in err
    (root / "dataset_description.json").write_text('{"Name": "recordings"}')
    status, _, err, _ = run_command("predict", INPUT, f"output={name}_motion.tsv")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "describes another data set" in err
    status, _, err, _ = run_command("predict", INPUT, "output=knee_motion.tsv")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "expected sub-<label>" in err
    status, _, err, _ = run_command("predict", INPUT, "output=out", "format=motion_bids")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "expected data= with it" in err


def test_an_event_aligns_the_sensors(run_command, folder):
    shank = read_recording("shänk.csv")
    write_recording("shänk.csv", replace(shank, time_s=shank.time_s + 5.5))
    event = "align={thigh_right: 4.0, shank_right: 9.5}"
    status, out, err, _ = run_command("predict", INPUT, "output=b.csv", event)
    assert (status, err) == (0, "")
    assert "sensors aligned by the given event: 'shank_right' moved by -5.500 s" in out
    write_recording("shänk.csv", shank)
    status, _, err, _ = run_command("predict", INPUT, "output=a.csv", "align=stamps")
    assert (status, err) == (0, "")
    a, b = pd.read_csv("a.csv"), pd.read_csv("b.csv")
    np.testing.assert_allclose(a, b, atol=1e-3)
    status, _, err, _ = run_command("predict", INPUT, "output=c.csv", "align={thigh_right: 4.0}")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "expected one for each of shank_right, thigh_right" in err


def test_c3d(run_command, folder):
    ezc3d = pytest.importorskip("ezc3d")
    for output in ("knee.c3d", "KNEE.C3D", "knee.csv"):
        status, _, err, _ = run_command("predict", INPUT, f"output={output}")
        assert (status, err) == (0, "")
    assert (folder / "KNEE.C3D").read_bytes() == (folder / "knee.c3d").read_bytes()
    expected = pd.read_csv("knee.csv")
    file = ezc3d.c3d("knee.c3d")
    about = file["parameters"]["POINT"]
    labels = about["LABELS"]["value"]
    assert about["ANGLES"]["value"] == labels
    assert about["RATE"]["value"][0] == pytest.approx(500.0)
    for point, kind in (("knee_right", ""), ("thigh_right_std", "_std")):
        names = [
            f"{point.removesuffix('_std')}_{axis}{kind}_deg"
            for axis in ("sagittal", "frontal", "transverse")
        ]
        read = file["data"]["points"][:3, labels.index(point)].T
        np.testing.assert_allclose(read, expected[names], rtol=1e-6, atol=1e-5)


def test_no_output_replaces_a_recording_or_a_folder(run_command, folder):
    (folder / "w_strides.csv").write_bytes((folder / "thigh.csv").read_bytes())
    both = "input={thigh_right: w_strides.csv, shank_right: shänk.csv}"
    status, _, err, _ = run_command("predict", both, "output=w.csv")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "'w_strides.csv' is also the input" in err
    (folder / "x.csv_record.json").mkdir()
    status, _, err, _ = run_command("predict", INPUT, "output=x.csv")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "'x.csv_record.json' is a folder" in err
    assert not (folder / "x.csv").exists()


def test_a_single_sensor_has_the_segment_of_its_file_name(tmp_path):
    table = pd.DataFrame({"time_s": [0.0, 0.01], "sagittal_deg": [1.0, 2.0]})
    path = tmp_path / "sub-1" / "motion" / "sub-1_task-walk_tracksys-narx_motion.tsv"
    for file, point in (("anna_thigh_left.csv", "thigh_left"), ("walk.csv", "segment")):
        write_angles(table, path, segment_in_name(Path(file).stem))
        channels = pd.read_csv(files_beside(path)[0], sep="\t", keep_default_na=False)
        assert list(channels.tracked_point) == ["n/a", point]


def test_the_side_files_of_motion_bids_replace_no_recording(run_command, folder):
    motion = folder / "sub-1" / "motion"
    motion.mkdir(parents=True)
    table = motion / "sub-1_task-walk_tracksys-narx_channels.tsv"
    table.write_bytes((folder / "thigh.csv").read_bytes())
    output = f"output={motion}/sub-1_task-walk_tracksys-narx_motion.tsv"
    status, _, err, _ = run_command("predict", f"input={table}", output)
    assert (status, len(err.splitlines())) == (2, 1)
    assert f"'{table}' is also the input" in err


@pytest.mark.parametrize(
    "source", ["simulated_gait", "smartphone_pocket", "broad", "joint_1to3dof"]
)
def test_sources_without_angles_to_predict_are_refused_at_once(run_command, folder, source):
    status, _, err, _ = run_command("predict", f"data={source}", "data_root=.", "output=out")
    assert (status, len(err.splitlines())) == (2, 1)
    assert f"data={source}: " in err
    assert "expected study, motion_bids or neura_sample" in err
    assert not (folder / "out").exists()


def test_invalid_points_have_the_residual_of_c3d(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    table = pd.DataFrame({"time_s": [0.0, 0.01, 0.02]} | {
        f"{axis}_deg": [1.0, np.nan, 3.0] for axis in ("sagittal", "frontal", "transverse")
    })  # fmt: skip
    write_angles(table, tmp_path / "a.c3d")
    data = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]
    assert data["meta_points"]["residuals"].ravel().tolist() == [0.0, -1.0, 0.0]
    np.testing.assert_array_equal(data["points"][0, 0], [1.0, np.nan, 3.0])


@pytest.mark.parametrize(
    ("time_s", "says"),
    [
        (0.01 * np.arange(70_000), "70000 samples, a C3D file holds 65535"),
        (np.r_[0.0, 0.01, 0.02, 0.06], "times deviate from a constant rate by 1.0 samples"),
        (np.zeros(1), "1 samples"),
    ],
)
def test_c3d_holds_regular_samples(time_s, says, tmp_path):
    pytest.importorskip("ezc3d")
    table = pd.DataFrame({"time_s": time_s, "sagittal_deg": 1.0, "frontal_deg": 0.0})
    with pytest.raises(UserError, match=says):
        write_angles(table, tmp_path / "a.c3d")
    assert not list(tmp_path.iterdir())


def test_the_demo(run_command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, _, err, _ = run_command("demo_recordings", "output=demo", "duration_s=30")
    assert (status, err) == (0, "")
    assert sorted(p.name for p in (tmp_path / "demo").iterdir()) == [
        "shank_right.csv", "thigh_right.csv",
    ]  # fmt: skip
    status, _, err, _ = run_command("demo_recordings", "duration_s=1")
    assert (status, len(err.splitlines())) == (2, 1)
