"""Reduce results to one value per person, the unit of every mean and SD over subjects."""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from narx.evaluation.results import NUMBERS

_CONDITIONS = ("slow", "normal", "fast", "abnormal")


def subject_means(results: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Average trials, sides and all other columns not in `by` within each subject.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``.
    by : sequence of str
        Columns to keep apart, such as ``condition``, ``axis``, ``method``.

    Returns
    -------
    pandas.DataFrame
        Columns `by`, ``subject`` (prefixed with the dataset if there are several), the
        numbers of ``results.csv`` and ``n_trials``. Trials without a result of a method are left
        out.
    """
    results = results.copy()
    if results["dataset"].nunique() > 1:
        results["subject"] = results["dataset"] + "/" + results["subject"]
    groups = results.groupby([*by, "subject"], sort=False, dropna=False)
    means = groups[list(NUMBERS)].mean()
    scored = results[results["n_samples"] > 0].assign(
        trial=lambda r: r["condition"] + "/" + r["trial"]
    )
    trials = scored.groupby([*by, "subject"], sort=False)["trial"].nunique()
    means["n_trials"] = trials.reindex(means.index).fillna(0).astype(int)
    return means.reset_index()


def over_subjects(values: pd.Series) -> tuple[float, float]:
    """Mean and SD over subjects.

    Parameters
    ----------
    values : pandas.Series
        One value per subject; NaN are left out.

    Returns
    -------
    mean, sd : float
        SD with n - 1; NaN below two subjects.
    """
    array = values.dropna().to_numpy(dtype=float)
    if len(array) == 0:
        return float("nan"), float("nan")
    spread = np.isfinite(array).all() and len(array) > 1
    return float(array.mean()), float(array.std(ddof=1)) if spread else float("nan")


def condition_order(conditions: Iterable[str]) -> list[str]:
    """Sort conditions: slow, normal, fast, abnormal, then the others by name.

    Parameters
    ----------
    conditions : iterable of str
        Names, repeated or not.

    Returns
    -------
    list of str
        Each once.
    """
    known = {name: k for k, name in enumerate(_CONDITIONS)}
    return sorted(set(conditions), key=lambda name: (known.get(name, len(known)), name))
