import numpy as np
import pandas as pd
import pytest

from narx.experiments.peak_errors import swing_results
from narx.experiments.tables.abhayasinghe import (
    correlation_table,
    method_table,
    operations_table,
    phase_tables,
)


@pytest.fixture
def compared(make_study):
    study = make_study(knees=False, methods=("giof", "complementary_filter"))
    thighs = [e for e in study if e.segment.startswith("thigh")]
    return swing_results(thighs, {"S1": "Males", "S2": "Females", "S3": "Females"})


def test_table_1_has_the_groups_and_columns_thighs_and_shanks(compared):
    trials, _, refused = compared
    assert not refused
    frame = correlation_table(trials).frame
    assert frame.index.tolist() == ["Males", "Females", "All"]
    assert frame["No. of Subjects"].tolist() == [1, 2, 3]
    assert frame["No. of Trials"].tolist() == [6, 12, 18]
    giof = trials[trials["method"] == "giof"]
    women = giof.loc[giof["group"] == "Females", "r"]
    expected = [women.mean(), women.max(), women.min(), women.std()]
    np.testing.assert_allclose(
        frame.loc["Females", ["Mean", "Max", "Min", "Std"]].astype(float), expected
    )
    assert frame.loc["All", "paper Mean"] == 0.9958
    assert frame.loc["Males", "paper Trials"] == 196


def test_an_empty_group_keeps_its_row(compared):
    trials = compared[0].assign(group="All")
    frame = correlation_table(trials).frame
    assert frame.loc["Males", "No. of Trials"] == 0
    assert "–" in correlation_table(trials).to_markdown()


def test_methods_side_by_side(compared):
    trials, peaks, _ = compared
    frame = method_table(trials, peaks).frame
    assert frame.index.tolist() == ["CF", "GIOF", "paper, GIOF", "paper, GIOF, vision impaired"]
    error = peaks.loc[(peaks["method"] == "giof") & (peaks["peak"] == "positive"), "error_deg"]
    np.testing.assert_allclose(frame.loc["GIOF", "RMSE positive peaks"], np.sqrt((error**2).mean()))
    assert frame.loc["paper, GIOF", "RMSE negative peaks"] == 2.4967
    mine = trials[trials["method"] == "giof"]
    assert frame.loc["GIOF", "bias"] == pytest.approx(mine["bias_deg"].mean())
    assert frame.loc["GIOF", "SD of error"] == pytest.approx(mine["precision_deg"].mean())
    assert frame.loc["GIOF", "RMSE SD"] == pytest.approx(mine["rmse_deg"].std(ddof=1))


def test_people_of_two_data_sets_with_one_name_are_two(compared):
    trials = compared[0]
    both = pd.concat([trials, trials.assign(dataset="other")], ignore_index=True)
    assert correlation_table(both).frame["No. of Subjects"].tolist() == [2, 4, 6]


def test_operations():
    counts = {"giof": {"additions": 6.0, "arctangents": 0.1}, "vqf": {"square roots": 9.0}}
    frame = operations_table(counts).frame
    assert frame.loc["GIOF", "arctangents"] == 0.1
    assert frame.loc["VQF", "square roots"] == 9.0
    assert np.isnan(frame.loc["VQF", "additions"])
    assert frame.loc["paper, CF", "multiplications"] == 4


def test_phases_as_printed_and_as_measured():
    plain = phase_tables()
    assert plain[0].frame.index.tolist() == ["a", "b", "b–c", "c–d", "d–e", "e–f", "f–g"]
    assert plain[1].frame.index.tolist() == list("abcdef")
    durations = pd.DataFrame({"phase": ["f–g", "f–g"], "share": [0.3, 0.4]})
    timing = pd.DataFrame({"point": ["b", "b", "e"], "error_s": [0.01, 0.03, np.nan]})
    phases, points = (table.frame for table in phase_tables(durations, timing))
    np.testing.assert_allclose(phases.loc["f–g", "share of stride (%)"], 35.0)
    np.testing.assert_allclose(points.loc["b", "mean error (ms)"], 20.0)
    # of two values the standard deviation is the difference by the root of two
    assert phases.loc["f–g", "SD (%)"] == pytest.approx(10.0 / np.sqrt(2.0))
    assert points.loc["b", "SD (ms)"] == pytest.approx(20.0 / np.sqrt(2.0))
    assert points.loc["e", "n"] == 0
