"""A folder of recordings: valid ones are processed, the others are listed."""

import json
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from narx.datasets import write_recording
from narx.recordings.trial import ImuRecording


@pytest.fixture
def folder(tmp_path, motion, monkeypatch):
    monkeypatch.chdir(tmp_path)
    walk = motion("stand_walk_stand", duration_s=20.0)
    sagittal, frontal, transverse = walk.signals.axis_rates_rad_s.T
    gyroscope = np.column_stack([-frontal, -sagittal, transverse])
    for k, name in enumerate(["S1/thigh_right.csv", "S1/thigh_left.csv", "S2/läufer.csv"]):
        rate = gyroscope * (1.0 + 0.02 * k)
        write_recording(
            f"in/{name}",
            ImuRecording("imu", walk.time_s, rate, np.full_like(rate, np.nan)),
        )
    (tmp_path / "in" / "S1" / "broken.csv").write_text("time_s,gyroscope_x_rad_s\n0,1\n")
    (tmp_path / "in" / "notes.md").write_text("not a recording")
    return tmp_path


def _written(folder):
    return {p.relative_to(folder).as_posix(): p.read_bytes()
            for p in sorted((folder / "out").rglob("*_angles.csv"))}  # fmt: skip


def test_one_broken_file_does_not_stop_the_others(run_command, folder):
    status, out, err, _ = run_command("predict", "input=in", "output=out")
    assert status == 2
    assert (
        "1 of 4 files refused, all others are done; the first: in/S1/broken.csv: no column" in err
    )
    assert len(err.strip().splitlines()) == 1
    assert "3 of 4 files with angles" in out
    summary = pd.read_csv("out/summary.csv").set_index("file")
    assert list(summary.index) == [
        "S1/broken.csv", "S1/thigh_left.csv", "S1/thigh_right.csv", "S2/läufer.csv",
    ]  # fmt: skip
    assert summary.status.to_dict()["S1/broken.csv"] == "refused"
    assert "no column 'gyroscope_y_rad_s'" in summary.reason["S1/broken.csv"]
    assert summary.reason[summary.status == "done"].isna().all()
    # a refused file may be too large to hash, or endless
    hashed = json.loads((folder / "out" / "record.json").read_text())["environment"]["data_sha256"]
    assert {Path(path).name for path in hashed} == {
        "thigh_left.csv", "thigh_right.csv", "läufer.csv",
    }  # fmt: skip
    assert (summary.n_angles[summary.status == "done"] == 2001).all()
    assert set(_written(folder)) == {
        "out/S1/thigh_right_csv_angles.csv", "out/S1/thigh_left_csv_angles.csv",
        "out/S2/läufer_csv_angles.csv",
    }  # fmt: skip


def test_each_file_is_independent_and_its_name_gives_the_side(run_command, folder):
    run_command("predict", "input=in/**/thigh_*.csv", "output=out")
    for side in ("right", "left"):
        status, *_ = run_command(
            "predict", f"input=in/S1/thigh_{side}.csv", "output=one.csv", f"side={side}"
        )
        assert status == 0
        alone = (folder / "one.csv").read_bytes()
        assert (folder / f"out/S1/thigh_{side}_csv_angles.csv").read_bytes() == alone
    record = json.loads((folder / "out" / "record.json").read_text())
    assert record["configuration"]["input"] == "in/**/thigh_*.csv"
    assert set(record["environment"]["data_sha256"]) == {
        "in/S1/thigh_right.csv", "in/S1/thigh_left.csv",
    }  # fmt: skip


def test_finished_files_are_kept_and_killed_ones_repeated(run_command, folder):
    (folder / "in" / "S1" / "broken.csv").unlink()
    status, _, err, _ = run_command("predict", "input=in", "output=out")
    assert (status, err) == (0, "")
    expected, summary = _written(folder), (folder / "out/summary.csv").read_bytes()
    journal = folder / "out" / ".finished.jsonl"
    lines = journal.read_text("utf-8").splitlines()
    # as a kill leaves it: one file done, the next one's line cut off, no summary
    journal.write_text(lines[0] + "\n" + lines[1][:20], "utf-8")
    (folder / "out/summary.csv").unlink()
    for path in sorted((folder / "out").rglob("*_angles.csv"))[1:]:
        path.unlink()
    status, out, err, _ = run_command("predict", "input=in", "output=out")
    assert (status, err) == (0, "")
    assert "1 of 3 files finished before" in out
    assert _written(folder) == expected
    assert (folder / "out/summary.csv").read_bytes() == summary
    _, out, _, _ = run_command("predict", "input=in", "output=out", "side=left")
    assert "finished before" not in out


def test_an_output_within_the_input_is_no_recording(run_command, folder):
    for _ in range(2):
        run_command("predict", "input=in", "output=in/out")
        assert len(pd.read_csv("in/out/summary.csv")) == 4


@pytest.mark.slow
def test_processes_give_the_same_files(run_command, folder):
    run_command("predict", "input=in", "output=out")
    expected = _written(folder)
    status, _, err, _ = run_command("predict", "input=in", "output=two/out", "jobs=2")
    assert status == 2
    assert "1 of 4 files refused" in err
    assert {name.removeprefix("two/"): data for name, data in {
        p.relative_to(folder).as_posix(): p.read_bytes()
        for p in (folder / "two").rglob("*_angles.csv")
    }.items()} == expected  # fmt: skip


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["input=in/*.xyz", "output=out"], "input: no file in 'in/*.xyz' that ends in .csv"),
        (["input=in", "output=in/notes.md"], "output: 'in/notes.md' is a file, expected a folder"),
        (["input=in", "output=out", "format=doc"], "format is 'doc', expected"),
        (["input=in", "output=in"], "output: 'in' is also the input, or above it; expected"),
        (["input=in/*.csv", "output=."], "output: '.' is also the input, or above it; expected"),
        (["input=in", "output=out", "partition_s=300"], "partition_s is 300.0, which is an option"),
    ],
)
def test_mistakes_are_one_line(run_command, folder, overrides, message):
    status, _, err, _ = run_command("predict", *overrides)
    assert status == 2
    assert message in err
    assert len(err.strip().splitlines()) == 1


@pytest.mark.concurrency
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of the cluster's own threads and sockets
def test_a_dask_cluster_gives_the_same_files(run_command, folder):
    distributed = pytest.importorskip("distributed")
    run_command("predict", "input=in", "output=out")
    expected, summary = _written(folder), (folder / "out/summary.csv").read_bytes()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        status, _, err, _ = run_command(
            "predict", "input=in", "output=two/out", f"scheduler={cluster.scheduler_address}"
        )
    assert status == 2
    assert "1 of 4 files refused" in err
    found = {p.relative_to(folder / "two").as_posix(): p.read_bytes()
             for p in (folder / "two").rglob("*_angles.csv")}  # fmt: skip
    assert found == expected
    assert (folder / "two/out/summary.csv").read_bytes() == summary


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_without_workers_is_waited_for_and_this_is_said(run_command, folder, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("narx.experiments.predictions.workers._PATIENCE_S", 1.0)
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        starting = threading.Timer(5.0, cluster.scale, args=(1,))
        starting.start()
        _, _, err, _ = run_command(
            "predict", "input=in", "output=out", f"scheduler={cluster.scheduler_address}"
        )
        starting.join()
    assert err.count("has no workers; waiting for one") == 1
    assert len(list((folder / "out").rglob("*_angles.csv"))) == 3


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_goes_away_is_one_line(run_command, folder):
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    # how long the client tries to connect again
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        distributed.LocalCluster(
            n_workers=0, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
    ):
        closing = threading.Timer(3.0, cluster.close)
        closing.start()
        status, _, err, _ = run_command(
            "predict", "input=in", "output=out", f"scheduler={cluster.scheduler_address}"
        )
        closing.join()
    assert status == 2
    assert f"error: scheduler: '{cluster.scheduler_address}' lost the connection (" in err
    assert "Traceback" not in err
    assert not list((folder / "out").rglob("*_angles.csv"))


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_is_not_there_is_one_line(run_command, folder, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("narx.experiments.predictions.workers._CONNECT_S", 1)
    status, _, err, _ = run_command(
        "predict", "input=in", "output=out", "scheduler=tcp://127.0.0.1:9"
    )
    assert status == 2
    assert "scheduler: no Dask scheduler at 'tcp://127.0.0.1:9'" in err
    assert len(err.strip().splitlines()) == 1
