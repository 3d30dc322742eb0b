"""A command started in a read-only folder reports it in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def run(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "narx.experiments.train", *arguments], capture_output=True,
        text=True, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip


def check_one_line(answer, name):
    assert answer.returncode == 2
    (line,) = answer.stderr.splitlines()
    assert line.startswith(f"error: {name}")
    assert "hydra.run.dir=DIR" in line


@pytest.mark.parametrize(("name", "arguments"), [("outputs", []), ("multirun", ["-m", "seed=0,1"])])
def test_a_file_in_the_place_of_the_folder(name, arguments, tmp_path):
    (tmp_path / name).write_text("")
    check_one_line(run(tmp_path, *arguments), name)
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.skipif(not Path("/sys/kernel").is_dir(), reason="no folder that refuses every user")
@pytest.mark.parametrize(("name", "arguments"), [("outputs", []), ("multirun", ["-m", "seed=0,1"])])
def test_a_folder_that_refuses_new_files(name, arguments):
    check_one_line(run("/sys/kernel", *arguments), name)
