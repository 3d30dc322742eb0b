"""The tables of the benchmark's page hold the means of the results."""

import numpy as np
import pandas as pd
import pytest

from narx.errors import UserError
from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.experiments.benchmark_page import BEGIN, END, with_table
from narx.experiments.tables.page import (
    Source,
    at_a_glance,
    by_motion,
    subject_condition_means,
)


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
    page = with_table(f"before\n{BEGIN}\nold\n{END}\nafter\n", table)
    assert page.startswith(f"before\n{BEGIN}\n|")
    assert page.endswith(f"|\n{END}\nafter\n")
    assert "old" not in page
    assert with_table(page, table) == page
    with pytest.raises(UserError, match="expected the markers"):
        with_table("no marks", table)
