"""If the disk fills up while figures are written, the results are kept."""

import errno
import importlib
import json

import pytest

from narx.evaluation.results import read_results
from narx.inference import checkpoint as checkpoints

SMALL = (
    "data.simulated_gait.subjects=[S1]",
    "data.simulated_gait.conditions=[normal]",
    "data.simulated_gait.treadmill_duration_s=60",
    "data.simulated_gait.sampling_rate_hz=100",
    "split=one_window",
    "split.latest_s=30",
    "split.validation_s=10",
    "optimizer.restarts=1",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "module", "network"),
    [
        ("train", "narx.experiments.train", "checkpoint.pt"),
        ("benchmark", "narx.experiments.reports.summary", "networks/*.pt"),
    ],
)
def test_network_and_results_are_written_before_figures(
    run_command, monkeypatch, command, module, network
):
    def no_room(figure, path):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr(importlib.import_module(module), "save_figure", no_room)
    methods = ["methods=[narx,zero]"] if command == "benchmark" else []
    status, _, err, directory = run_command(command, *SMALL, *methods)
    assert status == 2, err
    (line,) = (line for line in err.splitlines() if line.startswith("error: "))
    assert "figures" in line
    assert "No space left on device" in line
    assert "Traceback" not in err
    (path,) = directory.glob(network)
    assert checkpoints.load(path).model.weights.numel()
    assert len(read_results(directory / "results.csv"))
    assert (directory / "summary.md").stat().st_size
    assert json.loads((directory / "run.json").read_text())["state"] == "failed"
    assert not list(directory.rglob(".narx-*"))
