"""All methods in one table: means over subjects of every segment and axis."""

from collections.abc import Container

import pandas as pd

from narx.experiments.method_labels import method_block, method_label, method_order
from narx.experiments.tables.comparison import QUANTITIES
from narx.experiments.tables.subjects import subject_means
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of


def overview_table(results: pd.DataFrame, quantity: str, not_causal: Container[str] = ()) -> Table:
    """Average a metric over subjects, one column per segment and axis.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``.
    quantity : {"rmse_deg", "precision_deg"}
        Metric, degrees.
    not_causal : container of str
        Rows that use later samples.

    Returns
    -------
    Table
        One row per method; both sides of a segment together. Columns without any number are left
        out.
    """
    sided = results.assign(segment=results["segment"].map(kind_of))
    means = subject_means(sided, ("segment", "axis", "method"))
    mean = means.groupby(["segment", "axis", "method"], sort=False)[quantity].mean()
    rows = method_order(means["method"])
    labels = [method_label(row, not_causal) for row in rows]
    index = pd.MultiIndex.from_arrays(
        [[method_block(row) for row in rows], labels], names=["Block", "Method"]
    )
    frame = pd.DataFrame(
        {
            f"{segment} {axis}": [mean.get((segment, axis, row)) for row in rows]
            for segment in means["segment"].unique()
            for axis in AXES
        },
        index=index,
    ).dropna(axis="columns", how="all")
    precision, n = quantity == "precision_deg", means["subject"].nunique()
    return Table(
        f"{QUANTITIES[quantity]} (°), mean over {n} subject{'s' * (n != 1)}",
        frame,
        dict.fromkeys(frame.columns, 2),
        "Precision is the SD of the error over a trial." if precision else "",
    )
