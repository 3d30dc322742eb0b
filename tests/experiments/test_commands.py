"""The commands end to end on small walks, and what they say to a user's mistake."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch
from omegaconf import OmegaConf
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.plugins.hparams.plugin_data_pb2 import HParamsPluginData

from narx.datasets import write_recording
from narx.evaluation.results import read_results
from narx.experiments import benchmark
from narx.inference import checkpoint as checkpoints
from narx.recordings.trial import ImuRecording

# a minute of one walker is enough to see that everything is wired
SMALL = (
    "data.simulated_gait.subjects=[S1]",
    "data.simulated_gait.conditions=[normal]",
    "data.simulated_gait.treadmill_duration_s=75",
    "data.simulated_gait.sampling_rate_hz=100",
)
QUICK = ("split=one_window", "split.latest_s=45", "split.validation_s=10", "optimizer.restarts=2")


def one_line_error(status, out, err):
    assert status == 2
    assert "Traceback" not in err + out
    lines = [line for line in err.splitlines() if line.strip()]
    assert len(lines) == 1
    assert lines[0].startswith("error: ")
    return lines[0]


def test_training_leaves_configuration_checkpoint_and_events(run_command):
    status, _, err, directory = run_command("train", *SMALL, *QUICK, "seed=3")
    assert status == 0, err
    checkpoint = checkpoints.load(directory / "checkpoint.pt")
    assert checkpoint.model.structure.n_weights == 19
    assert torch.isfinite(checkpoint.model.weights).all()
    assert OmegaConf.load(directory / ".hydra" / "config.yaml").seed == 3
    assert json.loads((directory / "environment.json").read_text())["seed"] == 3
    events = EventAccumulator(str(directory / "tensorboard")).Reload()
    assert {"training/restart_00/cost_deg2", "held_back_error_deg"} <= set(events.Tags()["scalars"])
    history = json.loads((directory / "training.json").read_text())["report"]["history"]
    for name in ("cost_deg2", "damping", "gradient"):
        curve = [event.value for event in events.Scalars(f"training/best_start/{name}")]
        finite = [row[name] for row in history if row[name] is not None]
        assert curve == pytest.approx(finite, rel=1e-6)
    assert {event.value for event in events.Scalars("training/best_start/accepted")} <= {0.0, 1.0}
    assert 0.5 < events.Scalars("largest_pole")[-1].value < 1.0
    assert "training" in events.Tags()["images"]
    assert (directory / "figures" / "training.png").stat().st_size > 0


def test_the_same_seed_gives_the_same_weights(run_command):
    weights = []
    for seed in (0, 0, 1):
        *_, directory = run_command("train", *SMALL, *QUICK, f"seed={seed}")
        weights.append(checkpoints.load(directory / "checkpoint.pt").model.weights.detach())
        shutil.rmtree(directory)
    assert torch.equal(weights[0], weights[1])
    assert not torch.equal(weights[0], weights[2])


def test_a_sweep_leaves_runs_that_compare(run_command, tmp_path):
    sweep = tmp_path / "sweep"
    two_people = ("data.simulated_gait.subjects=[S1,S2]", *SMALL[1:])
    overrides = ("train", "-m", *two_people, *QUICK, "seed=0,1", f"hydra.sweep.dir={sweep}")
    status, _, err, _ = run_command(*overrides)
    assert status == 0, err
    runs = sorted(sweep.glob("seed=*"))
    assert [run.name[:7] for run in runs] == ["seed=0-", "seed=1-"]
    shown = []
    for run in runs:
        assert checkpoints.load(run / "checkpoint.pt")
        assert (run / ".hydra" / "overrides.yaml").is_file()
        assert json.loads((run / "run.json").read_text())["state"] == "finished"
        timing = json.loads((run / "timing.json").read_text())
        assert 0 < timing["training_s"] < timing["run_s"]
        assert "RMSE (°) on the training trials" in (run / "summary.md").read_text()
        results = read_results(run / "results.csv")
        assert set(results["method"]) == {"narx"}
        assert len(list((run / "tensorboard").glob("events*"))) == 1
        events = EventAccumulator(str(run / "tensorboard")).Reload()
        shown.append((sorted(events.Tags()["scalars"]), sorted(events.Tags()["histograms"])))
        metrics = json.loads((run / "metrics.json").read_text())
        for tag, value in metrics.items():
            assert events.Scalars(tag)[-1].value == pytest.approx(value, rel=1e-6)
        settings = HParamsPluginData.FromString(
            events.PluginTagToContent("hparams")["_hparams_/session_start_info"]
        ).session_start_info.hparams
        assert settings["seed"].number_value == float(run.name[5])
        assert settings["optimizer"].string_value == "levenberg_marquardt"
        # what was set here, and nothing that is only in the files
        assert "data.simulated_gait.subjects" in settings
        assert len(settings) < 20
        assert not any("_target_" in key for key in settings)
    # two people were drawn, and yet the curves share their charts
    assert shown[0] == shown[1]
    people = {json.loads((run / "training.json").read_text())["fold"][:2] for run in runs}
    assert people == {"S1", "S2"}
    before = {path: path.stat().st_mtime_ns for run in runs for path in run.rglob("*")}
    assert run_command(*overrides)[0] == 0
    assert {path: path.stat().st_mtime_ns for run in runs for path in run.rglob("*")} == before


def test_benchmark_leaves_results_summary_and_figures(run_command):
    methods = "[narx,narx_smoothed,pseudo_integrator,complementary_filter,gyro_integration]"
    status, out, err, directory = run_command("benchmark", *SMALL, *QUICK, f"methods={methods}")
    assert status == 0, err
    results = read_results(directory / "results.csv")
    assert set(results["method"]) == {
        "narx", "narx_smoothed", "gyro_integration", "gyro_integration_start_up",
        "gyro_integration_same",
        "pseudo_integrator", "pseudo_integrator_chosen",
        "pseudo_integrator_same", "pseudo_integrator_same_chosen",
        "complementary_filter", "complementary_filter_chosen",
        "complementary_filter_same", "complementary_filter_same_chosen",
    }  # fmt: skip
    timing = json.loads((directory / "timing.json").read_text())
    assert set(timing["methods_s"]) == set(results["method"])
    assert 0.0 < timing["all_methods_s"] + timing["training_s"] <= timing["run_s"]
    assert set(results["axis"]) == {"sagittal", "frontal", "transverse"}
    assert {"knee_right", "knee_left", "thigh_right", "shank_left"} <= set(results["segment"])
    transverse = results[
        (results["axis"] == "transverse") & (results["method"] == "complementary_filter")
    ]
    assert transverse["rmse_deg"].isna().all()
    assert (transverse["n_samples"] == 0).all()
    sagittal = results[(results["segment"] == "knee_right") & (results["axis"] == "sagittal")]
    rmse = sagittal.set_index("method")["rmse_deg"]
    assert rmse["narx"] < rmse["pseudo_integrator"]
    assert rmse["narx_smoothed"] < rmse["pseudo_integrator"]
    assert rmse["narx_smoothed"] != rmse["narx"]
    summary = (directory / "summary.md").read_text()
    assert "Table 2" in summary
    assert "lowest RMSE in" in summary
    assert "PI, not causal" in summary
    assert "Parameters chosen on the training part of each fold" in summary
    assert "—" in summary or "–" in summary or "| - |" in summary
    assert summary.startswith(out.partition("\n\nAll tables: ")[0])
    assert (directory / "figures" / "waveforms_knee.png").is_file()
    assert (directory / "figures" / "spectrum.png").is_file()
    assert list((directory / "networks").glob("*.pt"))
    events = EventAccumulator(str(directory / "tensorboard")).Reload()
    assert "rmse_deg/knee_right/sagittal/narx" in events.Tags()["scalars"]
    assert "bland_altman_knee_narx" in events.Tags()["images"]


@pytest.mark.recordings
@pytest.mark.slow
def test_people_left_out_on_real_pocket_walks(run_command, data_root):
    status, _, err, directory = run_command(
        "benchmark", "data=smartphone_pocket", f"data_root={data_root}",
        "split=leave_one_subject_out", "choose=false",
        "methods=[narx,pseudo_integrator,complementary_filter]",
    )  # fmt: skip
    assert status == 0, err
    results = read_results(directory / "results.csv")
    precision = results.pivot_table(
        index=["subject", "trial"], columns=["axis", "method"], values="precision_deg"
    )
    assert len(precision) >= 6
    sagittal, frontal = precision["sagittal"], precision["frontal"]
    assert sagittal["narx"].mean() <= 1.7
    assert frontal["narx"].mean() <= 2.0
    for other in ("pseudo_integrator", "complementary_filter"):
        assert (sagittal["narx"] < sagittal[other]).all()
        assert frontal["narx"].mean() < frontal[other].mean()


@pytest.mark.slow
@pytest.mark.recordings
@pytest.mark.parametrize("source", ["neura_sample", "joint_1to3dof", "broad"])
def test_every_real_source_runs(run_command, data_root, source):
    # every method on the short walk; of the long recordings some, with the methods asked for below
    few = ("choose=false", "methods=[narx,pseudo_integrator,gyro_integration]")
    one = {
        "broad": "select.condition=undisturbed_fast_rotation_A",
        "joint_1to3dof": "select.condition=3D",
    }
    status, _, err, directory = run_command(
        "benchmark",
        f"data={source}",
        f"data_root={data_root}",
        *(() if source == "neura_sample" else few),
        *([one[source]] if source in one else []),
    )
    assert status == 0, err
    results = read_results(directory / "results.csv")
    scored = results[results["n_samples"] > 0]
    assert set(scored["method"]) >= {"narx", "pseudo_integrator", "gyro_integration"}
    if source == "neura_sample":
        kinds = {"thigh", "shank", "knee"}
        assert set(scored["segment"]) == {f"{k}_{s}" for k in kinds for s in ("left", "right")}


@pytest.mark.parametrize(
    ("command", "overrides", "says"),
    [
        ("train", ["optimizer=nonsense"], "adam"),
        ("train", ["modle.hidden=3"], "modle"),
        ("train", ["model.hidden=-2"], "model.hidden is -2"),
        ("train", ["model.washout_s=0"], "model.washout_s is 0, expected a number above 0"),
        ("train", ["data=smartphone_pocket", "data_root=/no/such/folder"], "/no/such/folder"),
        ("train", ["select.subject=Nobody"], "no subject 'Nobody'"),
        ("train", ["split=leave_one_subject_out"], "needs at least two"),
        (
            "train",
            ["objectives=[nonsense]"],
            "objectives.0 is 'nonsense', expected held_back",
        ),
        (
            "predict",
            ["-m", "input=a.csv,b.csv", "output=o.csv"],
            "predict -m: sweeps are not supported",
        ),
        ("benchmark", ["methods=[narx,magic]"], "unknown method 'magic'"),
        ("benchmark", ["checkpoint=/no/such/file.pt"], "/no/such/file.pt"),
        ("benchmark", ["split=leave_one_device_out"], "no column 'device'"),
    ],
)
def test_a_mistake_ends_with_one_line_and_status_2(run_command, command, overrides, says):
    status, out, err, _ = (
        run_command(command, *SMALL[:1], *overrides)
        if overrides[0].startswith(
            ("optimizer", "modle", "model", "select", "split", "methods", "checkpoint")
        )
        else run_command(command, *overrides)
    )
    assert says in one_line_error(status, out, err)


@pytest.mark.recordings
def test_a_recording_cut_off_or_without_a_column_is_named(run_command, data_root, tmp_path):
    folder = tmp_path / "root" / "neura_sample"
    shutil.copytree(data_root / "neura_sample", folder)
    (broken,) = (folder / "rawimu").glob("*B40C3C.txt")
    broken.chmod(0o644)
    content = broken.read_text()
    broken.write_text(content.replace("Gyr_Y", "Gyr_Q"))
    arguments = ("benchmark", "data=neura_sample", f"data_root={tmp_path / 'root'}")
    line = one_line_error(*run_command(*arguments)[:3])
    assert broken.name in line
    assert "Gyr_Y" in line
    broken.write_text(content[: len(content) // 2])
    status, out, err, directory = run_command(*arguments)
    assert broken.name in one_line_error(status, out, err)
    assert not (directory / "results.csv").exists()


def test_results_table_is_plain_csv(tmp_path):
    # what others rely on: a header and numbers that pandas reads without help
    from narx.evaluation.results import COLUMNS, results_table, write_results

    write_results(results_table([]), tmp_path / "results.csv")
    assert list(pd.read_csv(tmp_path / "results.csv").columns) == list(COLUMNS)


def test_a_study_without_reference_is_refused_before_training(run_command, tmp_path, monkeypatch):
    for name in ("anna", "bert"):
        sensor = ImuRecording("imu", np.arange(500) / 50.0, np.zeros((500, 3)), np.ones((500, 3)))
        write_recording(tmp_path / "data" / f"{name}.csv", sensor)
    (tmp_path / "data" / "study.yaml").write_text('files: "{subject}.csv"\n')
    monkeypatch.setattr(benchmark, "network_of", lambda *_: pytest.fail("trained"))
    status, _, err, _ = run_command("benchmark", "data=study", f"data_root={tmp_path / 'data'}")
    assert status == 2
    assert err == (
        "error: data=study: nothing to score, no trial has a reference; use narx-predict to "
        "compute angles only\n"
    )


def test_a_benchmark_without_any_reference_is_refused(run_command, tmp_path):
    stem = tmp_path / "data" / "motion_bids" / "sub-1" / "motion" / "sub-1_task-walk_tracksys-imu"
    stem.parent.mkdir(parents=True)
    rows = [
        f"{kind}{c}\t{c}\t{kind}\tthigh_right\t{unit}"
        for kind, unit in (("GYRO", "rad/s"), ("ACCEL", "g"))
        for c in "xyz"
    ]
    header = "name\tcomponent\ttype\ttracked_point\tunits"
    Path(f"{stem}_channels.tsv").write_text("\n".join([header, *rows]) + "\n")
    Path(f"{stem}_motion.json").write_text('{"SamplingFrequency": 50}')
    phase = 2 * np.pi * 0.9 * np.arange(1500) / 50.0
    swing = -0.4 * np.sin(phase + 0.35 * np.sin(phase))
    rate = np.gradient(swing) * 50.0
    still = np.zeros(1500)
    values = np.column_stack([still, rate, still, -np.sin(swing), still, np.cos(swing)])
    np.savetxt(f"{stem}_motion.tsv", values, delimiter="\t", fmt="%.6f")
    status, _, err, directory = run_command(
        "benchmark", "data=motion_bids", f"data_root={tmp_path / 'data'}", "split=pretrained",
        "methods=[narx]",
    )  # fmt: skip
    assert status == 2
    assert "nothing to score, no trial has a reference" in err
    assert len(err.strip().splitlines()) == 1
    assert not (directory / "results.csv").exists()


def test_a_start_that_is_longer_than_the_trials_is_named(run_command):
    status, _, err, _ = run_command(
        "benchmark", "debug=tiny", "methods=[zero]", "evaluation.skip_s=1000",
        "data.simulated_gait.segments=[thigh_right]",
    )  # fmt: skip
    assert status == 2
    assert "error: evaluation.skip_s is 1000: nothing is left to score" in err
