import numpy as np
import pandas as pd
import pytest

from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.evaluation.significance import bootstrap_mean, paired_test
from narx.experiments.tables.comparison import comparison, comparison_table
from narx.experiments.tables.subjects import subject_means


@pytest.fixture
def results(make_study):
    return results_table(row for e in make_study(subjects="ABCDE") for row in rows(e))


def test_the_subject_is_the_unit(results):
    frame = comparison(results).set_index(["segment", "axis", "method"])
    here = results[results["segment"].str.startswith("knee") & (results["axis"] == "frontal")]
    means = here.groupby(["method", "subject"])["rmse_deg"].mean().unstack("method")
    row = frame.loc[("knee", "frontal", "pseudo_integrator")]
    interval = bootstrap_mean(means["pseudo_integrator"])
    np.testing.assert_allclose([row["mean"], row["low"]], [interval.mean, interval.low])
    assert (row["n"], row["n_trials"]) == (5, 15)
    test = paired_test(means["pseudo_integrator"], means["narx"])
    np.testing.assert_allclose([row["difference"], row["p"]], [test.difference, test.p_permutation])
    assert row["p_wilcoxon"] == test.p_wilcoxon
    assert row["smallest_p"] == 0.0625
    assert row["sd"] == pytest.approx(means["pseudo_integrator"].std(ddof=1))
    lags = here[here["method"] == "pseudo_integrator"].groupby("subject")["lag_ms"].mean()
    assert row["lag_ms"] == pytest.approx(lags.mean())
    assert np.isnan(frame.loc[("knee", "frontal", "narx"), "p"])
    assert frame.loc[("knee", "transverse", "complementary_filter"), "n"] == 0


def test_same_names_in_two_datasets_are_two_people(results):
    two = pd.concat([results, results.assign(dataset="broad")])
    means = subject_means(two, ("segment", "axis", "method"))
    assert means["subject"].nunique() == 10


@pytest.mark.parametrize("quantity", ["rmse_deg", "precision_deg", "r"])
def test_printed(results, quantity):
    text = comparison_table(results, quantity).to_markdown()
    assert "p is at least 0.062" in text
    assert "less NARX" in text
    line = next(x for x in text.splitlines() if "transverse" in x)
    assert "CF" in line
    assert "–" in line
