"""A user's own learning method is cross-validated over subjects beside the network."""

import importlib
import re
import sys
from pathlib import Path

import pytest

from narx.evaluation.results import read_results

DOCUMENT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text()
SMALL = (
    "data.simulated_gait.subjects=[S1,S2]",
    "data.simulated_gait.conditions=[normal]",
    "data.simulated_gait.treadmill_duration_s=40",
    "data.simulated_gait.sampling_rate_hz=50",
    "optimizer.restarts=1",
    "optimizer.iterations=5",
    "split=leave_one_subject_out",
)


@pytest.fixture
def own_method(tmp_path, monkeypatch):
    """Write the example of CONTRIBUTING.md as it is printed; return its module and its folder."""
    (code,) = [c for c in re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL) if "Gru" in c]
    (settings,) = re.findall(
        r"```yaml\n# my_configs/method/gru.yaml\n(.*?)```", DOCUMENT, re.DOTALL
    )
    (tmp_path / "my_methods.py").write_text(code)
    (tmp_path / "my_configs" / "method").mkdir(parents=True)
    (tmp_path / "my_configs" / "method" / "gru.yaml").write_text(settings)
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module("my_methods"), str(tmp_path / "my_configs")
    del sys.modules["my_methods"]


@pytest.mark.slow
def test_the_example_learns_and_is_tested_person_by_person(run_command, monkeypatch, own_method):
    module, configs = own_method
    fit, trained_on = module.Gru.fit, []

    def spy(self, training, seed):
        trained_on.append({sequence.name.split("/")[1] for sequence in training})
        fit(self, training, seed)

    monkeypatch.setattr(module.Gru, "fit", spy)
    status, _, err, directory = run_command(
        "benchmark", "--config-dir", configs, "+method=gru", "methods=[narx,gru,zero]", *SMALL
    )
    assert status == 0, err
    assert len(trained_on) == 2
    (one,), (other,) = trained_on
    assert one != other
    results = read_results(directory / "results.csv")
    assert set(results["subject"]) == {"S1", "S2"}
    sagittal = results[results["axis"] == "sagittal"]
    rmse = sagittal.groupby(["subject", "method"])["rmse_deg"].mean().unstack()
    assert set(rmse) == {"narx", "gru", "zero"}
    assert (rmse["gru"] < 0.5 * rmse["zero"]).all()


def test_without_a_training_part_it_is_refused(run_command, own_method):
    _, configs = own_method
    status, _, err, _ = run_command(
        "benchmark", "--config-dir", configs, "+method=gru", "methods=[gru]", *SMALL[:4],
        "split=pretrained",
    )  # fmt: skip
    assert status == 2
    assert err.strip().splitlines()[-1] == (
        "error: methods: gru learns, and this split has nothing to train on; expected one with a "
        "training part, such as split=leave_one_subject_out"
    )


def test_a_grid_for_it_is_refused(run_command, own_method):
    _, configs = own_method
    status, _, err, _ = run_command(
        "benchmark", "--config-dir", configs, "+method=gru", "methods=[gru]", *SMALL,
        "+grid.gru.hidden=[4,8]",
    )  # fmt: skip
    assert status == 2
    assert "error: grid.gru: its parameters are determined in training" in err
