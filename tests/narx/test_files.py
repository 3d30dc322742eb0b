"""Files are complete or absent, even if writing fails."""

import errno
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.figure
import numpy as np
import pandas as pd
import pytest

from narx.errors import UserError
from narx.evaluation.results import results_table, write_results
from narx.experiments.figures.canvas import save_figure
from narx.experiments.predictions.angle_files import write_angles
from narx.experiments.runs.record import write_json
from narx.files import atomic_path, remove_temporaries
from narx.inference import checkpoint as checkpoints
from narx.inference.pretrained import load_or_pretrained

ROOT = Path(__file__).resolve().parents[2]
KILLED = """
import os, signal, sys
from narx.files import atomic_path
with atomic_path(sys.argv[1]) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_file_appears_whole_with_the_usual_permissions(tmp_path):
    target = tmp_path / "new" / "a.txt"
    with atomic_path(target) as temporary:
        temporary.write_text("all")
        assert not target.exists()
        assert temporary.suffix == ".txt"
    plain = tmp_path / "plain.txt"
    plain.touch()
    assert target.read_text() == "all"
    assert target.stat().st_mode == plain.stat().st_mode
    assert os.listdir(target.parent) == ["a.txt"]


def test_an_error_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def write_half():
        with atomic_path(target) as temporary:
            temporary.write_text("half")
            raise KeyError

    with pytest.raises(KeyError):
        write_half()
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.txt", "old")]


def test_a_killed_process_leaves_a_temporary_that_is_cleaned(tmp_path):
    target = tmp_path / "run" / "a.png"
    target.parent.mkdir()
    target.write_text("old")
    answer = subprocess.run([sys.executable, "-c", KILLED, str(target)], cwd=ROOT, check=False)
    assert answer.returncode == -signal.SIGKILL
    assert target.read_text() == "old"
    assert len(os.listdir(target.parent)) == 2
    remove_temporaries(tmp_path, unused_s=3600.0)  # it may belong to a running process
    assert len(os.listdir(target.parent)) == 2
    remove_temporaries(tmp_path)
    assert os.listdir(target.parent) == ["a.png"]


def _results():
    names = dict.fromkeys(("dataset", "subject", "condition", "trial", "segment"), "x")
    numbers = dict.fromkeys(
        ("bias_deg", "precision_deg", "rmse_deg", "r", "loa_lower_deg", "loa_upper_deg", "lag_ms"),
        0.5,
    )
    return results_table(
        [{**names, "axis": "sagittal", "method": "narx", "n_samples": 1, **numbers}] * 5000
    )


WRITERS = {
    "results.csv": lambda path: write_results(_results(), path),
    "run.json": lambda path: write_json({"values": list(range(50_000))}, path),
    "angles.csv": lambda path: write_angles(pd.DataFrame({"a": np.zeros(99_999)}), path),
    "angles.parquet": lambda path: write_angles(
        pd.DataFrame({"a": np.random.default_rng(0).normal(size=99_999)}), path
    ),
    "checkpoint.pt": lambda path: checkpoints.save(load_or_pretrained(None), path),
    "figure.png": lambda path: save_figure(matplotlib.figure.Figure((20, 20)), path),
}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_the_old_file(tmp_path, monkeypatch, name):
    """Write every temporary file to a device without free space."""
    target = tmp_path / name
    target.write_text("old")
    made = tempfile.mkstemp

    def on_full_disk(**where):
        handle, path = made(**where)
        os.unlink(path)
        os.symlink("/dev/full", path)
        return handle, path

    monkeypatch.setattr("narx.files.tempfile.mkstemp", on_full_disk)
    with pytest.raises((OSError, UserError), match="No space left") as error:
        WRITERS[name](target)
    if isinstance(error.value, OSError):  # what a command reports in one line
        assert error.value.errno == errno.ENOSPC
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [(name, "old")]
