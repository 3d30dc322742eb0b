"""The table over a sweep's runs, checked by hand; a report that needs no network."""

import json
import re
import shutil
import sys

import numpy as np
import pandas as pd
import pytest
from omegaconf import OmegaConf

from narx.errors import UserError

pytest.importorskip("plotly")
pytest.importorskip("pyarrow")

from narx.evaluation.results import COLUMNS, NAMES, results_table, write_results
from narx.evaluation.significance import paired_test
from narx.experiments.compare.__main__ import compare, main
from narx.experiments.compare.distinct import distinct_runs
from narx.experiments.compare.pairing import compare_pair
from narx.experiments.compare.report import angle_figures, readable, settings_figure
from narx.experiments.compare.runs import find_runs

# held-out error by hidden neurons and seed
ERRORS = {2: [1.5, 1.7, 1.9], 3: [1.0, 1.1, 1.5]}


def make_run(folder, hidden, seed, error, state="finished", fold=None):
    (folder / ".hydra").mkdir(parents=True)
    settings = {
        "seed": seed, "data_root": "/anywhere", "model": {"hidden": hidden, "odd": True},
        "training": {"seed": seed}, "data": {"seed": 7},
    }  # fmt: skip
    OmegaConf.save(OmegaConf.create(settings), folder / ".hydra" / "config.yaml")
    overrides = [f"seed={seed}", f"model.hidden={hidden}", "+note='two words'", "data_root=/x"]
    OmegaConf.save(OmegaConf.create(overrides), folder / ".hydra" / "overrides.yaml")
    (folder / "run.json").write_text(json.dumps({"identity": str(folder), "state": state}))
    (folder / "metrics.json").write_text(
        json.dumps(
            {"held_back_error_deg": error, "rmse_deg/knee_right/sagittal/narx": 2 * (error or 0)}
        )
    )
    history = [{"cost_deg2": 3.0}, {"cost_deg2": error}]
    training = {"fold": fold or f"S{seed}", "report": {"history": history}}
    (folder / "training.json").write_text(json.dumps(training))
    time_s = np.arange(0, 2, 0.1)
    angles = pd.concat(
        pd.DataFrame(
            {
                "trial": "t", "segment": "knee_right", "axis": axis, "method": "narx",
                "time_s": time_s, "reference_deg": np.sin(time_s), "estimate_deg": 0.0,
            }
        )
        for axis in ("sagittal", "frontal", "transverse")
    )  # fmt: skip
    angles.to_csv(folder / "angles.csv", index=False)


@pytest.fixture
def sweep(tmp_path):
    for hidden, errors in ERRORS.items():
        for seed, error in enumerate(errors):
            make_run(tmp_path / f"model.hidden={hidden},seed={seed}", hidden, seed, error)
    make_run(tmp_path / "cut", 4, 0, 0.1, state="interrupted")
    return tmp_path


@pytest.mark.parametrize(
    ("values", "written"),
    [
        ([3, "auto"], {"3", "auto"}),
        ([1, True, 0.5, None], {"1", "true", "0.5", None}),
        ([1, 0.5, None], {1.0, 0.5, None}),
        ([True, False], {True, False}),
    ],
)
def test_a_setting_of_several_kinds_is_text(tmp_path, values, written):
    for k, value in enumerate(values):
        make_run(tmp_path / f"{k}", value, 0, 1.0 + k)
    compare([tmp_path], None, None, None)
    table = pd.read_parquet(tmp_path / "runs.parquet")
    assert table["rank"].tolist() == [1 + k for k in range(len(values))]
    found = table["model.hidden"].astype(object)
    assert set(found.where(found.notna(), None)) == written


def test_configurations_are_ranked_by_their_mean_over_seeds(sweep):
    said = compare([sweep], None, None, None)
    table = pd.read_csv(sweep / "runs.csv")
    assert len(table) == 6
    assert list(table["rank"]) == [1, 1, 1, 2, 2, 2]
    best = table[table["model.hidden"] == 3].iloc[0]
    assert best["mean"] == pytest.approx(1.2)
    assert best["sd"] == pytest.approx(np.std([1.0, 1.1, 1.5], ddof=1))
    assert best["n"] == 3
    assert "model.odd" not in table  # the same everywhere
    assert "data_root" not in table
    assert "training.seed" not in table  # always equal to seed
    assert list(table["data.seed"]) == [7] * 6
    pd.testing.assert_frame_equal(pd.read_parquet(sweep / "runs.parquet"), table, check_dtype=False)
    assert "best: narx-train model.hidden=3 '+note='\"'\"'two words'\"'\"''" in said
    assert "unfinished runs left out: 1" in said
    assert "on the same 3 seeds: -0.500, too few seeds for an interval; p 0.25" in said


def test_the_best_seed_does_not_rank_a_configuration(tmp_path):
    for hidden, errors in {2: [1.0, 5.0], 3: [2.0, 2.1]}.items():
        for seed, error in enumerate(errors):
            make_run(tmp_path / f"{hidden}{seed}", hidden, seed, error)
    compare([tmp_path], None, None, None)
    table = pd.read_csv(tmp_path / "runs.csv")
    assert table["model.hidden"].tolist() == [3, 3, 2, 2]


def test_small_settings_are_not_printed_as_zero(tmp_path):
    for size in (1e-12, 0.0125):
        make_run(tmp_path / f"{size}", size, 0, size)
    cells = [line.split() for line in compare([tmp_path], None, None, None).splitlines()]
    printed = [line[-2] for line in cells if line[:2] in (["|", "1"], ["|", "2"])]
    assert printed == ["1e-12", "0.0125"]


def test_two_configurations_are_compared_on_the_same_seeds_and_folds(sweep):
    said = compare([sweep], None, (1, 2), None)
    # 1.0-1.5, 1.1-1.7, 1.5-1.9
    assert "held_back_error_deg on the same 3 seeds: -0.500" in said
    assert "cannot give less than 0.25" in said
    make_run(sweep / "other_fold", 3, 7, 1.0, fold="A")
    make_run(sweep / "other_fold_2", 2, 7, 9.0, fold="B")
    assert "on the same 3 seeds: -0.500" in compare([sweep], None, (1, 2), None)


def _results(rng, more):
    """Three trials of five people, of the network and of another method that is much worse."""
    names = dict.fromkeys(NAMES, "x")
    return results_table(
        dict.fromkeys(COLUMNS, 0)
        | names
        | {"subject": person, "trial": trial, "axis": "sagittal", "method": method, "n_samples": 9}
        | {"rmse_deg": rng.uniform(1.0, 2.0) + more + 50.0 * (method != "narx")}
        for person in ("P1", "P2", "P3", "P4", "P5")
        for trial in "123"
        for method in ("narx", "vqf")
    )


def test_without_folds_the_networks_errors_of_a_person_are_a_pair(tmp_path):
    rng, means = np.random.default_rng(0), []
    for run, more in (("a", 0.0), ("b", 0.4)):
        results = _results(rng, more)
        (tmp_path / run).mkdir()
        write_results(results, tmp_path / run / "results.csv")
        network = results[results["method"] == "narx"]
        means.append(network.groupby("subject")["rmse_deg"].mean().to_numpy())
    table = pd.DataFrame({"rank": [1, 2], "run": ["a", "b"], "fold": "", "rmse_deg": [1.0, 2.0]})
    folders = {run: tmp_path / run for run in "ab"}
    pairing = compare_pair(table, folders, "rmse_deg", 1, 2)
    assert (pairing.unit, pairing.test.n) == ("person", 5)
    expected = paired_test(*means)
    assert pairing.test.difference == pytest.approx(expected.difference)
    assert pairing.test.p_permutation == expected.p_permutation
    assert pairing.test.difference < -0.1


def test_the_error_of_a_benchmark_is_the_mean_over_segments_and_axes(tmp_path):
    make_run(tmp_path / "a", 3, 0, 1.0)
    metrics = {"rmse_deg/knee/sagittal/narx": 1.0, "rmse_deg/knee/frontal/narx": 3.0,
               "rmse_deg/thigh/frontal/narx": 8.0, "rmse_deg/knee/frontal/vqf": 99.0}  # fmt: skip
    (tmp_path / "a" / "metrics.json").write_text(json.dumps(metrics))
    (run,), _ = find_runs([tmp_path])
    assert run.metrics["rmse_deg"] == pytest.approx(4.0)


@pytest.mark.parametrize(("relative", "same"), [(1e-7, True), (1e-5, False)])
def test_results_of_one_run_differ_by_rounding_at_most(tmp_path, relative, same):
    for name, error in (("a", 1.0), ("b", 1.0 + relative)):
        make_run(tmp_path / name, 3, 0, error)
    runs, _ = find_runs([tmp_path])
    if same:
        assert len(distinct_runs(runs)) == 1
    else:
        with pytest.raises(UserError, match="the same configuration and seed"):
            distinct_runs(runs)


def test_the_differences_have_their_mean_and_limits(tmp_path):
    make_run(tmp_path / "a", 3, 0, 1.0)
    error = np.sin(np.arange(0, 2, 0.1))
    *_, differences = angle_figures(tmp_path / "a").values()
    for k in range(3):
        np.testing.assert_allclose(differences.data[k].x, error / 2)
        np.testing.assert_allclose(differences.data[k].y, error)
    lines = sorted(shape.y0 for shape in differences.layout.shapes)
    spread = 1.96 * error.std(ddof=1)
    expected = np.repeat([error.mean() - spread, error.mean(), error.mean() + spread], 3)
    np.testing.assert_allclose(lines, expected)


def test_another_metric(sweep):
    compare([sweep], "rmse_deg", None, sweep / "out")
    assert pd.read_csv(sweep / "out" / "runs.csv")["mean"].iloc[0] == pytest.approx(2.4)


def test_the_report_is_one_file_that_needs_no_network(sweep):
    compare([sweep], None, None, None)
    text = (sweep / "comparison.html").read_text()
    for wanted in ("Settings against the error", "Learning curves", "limits of agreement"):
        assert wanted in text
    tags = re.findall(r"<(?:script|link|img)\b[^>]*\b(?:src|href)=\"(http[^\"]+)", text)
    assert tags == []


def test_the_same_results_give_the_same_table(sweep, tmp_path_factory):
    compare([sweep], None, None, None)
    again = tmp_path_factory.mktemp("again")
    for hidden, errors in reversed(ERRORS.items()):
        for seed, error in enumerate(errors):
            make_run(again / f"model.hidden={hidden},seed={seed}", hidden, seed, error)
    compare([again], None, None, None)
    assert (again / "runs.csv").read_bytes() == (sweep / "runs.csv").read_bytes()
    assert (again / "runs.parquet").read_bytes() == (sweep / "runs.parquet").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["/no/such/folder"], "/no/such/folder: no such folder, expected a folder of a sweep"),
        (["{sweep}/cut/run.json"], "run.json: a file, expected a folder of a sweep or of runs"),
        (["{empty}"], "no finished run of narx-train or narx-benchmark"),
        (["{sweep}", "--metric", "beauty"], "--metric: not all runs have beauty"),
        (["{sweep}", "--pair", "1", "9"], "--pair 1 9: expected the ranks of two configurations"),
        (["{sweep}", "--pair", "1", "1"], "--pair 1 1: expected the ranks of two configurations"),
        (["{one}", "--pair", "1", "2"], "--pair 1 2: there is only one configuration"),
        (["{sweep}", "--output", "/dev/null/x"], "/dev/null/x: Not a directory"),
    ],
)
def test_a_mistake_is_one_line(sweep, tmp_path_factory, monkeypatch, capsys, arguments, says):
    empty, one = tmp_path_factory.mktemp("empty"), sweep / "model.hidden=2,seed=0"
    words = [word.format(sweep=sweep, empty=empty, one=one) for word in arguments]
    monkeypatch.setattr(sys, "argv", ["narx-compare", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert says in line


def test_ctrl_c_is_one_line(sweep, monkeypatch, capsys):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("narx.experiments.compare.__main__.find_runs", stopped)
    monkeypatch.setattr(sys, "argv", ["narx-compare", str(sweep)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 130
    assert capsys.readouterr().err == "interrupted: repeat the command to start again\n"


def test_means_over_different_numbers_of_runs_are_named(sweep):
    make_run(sweep / "model.hidden=3,seed=3", 3, 3, 1.2)
    assert "configurations have 3 to 4 runs" in compare([sweep], None, None, None)


@pytest.mark.parametrize(("other", "said"), [("f00", True), ("abc", False)])
def test_runs_on_different_recordings_are_named(sweep, other, said):
    for number, folder in enumerate(sorted(sweep.glob("model.hidden=*"))):
        record = json.loads((folder / "run.json").read_text())
        record["data_sha256"] = {"own": other if number else "abc"}
        (folder / "run.json").write_text(json.dumps(record))
    text = compare([sweep], None, None, None)
    assert ("the runs used 2 different sets of recordings" in text) == said
    report = (sweep / "comparison.html").read_text(encoding="utf-8")
    assert ("the runs used 2 different sets of recordings" in report) == said


def test_parts_are_named_and_settings_that_a_run_lacks_are_drawn():
    table = pd.DataFrame(
        {
            "run": ["a", "b", "c"],
            "rank": [1, 2, 3],
            "rmse_deg": [1.0, 2.0, 3.0],
            "optimizer._target_": ["narx.training.lbfgs.LBFGS", "narx.training.adam.Adam", None],
            "optimizer.step": [0.5, np.nan, 0.25],
        }
    )
    shown = readable(table)
    assert list(shown["optimizer"]) == ["LBFGS", "Adam", "–"]
    assert table["optimizer._target_"][0] == "narx.training.lbfgs.LBFGS"
    keys = ["optimizer._target_", "optimizer.step"]
    part, step, error = settings_figure(table, "rmse_deg", keys).data[0].dimensions
    assert (part.label, error.label) == ("optimizer", "rmse_deg")
    assert [part.ticktext[i] for i in part["values"]] == ["LBFGS", "Adam", "–"]
    assert list(step.ticktext) == ["–", "0.25", "0.5"]
    np.testing.assert_array_equal(step["values"], [2, 0, 1])


DAMAGED = {"empty": b"", "binary": bytes(range(256)), "zeros": bytes(99), "a list": b"[1, 2]",
           "other keys": b'{"a": "x"}', "cut": b'{"held_back_error_deg": 1.0, '}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGED)
@pytest.mark.parametrize(
    "name", ["run.json", "metrics.json", "training.json", ".hydra/config.yaml", ".hydra/hydra.yaml"]
)
def test_a_damaged_run_is_named(sweep, name, damage):
    if (name, damage) == (".hydra/config.yaml", "other keys"):
        pytest.skip("any key may be a setting")
    (sweep / "model.hidden=2,seed=0" / name).write_bytes(DAMAGED[damage])
    with pytest.raises(
        UserError, match=r"model\.hidden=2,seed=0.*: not the (folder of a finished|record of a) run"
    ):
        compare([sweep], None, None, None)


@pytest.mark.parametrize("damage", sorted(DAMAGED))
def test_damaged_angles_are_named_and_nothing_is_written(sweep, damage):
    (sweep / "model.hidden=3,seed=0" / "angles.csv").write_bytes(DAMAGED[damage])
    with pytest.raises(UserError, match=r"angles\.csv: not the angles of a run"):
        compare([sweep], None, None, None)
    assert not list(sweep.glob("runs.*"))


@pytest.fixture
def copied(sweep, tmp_path_factory):
    folder = tmp_path_factory.mktemp("copied") / "sweep"
    shutil.copytree(sweep, folder)
    return folder


def test_the_same_run_in_two_folders_counts_once(sweep, copied):
    once = compare([sweep], None, None, None)
    alone = pd.read_csv(sweep / "runs.csv")
    make_run(copied / "model.hidden=3,seed=3", 3, 3, 1.2)
    make_run(sweep / "of_another_sweep", 3, 3, 1.2 + 1e-9)  # rounded on another processor
    twice = compare([sweep, copied], None, None, None)
    table = pd.read_csv(sweep / "runs.csv")
    assert len(table) == len(alone) + 1
    assert list(table.groupby("rank")["n"].first()) == [4, 3]
    assert "repeated runs left out: 7 (" in twice
    assert "on the same 3 seeds: -0.500" in twice
    assert "repeated" not in once
    one = compare([sweep / "model.hidden=2,seed=0", copied / "model.hidden=2,seed=0"], *[None] * 3)
    assert "repeated runs left out: 1 (" in one
    assert list(pd.read_csv(sweep / "model.hidden=2,seed=0" / "runs.csv")["n"]) == [1]


def test_a_folder_given_twice_has_no_repetitions(sweep):
    (sweep / "link").symlink_to(sweep / "model.hidden=2,seed=0")
    said = compare([sweep, sweep / ".." / sweep.name, sweep / "link"], None, None, None)
    assert "repeated" not in said
    assert len(pd.read_csv(sweep / "runs.csv")) == 6


@pytest.mark.parametrize(
    ("record", "cause"),
    [
        ({}, ", but"),
        ({"code": "1"}, " with different versions of the code, but"),
        ({"code": "1", "data_sha256": {"a": "b"}}, " on different data, but"),
    ],
)
def test_two_results_of_the_same_run_are_refused(sweep, copied, record, cause):
    other = copied / "model.hidden=3,seed=1"
    shutil.rmtree(other)
    make_run(other, 3, 1, 1.2)
    (other / "run.json").write_text(json.dumps({"identity": "", "state": "finished", **record}))
    with pytest.raises(UserError) as refused:
        compare([sweep, copied], None, None, None)
    assert str(refused.value) == (
        f"{sweep / other.name} and {other}: the same configuration and seed{cause} "
        "held_back_error_deg is 1.1 and 1.2; expected only one of them"
    )


def test_the_best_line_names_the_command_of_the_run(tmp_path):
    make_run(tmp_path / "run", 3, 0, 1.0)
    (tmp_path / "run" / ".hydra" / "hydra.yaml").write_text("hydra: {job: {name: benchmark}}")
    assert "best: narx-benchmark model.hidden=3 " in compare([tmp_path], None, None, None)


def test_folders_of_one_name_are_distinguished(tmp_path):
    make_run(tmp_path / "wide" / "run", 3, 0, 1.0)
    make_run(tmp_path / "narrow" / "run", 2, 0, 0.5)
    said = compare([tmp_path / "wide", tmp_path / "narrow"], None, None, tmp_path)
    assert "best: narx-train model.hidden=2 " in said
    runs = pd.read_csv(tmp_path / "runs.csv")["run"]
    assert list(runs) == [str(tmp_path / name / "run") for name in ("narrow", "wide")]


def test_a_configuration_without_a_result_is_last(sweep):
    make_run(sweep / "model.hidden=5,seed=0", 5, 0, None)
    compare([sweep], "held_back_error_deg", None, None)
    table = pd.read_csv(sweep / "runs.csv")
    assert list(table["model.hidden"].unique()) == [3, 2, 5]
