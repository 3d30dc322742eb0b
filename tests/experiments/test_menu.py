"""`--help` names groups, keys and their meaning; presets compose and run."""

import json
import re
from pathlib import Path

import pytest

from narx.experiments.configuration.schemas import SCHEMAS

HERE = Path(__file__).parents[2]


@pytest.mark.parametrize("command", ["train", "predict", "demo_recordings", "benchmark_page"])
def test_help_has_examples_groups_and_meanings(run_command, command):
    status, out, err, _ = run_command(command, "--help")
    assert status == 0, err
    first = (HERE / "configs" / f"{command}.yaml").read_text().splitlines()[0]
    assert out.splitlines()[0] == first.removeprefix("# ")
    # only groups that the command takes
    assert ("== Groups" in out) == (command in ("train", "predict"))
    assert ("data: broad, " in out) == (command in ("train", "predict"))
    assert ("optimizer: adam, lbfgs, levenberg_marquardt" in out) == (command == "train")
    if command == "train":
        assert "\nexperiment: abhayasinghe_thigh_angle, han_two_point, tham_knee_angle\n" in out
        assert "narx-train -m seed=0,1,2" in out
        assert "seed: 0                        # sets the three seeds below" in out
        assert "hidden: 3                      # tanh neurons" in out


@pytest.mark.parametrize("command", SCHEMAS)
def test_every_command_has_this_help(command):
    text = (HERE / "configs" / f"{command}.yaml").read_text()
    assert "  - override hydra/help: narx\n" in text
    assert re.match(r"# .+\n(#   (python -m|narx-).+\n)+", text)


def test_help_follows_the_choice(run_command):
    _, out, _, _ = run_command("train", "--help", "optimizer=adam")
    assert "# optimizer=adam" in out
    assert "learning_rate: 0.03" in out


@pytest.mark.parametrize(
    ("command", "heading", "line"),
    [
        ("as_printed", "# as_printed=default", "draws: 20 "),
        ("benchmark", "# model@model_axis_by_axis=tham_literal", "model_axis_by_axis:"),
        ("benchmark", "# method=vqf", "    tau_acc_s: 3.0 "),
    ],
)
def test_help_has_the_keys_of_every_choice(run_command, command, heading, line):
    _, out, _, _ = run_command(command, "--help")
    shown = out[out.index(heading) :]
    assert any(each.startswith(line) for each in shown.splitlines())


def test_keys_of_an_experiment_are_shown_where_they_are_set(run_command):
    _, out, _, _ = run_command("benchmark", "--help", "experiment=han_two_point")
    assert "# experiment=han_two_point\nreport:\n" in out


def test_a_short_window_can_be_overfitted(run_command):
    status, _, err, directory = run_command("train", "debug=overfit")
    assert status == 0, err
    assert json.loads((directory / "metrics.json").read_text())["held_back_error_deg"] < 0.5


def test_a_profile_lists_the_slowest_functions(run_command):
    status, out, err, directory = run_command("train", "debug=tiny", "profile=true")
    assert status == 0, err
    assert (directory / "profile.pstats").stat().st_size > 0
    assert "cumulative" in out


def test_training_uses_the_walks_of_an_experiment(run_command):
    status, out, err, _ = run_command(
        "train", "--cfg", "job", "--resolve", "experiment=abhayasinghe_thigh_angle"
    )
    assert status == 0, err
    assert "protocol: stand_walk_stand" in out
