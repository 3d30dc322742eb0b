"""The three papers as commands: their tables, their figures, and what they refuse."""

import numpy as np
import pytest
from hydra import compose, initialize_config_module

from narx.evaluation.results import read_results

AXES = ("sagittal", "frontal", "transverse")


def rmse(results, segment, axis):
    here = results[(results["segment"] == segment) & (results["axis"] == axis)]
    return here.groupby("method")["rmse_deg"].mean()


def refusal(status, out, err):
    assert status == 2
    lines = [line for line in err.splitlines() if line.strip()]
    assert len(lines) == 1
    assert lines[0].startswith("error: ")
    return lines[0]


def test_han_on_simulated_walks(run_command):
    status, out, err, directory = run_command(
        "benchmark", "experiment=han_two_point", "walks.subjects=[V1,V2,V3]",
        "walks.trials_per_condition=1",
    )  # fmt: skip
    assert status == 0, err
    results = read_results(directory / "results.csv")
    assert set(results["segment"]) == {"thigh_right", "shank_right"}
    assert set(results["condition"]) == {"normal", "abnormal"}
    for segment in ("thigh_right", "shank_right"):
        for axis in AXES:
            found = rmse(results, segment, axis)
            assert found["two_point"] < found["gyro_integration"]
    # three to five steps at 100 Hz: the standing around them is not scored
    assert results["n_samples"].between(50, 500).all()
    for said in (
        "Table I.",
        "Table II.",
        "Where and why",
        "in 6 of 6 columns",
        "not removed, as in the paper",
    ):
        assert said in (directory / "summary.md").read_text()
    assert "Table I." not in out
    assert {path.name for path in (directory / "figures").glob("*.png")} == {
        "figure_6_waveforms_normal.png",
        "figure_7_waveforms_abnormal.png",
        "figure_8_error_and_drift.png",
    }


@pytest.mark.recordings
def test_han_on_the_walk_before_the_turn(run_command, data_root):
    status, _, err, directory = run_command(
        "benchmark", "experiment=han_two_point", "data=neura_sample", f"data_root={data_root}"
    )
    assert status == 0, err
    assert "turns 14.7 s after its start" in (directory / "summary.md").read_text()
    results = read_results(directory / "results.csv")
    # about 3.5 s between the first step and the turn
    scored = results[results["axis"] == "sagittal"]["n_samples"]
    assert scored.between(300, 420).all()
    assert (results[results["axis"] == "transverse"]["n_samples"] == 0).all()


@pytest.mark.recordings
@pytest.mark.parametrize(
    ("experiment", "source", "says"),
    [
        ("han_two_point", "smartphone_pocket", "no still part"),
        ("tham_knee_angle", "smartphone_pocket", "no knee among thigh"),
    ],
)
def test_unsuitable_trials_are_refused_with_the_reason(
    run_command, data_root, experiment, source, says
):
    answer = run_command(
        "benchmark", f"experiment={experiment}", f"data={source}", f"data_root={data_root}",
        "methods=[two_point,gyro_integration]",
    )  # fmt: skip
    assert says in refusal(*answer[:3])
    assert not (answer[3] / "results.csv").exists()


@pytest.mark.parametrize(
    ("experiment", "segment", "says"),
    [
        ("abhayasinghe_thigh_angle", "shank_right", "expected a thigh"),
        ("han_two_point", "pelvis", "expected a thigh or shank"),
        ("tham_knee_angle", "thigh_left", "no knee among thigh_left"),
    ],
)
def test_another_segment_is_refused(run_command, experiment, segment, says):
    status, out, err, _ = run_command(
        "benchmark", f"experiment={experiment}", f"data.simulated_gait.segments=[{segment}]",
        "data.simulated_gait.subjects=[S1]", "data.simulated_gait.trials_per_condition=1",
        "data.simulated_gait.treadmill_duration_s=60", "methods=[gyro_integration]",
        "data.simulated_gait.conditions=[normal]",
    )  # fmt: skip
    assert says in refusal(status, out, err)


def test_abhayasinghe_on_simulated_walks(run_command):
    status, out, err, directory = run_command(
        "benchmark", "experiment=abhayasinghe_thigh_angle", "walks.subjects=[V1,V2,V11]",
        "walks.trials_per_condition=3",
    )  # fmt: skip
    assert status == 0, err
    summary = (directory / "summary.md").read_text()
    assert summary.startswith(out.partition("\n\nAll tables: ")[0])
    rows = {
        line.split("|")[1].strip(): [cell.strip() for cell in line.split("|")[2:]]
        for line in summary.splitlines()
        if line.startswith("|")
    }
    assert rows["Males"][:2] == ["2", "6"]
    assert rows["Females"][:2] == ["1", "3"]
    assert float(rows["All"][2]) > 0.98
    # the accelerometer is asked at every sample by one, at rest by the other
    kinds = next(
        cells for name, cells in rows.items() if name == "Method" and "arctangents" in cells
    )
    arctangent = kinds.index("arctangents")
    assert float(rows["CF"][arctangent]) == 1.0
    assert float(rows["GIOF"][arctangent]) < 0.2
    for table in ("Table 1.", "Table 2.", "Table 3.", "Where and why"):
        assert table in summary
    assert {path.name for path in (directory / "figures").glob("*.png")} == {
        "figure_7_thigh_angle.png",
        "figure_8_peak_errors.png",
        "figure_9_correlation_and_rmse.png",
        "figure_10_real_time.png",
        "figure_11_phases.png",
    }


@pytest.mark.recordings
@pytest.mark.parametrize(("source", "trials"), [("smartphone_pocket", 6), ("neura_sample", 2)])
def test_abhayasinghe_on_real_walks(run_command, data_root, source, trials):
    status, _, err, directory = run_command(
        "benchmark", "experiment=abhayasinghe_thigh_angle", f"data={source}",
        f"data_root={data_root}", "methods=[giof,complementary_filter]",
    )  # fmt: skip
    assert status == 0, err
    results = read_results(directory / "results.csv")
    offline = results[(results["method"] == "giof") & (results["axis"] == "sagittal")]
    assert len(offline) == trials
    assert (offline["r"] > 0.85).all()


@pytest.mark.slow
def test_tham_without_the_network(run_command):
    status, _, err, directory = run_command(
        "benchmark", "experiment=tham_knee_angle", "data.simulated_gait.subjects=[S1,S2]",
        "data.simulated_gait.treadmill_duration_s=60", "data.simulated_gait.sampling_rate_hz=100",
        "methods=[pseudo_integrator,complementary_filter]",
    )  # fmt: skip
    assert status == 0, err
    summary = (directory / "summary.md").read_text()
    for said in ("Table 1.", "Table 2.", "Table 3.", "Table 4.", "Gait cycles", "Fig. 3"):
        assert said in summary
    assert "| S1      | F      |        28.0 |       1.62 |      48.0 |" in summary
    results = read_results(directory / "results.csv")
    unseen = results[
        (results["axis"] == "transverse") & (results["method"] == "complementary_filter")
    ]
    assert (unseen["n_samples"] == 0).all()
    figures = {path.name for path in (directory / "figures").glob("*.png")}
    assert {"figure_3_spectrum.png", "figure_6_knee_angle.png"} <= figures
    assert "figure_7_bland_altman_pseudo_integrator.png" in figures


@pytest.mark.parametrize(
    ("overrides", "subjects", "rate_hz"),
    [
        ([], ["S1", "S2", "S3", "S4", "S5"], 500.0),
        (["experiment=han_two_point"], [f"V{k}" for k in range(1, 11)], 100.0),
        (["experiment=han_two_point", "data=[simulated_gait,broad]", "walks.subjects=[V3]"],
         ["V3"], 100.0),
        (["experiment=han_two_point", "data.simulated_gait.subjects=[V7]"], ["V7"], 100.0),
    ],
)  # fmt: skip
def test_an_experiment_sets_its_own_walks(overrides, subjects, rate_hz):
    with initialize_config_module(version_base="1.3", config_module="narx.configs"):
        cfg = compose("benchmark", overrides=overrides)
    assert list(cfg.data.simulated_gait.subjects) == subjects
    assert cfg.data.simulated_gait.sampling_rate_hz == rate_hz


def test_published_alpha_gives_the_configured_crossover():
    from narx.baselines.complementary_filter import ComplementaryFilter

    with initialize_config_module(version_base="1.3", config_module="narx.configs"):
        cfg = compose("benchmark", overrides=["experiment=abhayasinghe_thigh_angle"])
    for name, alpha in (
        ("complementary_filter", 0.9999),
        ("complementary_filter_real_time", 0.999),
    ):
        method = ComplementaryFilter(crossover_hz=cfg.method[name].crossover_hz)
        np.testing.assert_allclose(1.0 - method.alpha(100.0), 1.0 - alpha, rtol=1e-3)
