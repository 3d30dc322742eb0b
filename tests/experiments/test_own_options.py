"""The examples of docs/sweeps.md for a user's own options run as printed."""

import re
from pathlib import Path

import pytest

from narx.inference import load

DOCUMENT = Path(__file__).parents[2] / "docs" / "sweeps.md"
EXAMPLES = re.findall(r"```yaml\n# my_configs/(\S+)\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)


@pytest.fixture
def folder(tmp_path):
    for name, text in EXAMPLES:
        path = tmp_path / "my_configs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "my_configs"


def test_own_model_and_optimizer_train(run_command, folder):
    assert {name for name, _ in EXAMPLES} == {"model/wide.yaml", "optimizer/patient.yaml"}
    status, _, err, directory = run_command(
        "train", "--config-dir", str(folder), "debug=tiny", "model=wide", "optimizer=patient",
        "optimizer.iterations=3",
    )  # fmt: skip
    assert status == 0, err
    assert load(directory / "checkpoint.pt").model.structure.hidden == 8


def test_own_options_are_listed(run_command, folder):
    status, out, err, _ = run_command("train", "--help", "--config-dir", str(folder))
    assert status == 0, err
    assert "wide" in out
