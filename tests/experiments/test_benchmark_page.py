"""The benchmark's page, and README's table and sentences, are what the kept results give."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hydra import compose, initialize_config_module

from narx.errors import UserError
from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.experiments.benchmark_page import BEGIN, END, kept_sources, pages, with_part
from narx.experiments.configuration import checked_configuration
from narx.experiments.tables.glance import at_a_glance, in_words
from narx.experiments.tables.page import (
    Source,
    against_network,
    by_motion,
    subject_condition_means,
)

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def cfg():
    with initialize_config_module("narx.configs", version_base="1.3"):
        return checked_configuration(compose("benchmark_page"), "benchmark_page")


def test_page_and_readme_are_made_from_the_kept_results(cfg):
    for path, text in pages(cfg, ROOT).items():
        assert path.read_text() == text, path.name
    kept = kept_sources(cfg, ROOT / "docs")
    for source in kept.values():
        for figure in source.figures:
            assert (ROOT / "docs" / "figures" / figure).is_file()
    page = (ROOT / "docs" / "benchmark.md").read_text()
    for name, shown in cfg.sources.items():
        assert (f"## {shown.title}" in page) == (name in kept)
        assert shown.title in page


def test_numbers_in_the_readmes_sentences_are_in_the_tables():
    """Every number with a decimal in the prose about the table stands in the table or the page."""
    readme = (ROOT / "README.md").read_text()
    section = readme.split("## What comes out")[1].split("\n## ")[0]
    prose = re.sub(re.escape(BEGIN) + ".*?" + re.escape(END), "", section, flags=re.DOTALL)
    shown = section.replace(prose, "") + (ROOT / "docs" / "benchmark.md").read_text()
    numbers = set(re.findall(r"(?<![\w.])\d+\.\d+(?![\w.]*\d)", prose))
    missing = {number for number in numbers if not re.search(rf"(?<![\d.]){number}(?!\d)", shown)}
    assert not missing


@pytest.fixture
def source(make_study):
    results = results_table(row for one in make_study() for row in rows(one))
    means = subject_condition_means(results)
    return Source("Study", "command", "knee", "rmse_deg", means, ("pseudo_integrator",), "made")


def test_means_are_over_sides_then_subjects(source, make_study):
    errors = []
    for one in make_study():
        if one.segment.startswith("knee") and one.condition == "slow":
            squares = one.error_deg("narx")[:, 0] ** 2
            errors.append((one.subject, np.sqrt(np.nanmean(squares))))
    expected = pd.DataFrame(errors).groupby(0)[1].mean().mean()
    frame = by_motion(source, "same ingredients").frame
    assert frame.loc[("sagittal", "NARX"), "slow"] == pytest.approx(expected, rel=1e-9)
    assert list(frame.columns) == ["slow", "normal", "fast", "mean", "lag (ms)"]


def test_an_axis_that_is_not_observed_has_no_row(source):
    frame = by_motion(source, "as printed").frame
    assert ("transverse", "CF") not in frame.index
    assert ("sagittal", "PI, not causal") in frame.index


def test_the_table_goes_between_the_marks(source):
    table = at_a_glance({"study": source}, ["narx", "zero"])
    page = with_part(f"before\n{BEGIN}\nold\n{END}\nafter\n", table)
    assert page.startswith(f"before\n{BEGIN}\n|")
    assert page.endswith(f"|\n{END}\nafter\n")
    assert "old" not in page
    assert with_part(page, table) == page
    with pytest.raises(UserError, match="expected the markers"):
        with_part("no marks", table)


def test_differences_from_the_network_are_over_subjects(make_study):
    names = tuple(f"S{k}" for k in range(7))
    study = make_study(subjects=names, conditions=("normal",))
    results = results_table(row for one in study for row in rows(one))
    source = Source("S", "c", "knee", "rmse_deg", subject_condition_means(results), (), "m")
    table = against_network(source)
    means = source.means[(source.means["segment"] == "knee") & (source.means["axis"] == "frontal")]
    by = means.pivot(index="subject", columns="method", values="rmse_deg")
    difference = (by["pseudo_integrator"] - by["narx"]).mean()
    row = table.frame.loc[("frontal", "as printed", "PI")]
    assert row["less NARX"] == pytest.approx(difference)
    better = int((by["pseudo_integrator"] < by["narx"]).sum())
    assert row["better than NARX"] == f"{better} of 7"
    for n_subjects, tested in ((5, False), (6, True)):
        few = source.means[source.means["subject"] < f"S{n_subjects}"]
        table = against_network(Source("S", "c", "knee", "rmse_deg", few, (), ""))
        assert (table is not None) == tested


def test_a_mean_is_over_motions_not_over_people(make_study):
    """Of a motion with one person and one with three, both count alike."""
    results = results_table(row for one in make_study() for row in rows(one))
    results = results[(results["condition"] == "slow") | (results["subject"] == "S1")]
    results.loc[results["condition"] == "slow", "rmse_deg"] += 2.0
    means = subject_condition_means(results)
    source = Source("S", "c", "knee", "rmse_deg", means, (), "m")
    row = by_motion(source, "same ingredients").frame.loc[("sagittal", "NARX")]
    assert row["mean"] == pytest.approx(row[["slow", "normal", "fast"]].mean())


def test_a_person_has_the_mean_of_trials_and_sides_that_were_scored(make_study):
    results = results_table(row for one in make_study() for row in rows(one))
    one = results[results["segment"] == "knee_right"].iloc[[0]]
    keys = ["subject", "condition", "axis", "method"]
    same = (results[keys] == one[keys].iloc[0]).all(axis=1)
    same &= results["segment"].str.startswith("knee")
    more = one.assign(trial="2", rmse_deg=9.0), one.assign(trial="3", rmse_deg=99.0, n_samples=0)
    means = subject_condition_means(pd.concat([results, *more], ignore_index=True))
    found = means[(means[keys] == one[keys].iloc[0]).all(axis=1) & (means["segment"] == "knee")]
    scored = [*results.loc[same, "rmse_deg"], 9.0]
    assert found["rmse_deg"].item() == pytest.approx(np.mean(scored))
    assert found["n_trials"].item() == len(scored) == 3


def test_words_have_the_numbers_of_the_table(source):
    assert in_words({"study": source}, {"study": "study,"}, None) == ""  # without its rows
    renamed = source.means.replace(
        {"method": {"complementary_filter": "vqf_same_chosen", "pseudo_integrator": "constant"}}
    )
    words = in_words({"study": replace(source, means=renamed)}, {"study": "study,"}, None)
    table = by_motion(source, "as printed").frame["mean"]
    narx = by_motion(source, "same ingredients").frame["mean"]
    cf, own = table["sagittal", "CF"], narx["sagittal", "NARX"]
    assert f"chosen, and NARX without one: study, sagittal {cf:.2f} and {own:.2f}, frontal" in words
    assert len(words.splitlines()) == 2
    draws = pd.DataFrame({"variant": "as printed", "knee_sagittal_deg": [1.0, 2.0, 3.0, 4.0, 5.0]})
    words = in_words({}, {}, draws)
    assert words.endswith("over 5 draws: median 3.0°, quartiles 2.0 and 4.0.")


@pytest.mark.slow
def test_the_command_measures_and_writes_page_readme_and_figures(run_command, tmp_path):
    readme = tmp_path / "README.md"
    readme.write_text(f"before\n{BEGIN}\n{END}\nafter\n")
    overrides = [
        "data.simulated_gait.subjects=[S1]", "data.simulated_gait.conditions=[normal]",
        "data.simulated_gait.treadmill_duration_s=60", "data.simulated_gait.sampling_rate_hz=50",
        "split=one_window", "split.latest_s=25", "optimizer.restarts=1", "optimizer.iterations=5",
        "methods=[narx,leaky_integrator]",
    ]  # fmt: skip
    listed = ",".join(f"'{override}'" for override in overrides)
    status, out, err, _ = run_command(
        "benchmark_page", f"root={tmp_path}", "only=[drawn30]",
        f"sources.drawn30.overrides=[{listed}]",
    )  # fmt: skip
    assert status == 0, err
    page = (tmp_path / "docs" / "benchmark.md").read_text()
    assert "## Thirty drawn walkers" in page
    assert "| Leaky integrator, tracker, chosen" in page
    assert "No results are kept yet of: Phones in front pockets" in page
    assert "**The network** in the integrator's place changes that" in readme.read_text()
    assert (tmp_path / "docs" / "figures" / "benchmark_drawn30_strides_knee.png").is_file()
    assert str(readme) in out
