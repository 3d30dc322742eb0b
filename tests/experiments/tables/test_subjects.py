"""Means over trials and sides within a person, and what is printed of them, by hand."""

import itertools

import numpy as np
import pandas as pd
import pytest

from narx.evaluation.results import COLUMNS, NUMBERS
from narx.experiments.tables.comparison import comparison_table
from narx.experiments.tables.subjects import over_subjects, subject_means

BY = ("segment", "axis", "method")


def _rows(subject, values, method="narx", dataset="d", n_samples=100, segment="knee_right"):
    """One row per trial, all numbers the same."""
    names = {
        "dataset": dataset, "subject": subject, "condition": "normal", "segment": segment,
        "axis": "sagittal", "method": method, "n_samples": n_samples,
    }  # fmt: skip
    rows = [
        names | {"trial": str(k)} | dict.fromkeys(NUMBERS, value) for k, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def test_a_person_has_the_mean_of_trials_and_counts_those_with_samples():
    knees = [_rows("A", [1.0, 2.0, 6.0]), _rows("A", [1.0, 2.0, 6.0], segment="knee_left")]
    nothing = _rows("A", [np.nan], n_samples=0).assign(trial="9")
    results = pd.concat([*knees, nothing]).assign(segment="knee")
    (row,) = subject_means(results, BY).to_dict("records")
    assert row["rmse_deg"] == pytest.approx(3.0)
    # both sides of a walk are one trial
    assert row["n_trials"] == 3


def test_the_same_name_in_two_sources_is_two_people():
    both = pd.concat([_rows("A", [1.0]), _rows("A", [5.0], dataset="other")])
    means = subject_means(both, BY)
    assert means["subject"].tolist() == ["d/A", "other/A"]
    assert means["rmse_deg"].tolist() == [1.0, 5.0]


def test_the_spread_over_people_is_that_of_a_sample():
    assert over_subjects(pd.Series([1.0, 3.0, np.nan])) == pytest.approx((2.0, np.sqrt(2.0)))
    mean, spread = over_subjects(pd.Series([5.0]))
    assert mean == 5.0
    assert np.isnan(spread)


def test_a_printed_row_is_less_the_network_with_the_p_of_exchanged_signs():
    """Eight people, six of them with another method as well: p from all 256 exchanges."""
    narx = np.array([3.0, 2.0, 4.0, 3.5, 2.5, 3.2, 2.8, 3.6])
    more = np.array([0.9, 0.8, -0.2, 1.1, 0.3, -0.1, 0.05, 0.7])
    people = [
        _rows(f"{k}", [value], method)
        for method, values in (
            ("narx", narx), ("pseudo_integrator", narx + more),
            ("leaky_integrator", (narx + 1.0)[:6]),
        )
        for k, value in enumerate(values)
    ]  # fmt: skip
    table = comparison_table(pd.concat(people))
    row = table.frame.xs("PI", level="Method").iloc[0]
    assert row["mean"] == pytest.approx((narx + more).mean())
    assert row["SD"] == pytest.approx((narx + more).std(ddof=1))
    assert row["less NARX"] == pytest.approx(more.mean())
    signs = np.array(list(itertools.product([-1.0, 1.0], repeat=8)))
    sums = np.abs(signs @ more)
    assert row["p"] == pytest.approx(np.mean(sums >= abs(more.sum()) - 1e-12))
    assert row["p"] != row["p Wilcoxon"]
    low, high = map(float, row["its 95 % interval"].split(" to "))
    assert low < more.mean() < high
    # the least p of eight, not of six
    assert "p is at least 0.0078" in table.note
    assert [comparison_table(pd.concat(people), q).decimals["SD"] for q in ("rmse_deg", "r")] == [
        2,
        3,
    ]
