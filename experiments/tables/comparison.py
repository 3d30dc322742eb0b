"""Compare all methods on any source: mean over subjects, interval, test against one method."""

from collections.abc import Container

import pandas as pd

from narx.evaluation.significance import bootstrap_mean, paired_test
from narx.experiments.method_labels import method_block, method_label, method_order
from narx.experiments.tables.subjects import over_subjects, subject_means
from narx.experiments.tables.table import Table, shown
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of

QUANTITIES = {"precision_deg": "precision", "rmse_deg": "RMSE"}


def comparison(
    results: pd.DataFrame,
    quantity: str = "rmse_deg",
    against: str = "narx",
    seed: int = 0,
) -> pd.DataFrame:
    """Compare methods over subjects, with intervals and a paired test against one of them.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``.
    quantity : {"rmse_deg", "precision_deg", "r"}
        Metric to compare.
    against : str
        Method that the others are tested against.
    seed : int
        Of bootstrap and permutations.

    Returns
    -------
    pandas.DataFrame
        One row per segment (both sides together), axis and method: ``n`` subjects, ``n_trials``,
        ``mean``, ``sd``, ``low``, ``high`` (95 % interval), ``lag_ms`` (mean), ``difference`` from
        `against` (method minus `against`) with ``difference_low`` and ``difference_high``, ``p``
        (permutation), ``p_wilcoxon``, ``smallest_p``.
    """
    sided = results.assign(segment=results["segment"].map(kind_of))
    means = subject_means(sided, ("segment", "axis", "method"))
    rows = []
    for segment in means["segment"].unique():
        for axis in AXES:
            here = means[(means["segment"] == segment) & (means["axis"] == axis)]
            table = here.pivot(index="subject", columns="method", values=quantity)
            lags = here.groupby("method")["lag_ms"].mean()
            for method in method_order(here["method"]):
                own = method.replace("_heading_zero", "")
                if own != method and own in table and table[own].equals(table[method]):
                    continue  # the tilt of a single segment does not depend on its heading
                values = table[method]
                interval = bootstrap_mean(values.to_numpy(), seed=seed)
                row: dict[str, object] = {"segment": segment, "axis": axis, "method": method}
                row |= {"n": interval.n, "n_trials": _trials(here, method)}
                row |= {"mean": interval.mean, "sd": over_subjects(values)[1]}
                row |= {"low": interval.low, "high": interval.high, "lag_ms": lags[method]}
                if method != against and against in table:
                    test = paired_test(values.to_numpy(), table[against].to_numpy(), seed=seed)
                    row |= {
                        "difference": test.difference,
                        "difference_low": test.low,
                        "difference_high": test.high,
                        "p": test.p_permutation,
                        "p_wilcoxon": test.p_wilcoxon,
                        "smallest_p": test.smallest_p,
                    }
                rows.append(row)
    columns = [
        "segment", "axis", "method", "n", "n_trials", "mean", "sd", "low", "high", "lag_ms",
        "difference", "difference_low", "difference_high", "p", "p_wilcoxon", "smallest_p",
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def _trials(here: pd.DataFrame, method: str) -> int:
    return int(here.loc[here["method"] == method, "n_trials"].sum())


def comparison_table(
    results: pd.DataFrame,
    quantity: str = "rmse_deg",
    against: str = "narx",
    seed: int = 0,
    not_causal: Container[str] = (),
) -> Table:
    """Format `comparison` as a table.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``.
    quantity : {"rmse_deg", "precision_deg", "r"}
        Metric to compare.
    against : str
        Method that the others are tested against.
    seed : int
        Of bootstrap and permutations.
    not_causal : container of str
        Rows that use later samples.

    Returns
    -------
    Table
        One row per segment, axis and method.
    """
    frame = comparison(results, quantity, against, seed)
    digits = 3 if quantity == "r" else 2
    printed = pd.DataFrame(
        {
            "Segment": frame["segment"],
            "Axis": frame["axis"],
            "Block": frame["method"].map(method_block),
            "Method": [method_label(row, not_causal) for row in frame["method"]],
            "subjects": frame["n"],
            "trials": frame["n_trials"],
            "mean": frame["mean"],
            "SD": frame["sd"],
            "95 % interval": _interval(frame["low"], frame["high"], digits),
            f"less {method_label(against)}": frame["difference"],
            "its 95 % interval": _interval(
                frame["difference_low"], frame["difference_high"], digits
            ),
            "p": frame["p"],
            "p Wilcoxon": frame["p_wilcoxon"],
            "lag (ms)": frame["lag_ms"],
        }
    ).set_index(["Segment", "Axis", "Block", "Method"])
    name = QUANTITIES.get(quantity, quantity)
    unit = "" if quantity == "r" else " (°)"
    smallest = frame["smallest_p"].min()
    least = "" if smallest != smallest else f" With so few subjects, p is at least {smallest:.2g}."
    return Table(
        f"{name}{unit} by method, over subjects",
        printed,
        {"mean": digits, "SD": digits, f"less {method_label(against)}": digits}
        | {"p": 3, "p Wilcoxon": 3, "lag (ms)": 0},
        "Trials and sides are averaged within subjects first. Intervals: expanded percentile "
        f"bootstrap over subjects; p: exact permutation of paired differences.{least} "
        "Lag: delay of the estimate, to first order; it includes phase errors. "
        "Blocks: each method as its paper prints it, and with the same ingredients as the network. "
        "Heading 0 or leak: the filter's heading is set to zero or leaks to zero, shown where this "
        "changes the angle. Chosen: parameters chosen on the training part of each fold.",
    )


def _interval(low: pd.Series, high: pd.Series, digits: int) -> list[str | None]:
    return [
        None if a != a or b != b else f"{shown(a, digits)} to {shown(b, digits)}"
        for a, b in zip(low, high, strict=True)
    ]
