"""Ctrl-C in a single run: one line says how to continue, finished work is kept."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from narx.inference import checkpoint as checkpoints

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="no process groups"),
]
LONGEST_WAIT_S = 240.0


def launch(command, *overrides, folder):
    return subprocess.Popen(
        [sys.executable, "-P", "-m", f"narx.experiments.{command}", *overrides],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # a suite that was started in the background ignores the signal, and so would the command
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def interrupted(process, when):
    """Press Ctrl-C, which reaches all processes of a terminal, as soon as a condition holds."""
    until = time.monotonic() + LONGEST_WAIT_S
    try:
        while not when():
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < until
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=LONGEST_WAIT_S)
    finally:
        process.kill()
    assert process.returncode == 130, err
    assert "Traceback" not in err
    return [line for line in err.splitlines() if line.startswith("interrupted")]


def to_the_end(process):
    out, err = process.communicate(timeout=LONGEST_WAIT_S)
    assert process.returncode == 0, err
    return out


def state(folder):
    record = folder / "run.json"
    return json.loads(record.read_text())["state"] if record.exists() else None


@pytest.mark.slow
@pytest.mark.parametrize("in_the_fit", [False, True])
def test_a_training(tmp_path, in_the_fit):
    folder = tmp_path / "run"
    overrides = ("debug=tiny", "optimizer=adam", "hydra.run.dir=run")
    process = launch("train", *overrides, "optimizer.iterations=200000", folder=tmp_path)
    lines = interrupted(
        process,
        lambda: any(folder.glob("last/[!.]*.pt")) if in_the_fit else state(folder) == "started",
    )
    assert lines == [
        f"interrupted: finished work is kept; repeat the command with hydra.run.dir={folder} "
        "to continue"
    ]
    assert state(folder) == "interrupted"
    assert any(folder.glob("last/[!.]*.pt")) == in_the_fit
    assert not (folder / "checkpoint.pt").exists()
    to_the_end(launch("train", *overrides, folder=tmp_path))
    assert state(folder) == "finished"
    assert checkpoints.load(folder / "checkpoint.pt")


def test_a_benchmark(tmp_path):
    folder = tmp_path / "run"
    overrides = ("debug=tiny", "methods=[zero,narx]", "optimizer=adam", "hydra.run.dir=run")
    process = launch("benchmark", *overrides, "optimizer.iterations=200000", folder=tmp_path)
    (line,) = interrupted(process, lambda: state(folder) == "started")
    assert line.endswith(f"repeat the command with hydra.run.dir={folder} to continue")
    assert not (folder / "results.csv").exists()


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_angles_of_many_files(tmp_path, jobs):
    to_the_end(launch("demo_recordings", "output=demo", "duration_s=20", folder=tmp_path))
    for number in range(24):
        (tmp_path / "walks").mkdir(exist_ok=True)
        os.link(tmp_path / "demo" / "thigh_right.csv", tmp_path / "walks" / f"{number}.csv")
    angles = tmp_path / "angles"
    call = ("predict", "input=walks", "output=angles", f"jobs={jobs}")
    process = launch(*call, folder=tmp_path)
    # a file is finished when the journal says so, shortly after its angles are there
    journal = angles / ".finished.jsonl"
    lines = interrupted(process, lambda: journal.exists() and "\n" in journal.read_text())
    assert lines == ["interrupted: finished work is kept; repeat the command to do the rest"]
    assert 0 < len(list(angles.glob("[0-9]*.csv"))) < 24
    assert "finished before, left as they are" in to_the_end(launch(*call, folder=tmp_path))
    assert len(list(angles.glob("[0-9]*.csv"))) == 24
