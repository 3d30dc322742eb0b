"""`kill -9` costs a command time, not results."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("plotly")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills forks of itself")
def test_killed_commands_leave_whole_files_and_end_with_the_same_results(tmp_path):
    script = Path(__file__).with_name("kill_commands.py")
    commands = ("predict", "export", "sweep")
    done = subprocess.run(
        [sys.executable, script, tmp_path, "--kills", "7", "--commands", *commands,
         "--sweep", "debug=tiny", "optimizer=levenberg_marquardt,lbfgs"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the same table, bit for bit" in done.stdout
