import numpy as np
import pytest

from narx.errors import UserError
from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.experiments.published import published
from narx.experiments.tables.tham import (
    comparison_with_published,
    demographics_table,
    interval_table,
    tham_tables,
)


@pytest.fixture
def results(make_study):
    return results_table(row for e in make_study() for row in rows(e))


def test_rows_and_columns_thighs_and_shanks(results):
    tables = tham_tables(results, 5.0, published("tham_table_1").to_dict("records"))
    assert [table.title[:7] for table in tables] == ["Table 1", "Table 2", "Table 3", "Table 4"]
    assert tables[0].frame["Subject"].tolist() == ["S1", "S2", "S3", "S4", "S5", "mean", "SD"]
    for table in tables[1:]:
        index = table.frame.index.to_frame()
        assert index["Speed"].unique().tolist() == ["Slow", "Normal", "Fast"]
        assert index["Method"].tolist() == ["CF", "PI"] * 3 + ["NARX"] * 3
        for name in ("Error mean", "Error SD", "RMSE mean", "RMSE SD", "r mean", "r SD"):
            assert name in table.frame.columns
            assert f"paper {name}" in table.frame.columns
        assert "scored from 5 s on" in table.note


def test_figures_by_hand(results):
    frame = tham_tables(results, 5.0)[0].frame
    knees = results[
        results["segment"].str.startswith("knee")
        & (results["axis"] == "sagittal")
        & (results["condition"] == "slow")
        & (results["method"] == "narx")
    ]
    by_subject = knees.groupby("subject")
    row = frame.loc[("same ingredients", "Slow", "NARX")]
    assert row["n"] == 3
    np.testing.assert_allclose(row["Error mean"], by_subject["bias_deg"].mean().mean())
    np.testing.assert_allclose(row["Error SD"], by_subject["precision_deg"].mean().mean())
    np.testing.assert_allclose(row["RMSE SD"], by_subject["rmse_deg"].mean().std())
    np.testing.assert_allclose(row["r mean"], by_subject["r"].mean().mean())


def test_printed_figures_stand_where_they_belong(results):
    tables = tham_tables(results, 5.0)
    sagittal = tables[0].frame.loc[("as printed", "Fast", "PI")]
    assert (sagittal["paper Error mean"], sagittal["paper RMSE mean"]) == (-4.4, 5.6)
    transverse = tables[2].frame.loc[("same ingredients", "Slow", "NARX")]
    assert (transverse["paper Error mean"], transverse["paper r SD"]) == (-3.2, 0.07)


def test_the_complementary_filter_has_a_dash_in_the_transverse_plane(results):
    table = tham_tables(results, 5.0)[2]
    line = next(x for x in table.to_markdown().splitlines() if "| CF " in x)
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    assert cells[:4] == ["as printed", "Slow", "CF", "0"]
    assert set(cells[4:]) == {"–"}


def test_further_methods_and_speeds_are_further_rows(make_study):
    methods = ("narx", "vqf")
    study = make_study(subjects=("a", "b"), conditions=("stairs", "fast"), methods=methods)
    results = results_table(row for e in study for row in rows(e))
    index = tham_tables(results, 5.0)[0].frame.index.to_frame()
    assert index["Speed"].unique().tolist() == ["Fast", "Stairs"]
    assert index["Method"].tolist() == ["CF", "PI", "VQF"] * 2 + ["NARX"] * 2


def test_missing_knee_is_reported(results):
    with pytest.raises(UserError, match="results hold thigh_right, expected a knee"):
        tham_tables(results[results["segment"] == "thigh_right"], 5.0)


def test_demographics_have_the_sample_standard_deviation():
    frame = demographics_table([{"subject": "x", "mass_kg": 50}, {"subject": "y", "mass_kg": 56}])
    frame = frame.frame.set_index("Subject")
    assert frame.loc["mean", "Mass (kg)"] == 53.0
    assert frame.loc["SD", "Mass (kg)"] == pytest.approx(6.0 / np.sqrt(2.0))


@pytest.mark.parametrize(
    ("more", "mean_below", "interval_below"),
    [(-1.5, True, True), (0.0, True, False), (0.3, False, False)],
)
def test_below_print_is_the_mean_and_the_upper_end(make_study, more, mean_below, interval_below):
    """Print has 2.7 degrees; the people's means are 2.0, 2.2, 2.4 and 3.6, and more."""
    people = {"S1": 2.0, "S2": 2.2, "S3": 2.4, "S4": 3.6}
    results = results_table(row for e in make_study(tuple(people)) for row in rows(e))
    results["rmse_deg"] = results["subject"].map(people) + more
    row = interval_table(results).frame.loc[("sagittal", "Normal")]
    assert row["RMSE"] == pytest.approx(2.55 + more)
    assert (row["mean below"], row["interval below"]) == (mean_below, interval_below)


def test_demographics_with_gaps():
    frame = demographics_table([{"subject": "x", "mass_kg": 50}, {"subject": "y"}]).frame
    assert frame["Mass (kg)"].iloc[2] == 50
    assert np.isnan(frame["Height (m)"].iloc[0])


def test_interval_table(make_study):
    people = ("S1", "S2", "S3", "S4")
    results = results_table(row for e in make_study(people) for row in rows(e))
    frame = interval_table(results).frame
    assert len(frame) == 9
    row = frame.loc[("sagittal", "Normal")]
    assert row["95 % low"] <= row["RMSE"] <= row["95 % high"]
    assert row["paper RMSE"] == 2.7
    # one degree of noise on both segments is below print
    assert row["interval below"]
    # of three people there is no interval
    few = interval_table(results[results["subject"] != "S4"]).frame.loc[("sagittal", "Normal")]
    assert np.isnan(few["95 % low"])
    assert few["interval below"] is None


def test_cells_next_to_the_published_values(results):
    cells = comparison_with_published(results)
    keys = list(zip(cells["axis"], cells["condition"], cells["method"], strict=True))
    # three planes and speeds of two methods, and two planes of one that does not see the third
    assert len(keys) == len(set(keys)) == 3 * 3 * 2 + 2 * 3
    cell = cells.iloc[keys.index(("frontal", "fast", "narx"))]
    table = tham_tables(results, 5.0)[1].frame
    np.testing.assert_allclose(
        cell["rmse_deg"], table.loc[("same ingredients", "Fast", "NARX"), "RMSE mean"]
    )
    assert cell["paper rmse_deg"] == 2.9
