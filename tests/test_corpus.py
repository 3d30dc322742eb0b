"""Inputs that the fuzzer has found end with a plausible result or one line (tests/fuzz.py)."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fuzz_targets import TARGETS, outcome, whole_files

TESTS = Path(__file__).parent
INPUTS = sorted(path for path in (TESTS / "corpus").rglob("*") if path.is_file())


@pytest.mark.parametrize("path", INPUTS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_found_input_ends_with_a_result_or_one_line(path, tmp_path):
    assert outcome(path.parent.name, path.read_bytes(), tmp_path / "input") is None


@pytest.mark.parametrize("target", TARGETS)
def test_a_whole_file_ends_with_a_result_or_one_line(target, tmp_path):
    for name, content in whole_files(target).items():
        assert outcome(target, content, tmp_path / "input") is None, name


def test_the_corpus_is_small_and_has_inputs_of_every_target():
    assert {path.parent.name for path in INPUTS} == set(TARGETS)
    assert sum(path.stat().st_size for path in INPUTS) < 200_000


def test_a_reader_that_is_wrong_is_noticed(tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz_targets.seconds_of", lambda lines: np.full(len(lines), np.inf))
    assert "AssertionError" in outcome("times", b"12:00:00", tmp_path / "input")


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("atheris") is None, reason="needs atheris")
def test_a_minute_of_fuzzing_finds_nothing(tmp_path):
    ran = subprocess.run(
        [sys.executable, str(TESTS / "fuzz.py"), "all", "60", str(tmp_path), "1"],
        # the order of sets decides which input covers a line first
        env=os.environ | {"PYTHONHASHSEED": "0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    executed = dict(re.findall(r"^(\w+): (\d+) inputs, 0 faults$", ran.stdout, re.MULTILINE))
    assert set(executed) == set(TARGETS)
    assert sum(map(int, executed.values())) > 200
