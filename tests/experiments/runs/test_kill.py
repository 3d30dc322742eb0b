"""`kill -9` costs a sweep time, not results."""

import importlib.util
import sys
from pathlib import Path

import pytest

pytest.importorskip("plotly")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_sweep_that_was_killed_ends_with_the_same_table(tmp_path):
    spec = importlib.util.spec_from_file_location(
        "kill_sweep", Path(__file__).with_name("kill_sweep.py")
    )
    kill_sweep = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(kill_sweep)
    overrides = ("debug=tiny", "seed=0,1,2", "optimizer=levenberg_marquardt,lbfgs")
    assert kill_sweep.disturbed_equals_undisturbed(tmp_path, overrides, kills=2) >= 1
