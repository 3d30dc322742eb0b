"""The table of changed lines matches the sources, and the tests detect the changes."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "tests" / "changed_lines.py"
# quick ones; NARX_CHANGED_LINES=all runs every entry, or those that contain one of its words
FEW = "Welch harmonic unwrap Nielsen"


@pytest.fixture(scope="module")
def table():
    spec = importlib.util.spec_from_file_location("changed_lines", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.table()


def test_every_original_occurs_once_and_every_test_exists(table):
    for change in table:
        source = (ROOT / change.file).read_text(encoding="utf-8")
        assert source.count(change.original) == 1, change
        assert change.original != change.changed, change
        assert change.tests, change
        for test in change.tests:
            file, _, name = test.partition("::")
            assert (ROOT / file).exists(), change
            assert not name or f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), change
    assert len({(c.file, c.original, c.changed) for c in table}) == len(table)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks a process for each change")
def test_a_changed_line_is_noticed():
    words = os.environ.get("NARX_CHANGED_LINES", FEW)
    answer = subprocess.run(
        [sys.executable, "-W", "ignore", SCRIPT, *([] if words == "all" else words.split())],
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
