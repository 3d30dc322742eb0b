import numpy as np
import pytest

from narx.errors import UserError
from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.experiments.tables.han import comparison_with_published, han_tables


@pytest.fixture
def results(make_study):
    study = make_study(
        conditions=("normal", "abnormal"), methods=("two_point", "gyro_integration", "narx")
    )
    return results_table(row for e in study for row in rows(e))


def test_rows_and_columns_thighs_and_shanks(results):
    tables = han_tables(results)
    assert [table.title.split(".")[0] for table in tables[:2]] == ["Table I", "Table II"]
    assert len(tables) == 3
    for table in tables:
        frame = table.frame.reset_index()
        ours = frame[frame["Figures"] == "this run"]
        assert ours["Walking"].tolist() == ["Normal", "Abnormal", "Overall"] * 2
        assert len(table.frame.columns) == 6
    assert len(tables[0].frame) == 12
    assert len(tables[2].frame) == 6


def test_figures_by_hand(results):
    frame = han_tables(results)[1].frame
    chosen = results[
        (results["method"] == "gyro_integration")
        & (results["condition"] == "abnormal")
        & results["segment"].str.startswith("shank")
        & (results["axis"] == "frontal")
    ]
    value = frame.loc[("RMSE (°)", "Abnormal", "this run"), "Add/Abd shank"]
    np.testing.assert_allclose(value, chosen["rmse_deg"].mean())
    assert frame.loc[("RMSE (°)", "Abnormal", "paper"), "Add/Abd shank"] == 36.09
    overall = frame.loc[("CORR", "Overall", "this run")]
    parts = [frame.loc[("CORR", walk, "this run")] for walk in ("Normal", "Abnormal")]
    np.testing.assert_allclose(overall.astype(float), sum(p.astype(float) for p in parts) / 2)


def test_a_trial_without_samples_is_not_counted(results):
    assert "Mean over 6 trials" in han_tables(results)[0].note
    first = (results["subject"] == "S1") & (results["condition"] == "normal")
    results.loc[first, "n_samples"] = 0
    assert "Mean over 5 trials" in han_tables(results)[0].note


def test_missing_thigh_and_shank_is_reported(results):
    with pytest.raises(UserError, match="results hold knee_left, expected one of these"):
        han_tables(results[results["segment"] == "knee_left"])


def test_columns_next_to_the_published_values(results):
    frame = comparison_with_published(results)
    assert len(frame) == 6
    chosen = results[
        (results["method"] == "two_point")
        & results["segment"].str.startswith("thigh")
        & (results["axis"] == "transverse")
    ]
    np.testing.assert_allclose(
        frame.loc[("transverse", "thigh"), "two_point"], chosen["rmse_deg"].mean()
    )
    assert frame.loc[("transverse", "thigh"), "paper two_point"] == 3.894
    assert frame.loc[("frontal", "shank"), "paper gyro_integration"] == 29.76
    without = comparison_with_published(results[results["method"] == "narx"])
    assert without[["two_point", "gyro_integration"]].isna().all(axis=None)
