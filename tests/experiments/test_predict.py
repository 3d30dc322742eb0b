import hashlib
import json

import numpy as np
import pandas as pd
import pytest
import torch

from narx.datasets.csv_recording import read_recording, write_recording
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.inference.predict import predict
from narx.inference.start_up import StartUp
from narx.inference.stream import Quality
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.recordings.trial import ImuRecording


@pytest.fixture
def network():
    model = Narx(100.0, Normalisation(3.0, 0.5))
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        weights = 0.4 * torch.randn(model.weights.shape, generator=generator, dtype=torch.float64)
        model.weights.copy_(weights * model.trainable)
    return Checkpoint(
        model, StartUp(duration_s=2.0, averaging_s=1.0), error_std_rad=(0.1, 0.2, 0.3)
    )


@pytest.fixture
def folder(network, motion, tmp_path, monkeypatch):
    """A checkpoint and a recording with a gap, irregular in time."""
    monkeypatch.chdir(tmp_path)
    checkpoints.save(network, "net.pt")
    walk = motion("stand_walk_stand", duration_s=20.0)
    sagittal, frontal, transverse = walk.signals.axis_rates_rad_s.T
    gyroscope = np.column_stack([-frontal, -sagittal, transverse])
    gyroscope[700:830] = np.nan
    time = walk.time_s + np.random.default_rng(0).uniform(-0.002, 0.002, size=len(walk.time_s))
    recording = ImuRecording("imu", 5.0 + time, gyroscope, walk.signals.specific_force_m_s2)
    write_recording("walk.csv", recording)
    return tmp_path


def run(run_command, *overrides):
    return run_command("predict", "checkpoint=net.pt", "input=walk.csv", *overrides)


@pytest.mark.parametrize("frame", ["auto", "anatomical", "sensor"])
def test_the_file_equals_the_python_result(run_command, folder, network, frame):
    status, out, err, _ = run(run_command, "output=new/angles.csv", f"frame={frame}")
    assert (status, err) == (0, "")
    assert "1871 of 2001 samples with angles" in out
    table = pd.read_csv("new/angles.csv")
    recording = read_recording("walk.csv")
    expected = predict(recording, network.method(), frame=frame)
    assert list(table) == [
        "time_s", "sagittal_deg", "frontal_deg", "transverse_deg",
        "sagittal_std_deg", "frontal_std_deg", "transverse_std_deg", "quality",
    ]  # fmt: skip
    np.testing.assert_array_equal(table["time_s"], recording.time_s)
    np.testing.assert_allclose(
        table.iloc[:, 1:4], np.degrees(expected.angles_rad), atol=1e-6, rtol=0
    )
    assert table.iloc[700:830, 1:7].isna().all(axis=None)
    assert (table.quality[700:830] == Quality.MISSING).all()
    assert table.quality[[0, 830, 831, 2000]].tolist() == [
        Quality.STARTING, Quality.AFTER_PAUSE, Quality.GOOD, Quality.GOOD,
    ]  # fmt: skip
    assert table.drop(index=range(700, 830)).notna().all(axis=None)


def test_smoothing_leaves_the_standard_deviation_out(run_command, folder, network):
    status, _, err, _ = run(run_command, "output=angles.csv", "smoothing=true")
    assert (status, err) == (0, "")
    table = pd.read_csv("angles.csv")
    assert list(table) == ["time_s", "sagittal_deg", "frontal_deg", "transverse_deg", "quality"]
    expected = predict(read_recording("walk.csv"), network.method(smoothing=True))
    np.testing.assert_allclose(
        table.iloc[:, 1:4], np.degrees(expected.angles_rad), atol=1e-6, rtol=0
    )


def test_options_reach_the_method(run_command, folder, network):
    options = ["side=left", "start_pose=known", "still_s=[5.5,8]", "frame=anatomical"]
    status, out, err, _ = run(run_command, "output=angles.csv", *options)
    assert (status, err) == (0, "")
    assert "from 5.5-8 s removed" in out
    expected = predict(
        read_recording("walk.csv"),
        network.method(),
        side="left",
        start_pose="known",
        still_s=(5.5, 8.0),
        frame="anatomical",
    )
    angles = pd.read_csv("angles.csv")[["sagittal_deg", "frontal_deg", "transverse_deg"]]
    np.testing.assert_allclose(angles, np.degrees(expected.angles_rad), atol=1e-6, rtol=0)


def lose_a_column(text):
    return text.replace("gyroscope_y_rad_s", "gyro_y")


def cut_off(text):
    return text[: len(text) // 2].rsplit(",", 1)[0]


def spoil_a_cell(text):
    lines = text.splitlines(keepends=True)
    return "".join([*lines[:4], lines[4].replace(",", ",abc", 1), *lines[5:]])


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lose_a_column, "walk.csv: no column 'gyroscope_y_rad_s'"),
        (cut_off, "(cut off?)"),
        (spoil_a_cell, "walk.csv: line 5, column gyroscope_x_rad_s: found 'abc"),
        (lambda text: "", "walk.csv"),
        (lambda text: "".join(text.splitlines(keepends=True)[:2]), "walk.csv: 1 samples"),
    ],
)
def test_a_damaged_file_is_named_and_nothing_written(run_command, folder, damage, says):
    whole = (folder / "walk.csv").read_text()
    (folder / "walk.csv").write_text(damage(whole))
    assert says in refused(run_command, "output=new/angles.csv")
    assert not (folder / "new").exists()


@pytest.mark.parametrize(
    ("overrides", "says"),
    [
        (["output=new/a.csv", "input=none.csv"], "none.csv: no such file"),
        (["output=new/a.csv", "frame=body"], "frame is 'body'"),
        (["output=new/a.csv", "calibration=leg"], "calibration is 'leg', which is an option of se"),
        (["output=new/a.csv", "side=both"], "side is 'both'"),
        (["output=new/a.csv", "format=parquet"], "format is 'parquet', which is an option of many"),
        (["output=new/a.csv", "jobs=2"], "jobs is 2, which is an option of many recordings only"),
        (["output=new/a.csv", "scheduler=tcp://a:1"], "scheduler is 'tcp://a:1', which is an opt"),
        (["output=new/a.csv", "partition_s=300"], "which is an option of a session in parts only"),
        (["output=new/a.csv", "select.subject=S1"], "which is an option of data= only"),
        (
            ["output=new/a.csv", "still_file=walk.csv", "still_s=[0,1]"],
            "still_s and still_file exclude each other",
        ),
        (["output=~nobody.here/a.csv"], "'~nobody.here/a.csv' cannot be a path"),
        (["output=new/a.csv", "still_s=[3]"], "still_s is [3], expected [begin, end]"),
        (["output=new/a.csv", "still_s=[90,99]"], "walk.csv: no gyroscope sample in still_s"),
        (["output=new/a.csv", "checkpoint=walk.csv"], "checkpoint: 'walk.csv' is not a network"),
        (["output=walk.csv"], "output: 'walk.csv' is also the input"),
        (["output=new/a.csv", "align={thigh_right: 3}"], "which is for input={SEGMENT: FILE"),
        (["output=net.pt/a.csv"], "'net.pt/a.csv' cannot be written"),
        ([], "output"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(run_command, folder, overrides, says):
    before = {path.name for path in folder.iterdir()}
    assert says in refused(run_command, *overrides)
    assert {path.name for path in folder.iterdir()} <= before | {"predict_run"}


def test_the_home_folder_is_found(run_command, folder, monkeypatch):
    monkeypatch.setenv("HOME", str(folder))
    status, _, err, _ = run(run_command, "input=~/walk.csv", "output=~/new/angles.csv")
    assert (status, err) == (0, "")
    assert (folder / "new" / "angles.csv").is_file()
    assert not (folder / "~").exists()


def test_a_record_beside_the_angles_says_how_they_were_made(run_command, folder):
    status, out, err, _ = run(run_command, "output=angles.csv", "frame=anatomical")
    assert (status, err) == (0, "")
    record = json.loads((folder / "angles.csv_record.json").read_text())
    assert record["configuration"]["frame"] == "anatomical"
    assert record["network_sha256"] == checkpoints.load("net.pt").sha256
    assert record["notes"]
    assert all(note in out for note in record["notes"])
    recorded = hashlib.sha256((folder / "walk.csv").read_bytes()).hexdigest()
    assert record["environment"]["data_sha256"] == {"walk.csv": recorded}
    assert record["environment"]["versions"]["torch"] == torch.__version__
    first = (folder / "angles.csv_record.json").read_bytes()
    run(run_command, "output=angles.csv", "frame=anatomical")
    assert (folder / "angles.csv_record.json").read_bytes() == first


def refused(run_command, *overrides):
    status, _, err, _ = run(run_command, *overrides)
    assert status == 2
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    return line
