"""The page from own files to an exported network: its commands, in their order."""

import json
import re
import shlex
from pathlib import Path

import pandas as pd
import pytest

from narx.datasets import SimulatedGait, write_recording

PAGE = Path(__file__).resolve().parents[2] / "docs" / "own_recordings.md"
COMMANDS = re.findall(r"^narx-.*$", PAGE.read_text("utf-8"), re.MULTILINE)
# what makes the commands of the page short enough for a test
_SHORT = {
    "train": ["optimizer.restarts=1", "optimizer.iterations=2"],
    "benchmark": ["optimizer.restarts=1", "optimizer.iterations=2", "methods=[narx,zero]"],
}


@pytest.fixture
def recordings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NARX_DATA_ROOT", raising=False)
    source = SimulatedGait(
        subjects=("S1", "S2"),
        conditions=("normal",),
        treadmill_duration_s=25.0,
        sampling_rate_hz=100.0,
    )
    for trial in source:
        folder = tmp_path / "recordings" / {"S1": "anna", "S2": "bert"}[trial.subject]
        for segment in ("thigh_right", "shank_right"):
            write_recording(folder / f"walk1_{segment}.csv", trial.imus[segment])
            write_recording(
                folder / f"standing_{segment}.csv", trial.calibration["standing"][segment]
            )
            quaternion = trial.reference[segment].quaternion_wxyz
            columns = {f"quaternion_{c}": quaternion[:, k] for k, c in enumerate("wxyz")}
            pd.DataFrame({"time_s": trial.time_s, **columns}).to_csv(
                folder / f"walk1_{segment}_markers.csv", index=False
            )
    return tmp_path


def _markers_on_the_segment(recordings):
    """Correct the drafted study: the simulated markers are on the segment, not on the sensor."""
    path = recordings / "recordings" / "study.yaml"
    path.write_text(path.read_text("utf-8").replace("frame: sensor", "frame: anatomical"))


@pytest.mark.slow
def test_every_command_of_the_page(run_command, recordings):
    assert [shlex.split(line)[0] for line in COMMANDS] == [
        "narx-draft-study", "narx-predict", "narx-train", "narx-benchmark", "narx-benchmark",
        "narx-export", "narx-predict",
    ]  # fmt: skip
    printed = []
    for number, line in enumerate(COMMANDS):
        program, *overrides = shlex.split(line)
        name = program.removeprefix("narx-").replace("-", "_")
        status, out, err, run = run_command(name, *overrides, *_SHORT.get(name, []))
        assert (status, err) == (0, ""), line
        if run.exists():
            wanted = [one for one in overrides if one.startswith("hydra.run.dir=")]
            run.rename(wanted[0].removeprefix("hydra.run.dir=") if wanted else f"run{number}")
        printed.append(out)
        if name == "draft_study":
            _markers_on_the_segment(recordings)
    assert "anna/walk/walk1: shank_right, thigh_right" in printed[0]
    angles = pd.read_csv("angles/study/anna/walk/walk1_angles.csv")
    assert angles.knee_right_sagittal_deg[1000:].between(-15, 80).all()
    assert len(pd.read_csv("angles/summary.csv")) == 2
    results = pd.read_csv("run3/results.csv").set_index(["segment", "axis", "method"])
    assert {"thigh_right", "shank_right", "knee_right"} <= set(results.index.unique("segment"))
    error = results.loc["thigh_right", "sagittal", "narx"].rmse_deg
    assert (error < 0.5 * results.loc["thigh_right", "sagittal", "zero"].rmse_deg.to_numpy()).all()
    assert (recordings / "network.c").exists()
    own = pd.read_csv("own_angles/study/anna/walk/walk1_angles.csv")
    assert not own.equals(angles)
    # what is finished is left, until a recording changes
    assert "2 of 2 files finished before" in run_command(
        "predict", "data=study", "data_root=recordings", "output=angles"
    )[1]  # fmt: skip


def test_one_of_two_inputs(run_command, recordings):
    for overrides in (["output=a.csv"], ["input=a.csv", "data=study", "output=b"]):
        status, _, err, _ = run_command("predict", *overrides)
        assert status == 2
        assert "input and data: expected one of them" in err


def test_a_study_becomes_motion_bids(run_command, recordings):
    assert run_command("draft_study", "input=recordings")[0] == 0
    _markers_on_the_segment(recordings)
    status, _, err, _ = run_command(
        "predict", "data=study", "data_root=recordings", "output=angles", "format=motion_bids"
    )
    assert status == 0, err
    names = {path.name for path in (recordings / "angles").rglob("*_motion.tsv")}
    assert names == {
        f"sub-{who}_task-walk_tracksys-narx_acq-walk1_motion.tsv" for who in ("anna", "bert")
    }
    about = json.loads((recordings / "angles" / "dataset_description.json").read_text())
    assert about["DatasetType"] == "derivative"


def test_a_broken_trial_does_not_stop_the_others(run_command, recordings):
    status, _, _, _ = run_command("draft_study", "input=recordings")
    assert status == 0
    status, _, err, _ = run_command("draft_study", "input=recordings")
    assert status == 2
    assert "study.yaml already exists; overwrite=true replaces it" in err
    (recordings / "recordings" / "anna" / "walk1_thigh_right.csv").write_text("time_s,gyro\n0,1\n")
    status, out, err, _ = run_command(
        "predict", "data=study", "data_root=recordings", "output=angles"
    )
    assert status == 2
    assert "1 of 2 files refused, all others are done" in err
    assert "anna/walk1_thigh_right.csv: no column" in err
    assert "1 of 2 files with angles" in out
    assert (recordings / "angles/study/bert/walk/walk1_angles.csv").exists()


def test_a_trial_without_one_of_the_sensors_is_reported(run_command, recordings):
    study = 'files: "{subject}/{trial}_{segment}.csv"\n'
    (recordings / "recordings" / "study.yaml").write_text(study)
    for other in [*recordings.rglob("*_markers.csv"), *recordings.rglob("standing_*.csv")]:
        other.unlink()
    for number in (2, 3):
        for segment in ("thigh_right", "shank_right"):
            first = recordings / "recordings" / "anna" / f"walk1_{segment}.csv"
            first.with_name(f"walk{number}_{segment}.csv").write_bytes(first.read_bytes())
    (recordings / "recordings" / "anna" / "walk3_shank_right.csv").unlink()
    # opened sources are kept by the path as given, over the tests of one process
    root = recordings / "recordings"
    command = ["predict", "data=study", f"data_root={root}", "output=angles"]
    for repeated in (False, True):
        status, out, err, _ = run_command(*command)
        assert status == 2
        assert ("4 of 4 files finished before" in out) == repeated
        expected = "anna/walk/walk3: no sensor 'shank_right', which most trials have"
        assert f"1 of 4 recordings incomplete; the first: study/{expected}" in err
    table = pd.read_csv("angles/summary.csv").set_index("file")
    notes = table.notes["study/anna/walk/walk1"]
    assert notes.count("sensors aligned by their time stamps") == 1
    assert "; no reference; " in notes
    summary = table.status
    assert summary["study/anna/walk/walk3"] == "incomplete"
    assert (summary.drop("study/anna/walk/walk3") == "done").all()
    assert (recordings / "angles/study/anna/walk/walk3_angles.csv").exists()
