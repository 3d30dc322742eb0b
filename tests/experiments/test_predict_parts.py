"""A long session in parts: the angles of one pass, and identical files after a kill."""

import json

import numpy as np
import pandas as pd
import pytest
from omegaconf import OmegaConf
from scipy.spatial.transform import Rotation

from narx.errors import UserError
from narx.experiments.predictions.partitions import is_partitioned, part_jobs

SEGMENTS = ("thigh_right", "shank_right")
INPUT = "input={thigh_right: in/thigh_right.parquet, shank_right: in/shank_right.parquet}"
PARTS = ["partition_s=120", "format=parquet"]


def _walk(time, scale):
    """A stand of 4 s and then a walk in every minute: orientation of a segment, z up."""
    walked = np.maximum(time % 60.0 - 4.0, 0.0)
    ramp = np.clip(np.minimum(walked, 56.0 - walked), 0.0, 1.0)
    phase = 2 * np.pi * 0.9 * walked
    sagittal = scale * (18 * np.sin(phase) + 5 * np.sin(2 * phase + 0.9))
    angles = [5 * np.sin(phase + 2.5), -4 * np.sin(phase + 1.2), -sagittal]
    smooth = ramp**2 * (3 - 2 * ramp)
    return Rotation.from_euler("ZXY", np.column_stack([smooth * one for one in angles]), True)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    time, fine = np.arange(0.0, 360.0, 0.01), 1e-4
    for segment, scale in zip(SEGMENTS, (1.0, 1.5), strict=True):
        change = _walk(time - fine, scale).inv() * _walk(time + fine, scale)
        rate = change.as_rotvec() / (2 * fine)
        force = _walk(time, scale).inv().apply([0.0, 0.0, 9.81])
        columns = {"time_s": time}
        for k, axis in enumerate("xyz"):
            columns[f"gyroscope_{axis}_rad_s"] = rate[:, k]
            columns[f"accelerometer_{axis}_m_s2"] = force[:, k]
        pd.DataFrame(columns).to_parquet(f"in/{segment}.parquet", row_group_size=5000)
    return tmp_path


def _written(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*_angles.parquet"))}


def test_parts_are_the_whole_and_a_kill_costs_no_bytes(run_command, folder):
    status, out, err, _ = run_command("predict", INPUT, "output=day", *PARTS)
    assert (status, err) == (0, "")
    expected = _written(folder / "day")
    assert list(expected) == ["0000_angles.parquet", "0001_angles.parquet", "0002_angles.parquet"]
    parts = pd.concat([pd.read_parquet(folder / "day" / name) for name in expected])
    status, _, err, _ = run_command("predict", INPUT, "output=whole.parquet")
    assert (status, err) == (0, "")
    whole = pd.read_parquet("whole.parquet")
    # one clock throughout, no sample twice or lost
    np.testing.assert_allclose(parts.time_s, whole.time_s, atol=1e-9)
    name = "knee_right_sagittal_deg"
    difference = parts[name].to_numpy() - whole[name].to_numpy()
    # each part has its own calibration and, but for the first, no zero from standing
    for begin in (3000, 12_000, 24_000):
        assert np.nanstd(difference[begin : begin + 9000]) < 2.0
    # as a kill leaves it
    journal = folder / "day" / ".finished.jsonl"
    lines = journal.read_text("utf-8").splitlines()
    assert json.loads(lines[0])["file"] == "0000"
    journal.write_text(lines[0] + "\n" + lines[1][:30], "utf-8")
    (folder / "day" / "0001_angles.parquet").unlink()
    (folder / "day" / "0002_angles.parquet").unlink()
    status, out, err, _ = run_command("predict", INPUT, "output=day", *PARTS)
    assert (status, err) == (0, "")
    assert "1 of 3 files finished before" in out
    assert _written(folder / "day") == expected


def _job(folder, cut, **options):
    """Parts of 100 s of two sensors, of which `cut` leaves the rows from and to some times."""
    files = {}
    for segment, (begin, end) in cut.items():
        path = folder / "in" / f"{segment}.parquet"
        table = pd.read_parquet(path)
        table[(table.time_s >= begin) & (table.time_s <= end)].to_parquet(path)
        files[segment] = path
    cfg = OmegaConf.create({"columns": None, "device": None, "format": "csv"} | options)
    return files, part_jobs(cfg, files, folder / "day")


def test_parts_have_a_minute_of_lead_and_end_where_the_next_one_begins(folder):
    files, jobs = _job(
        folder, {"thigh_right": (10.0, 359.99), "shank_right": (0.0, 340.0)}, partition_s=100.0
    )
    # from the latest begin; 30 s after 310 s belong to the last part
    assert [(one.begin_s, one.end_s) for one in jobs] == [
        (10.0, 110.0), (110.0, 210.0), (210.0, np.inf),
    ]  # fmt: skip
    assert [one.first for one in jobs] == [True, False, False]
    assert [one.target.name for one in jobs] == [f"000{k}_angles.csv" for k in range(3)]
    times = {segment: pd.read_parquet(path).time_s for segment, path in files.items()}
    for one, lead in zip(jobs, (0.0, 60.0, 60.0), strict=True):
        for segment, (path, first, stop) in one.rows.items():
            assert path == files[segment]
            assert times[segment].iloc[first] == pytest.approx(one.begin_s - lead)
            if np.isfinite(one.end_s):
                # the sample at its end is the first of the next part
                assert times[segment].iloc[stop] == pytest.approx(one.end_s)
            else:
                assert stop == len(times[segment])


def test_a_last_part_of_more_than_a_minute_is_its_own(folder):
    _, jobs = _job(
        folder, {"thigh_right": (0.0, 270.0), "shank_right": (0.0, 359.0)}, partition_s=100.0
    )
    assert [one.begin_s for one in jobs] == [0.0, 100.0, 200.0]


def test_only_the_first_part_has_a_zero_and_a_stand(folder, monkeypatch):
    """A rest amid a day may be sitting."""
    given = []

    def spy(recordings, method, **options):
        given.append((options["start_pose"], options["still_s"]))
        raise UserError("seen")

    monkeypatch.setattr("narx.experiments.predictions.partitions.predict_session", spy)
    _, jobs = _job(
        folder, dict.fromkeys(SEGMENTS, (0.0, 359.0)), partition_s=100.0, checkpoint=None,
        smoothing=False, calibration="auto", start_pose="known",
    )  # fmt: skip
    for job in jobs:
        with pytest.raises(UserError, match="seen"):
            job._predicted()
    assert given == [("known", None), ("unknown", ()), ("unknown", ())]


@pytest.mark.parametrize(("most", "refused"), [(71_999, True), (72_000, False)])
def test_the_rows_of_all_sensors_count(folder, monkeypatch, most, refused):
    """36,000 of each of two."""
    monkeypatch.setattr("narx.experiments.predictions.partitions._MANY_ROWS", most)
    files = {segment: folder / "in" / f"{segment}.parquet" for segment in SEGMENTS}
    assert is_partitioned(files, folder / "day")
    if refused:
        with pytest.raises(UserError, match="one file for 72000 rows"):
            is_partitioned(files, folder / "day.csv")
    else:
        assert not is_partitioned(files, folder / "day.csv")


def test_clocks_may_begin_below_zero(folder):
    for segment in SEGMENTS:
        path = folder / "in" / f"{segment}.parquet"
        table = pd.read_parquet(path)
        table.assign(time_s=table.time_s - 200.0).to_parquet(path)
    _, jobs = _job(folder, dict.fromkeys(SEGMENTS, (-150.0, 150.0)), partition_s=200.0)
    assert [one.begin_s for one in jobs] == [-150.0, 50.0]


def test_a_long_session_needs_a_folder(run_command, folder, monkeypatch):
    monkeypatch.setattr("narx.experiments.predictions.partitions._MANY_ROWS", 1000)
    status, _, err, _ = run_command("predict", INPUT, "output=whole.parquet")
    assert status == 2
    assert "which are predicted in parts; expected a folder" in err


def test_wrong_clocks_are_one_line(run_command, folder):
    path = folder / "in" / "shank_right.parquet"
    table = pd.read_parquet(path)
    table.assign(time_s=table.time_s + 1000.0).to_parquet(path)
    status, _, err, _ = run_command("predict", INPUT, "output=day", *PARTS)
    assert (status, "the sensors have no time in common" in err) == (2, True)
    table.assign(time_s=table.time_s.to_numpy()[::-1]).to_parquet(path)
    status, _, err, _ = run_command("predict", INPUT, "output=day", *PARTS)
    assert (status, "shank_right.parquet: time goes back" in err) == (2, True)
    dates = pd.to_datetime(table.time_s, unit="s")
    table.assign(time_s=dates).to_parquet(path)
    status, _, err, _ = run_command("predict", INPUT, "output=day", *PARTS)
    assert (status, "shank_right.parquet: dates or counters as time" in err) == (2, True)


@pytest.mark.parametrize("option", ["walking_s=[10,20]", "still_s=[0,3]"])
def test_options_of_a_whole_session_are_refused_in_parts(run_command, folder, option):
    status, _, err, _ = run_command("predict", INPUT, "output=out", option)
    assert status == 2
    assert f"error: {option[:7]}" in err
    assert "predicted at once" in err
    assert not (folder / "out").exists()
