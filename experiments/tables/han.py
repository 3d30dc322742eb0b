"""Tables I and II of Han et al.: average RMSE and correlation of thigh and shank, three axes."""

import pandas as pd

from narx.errors import UserError
from narx.experiments.method_labels import method_label, method_order
from narx.experiments.published import published
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES

SEGMENTS = ("thigh", "shank")
_HEADINGS = {
    (axis, segment): f"{name} {segment}"
    for axis, name in zip(AXES, ("Flex/Ext", "Add/Abd", "Int/Ext rot."), strict=True)
    for segment in SEGMENTS
}
_QUANTITIES = {"rmse_deg": "RMSE (°)", "r": "CORR"}
_NUMBERS = {"two_point": "I", "gyro_integration": "II"}


def _method_table(results: pd.DataFrame, method: str) -> Table:
    mine = results[results["method"] == method]
    printed = {
        (row["method"], row["quantity"], row["condition"]): row
        for row in published("han_tables_1_and_2").to_dict("records")
    }
    walks = [*dict.fromkeys([*("normal", "abnormal"), *sorted(mine["condition"].unique())])]
    rows = []
    for quantity, name in _QUANTITIES.items():
        for walk in [*walks, "overall"]:
            chosen = mine if walk == "overall" else mine[mine["condition"] == walk]
            means = chosen.groupby(["axis", "body"])[quantity].mean()
            row: dict[str, object] = {"": name, "Walking": walk.capitalize(), "Figures": "this run"}
            row |= {h: means.get(key, float("nan")) for key, h in _HEADINGS.items()}
            rows.append(row)
            paper = printed.get((method, quantity, walk))
            if paper:
                row = {"": name, "Walking": walk.capitalize(), "Figures": "paper"}
                row |= {h: float(paper[f"{a}_{s}"]) for (a, s), h in _HEADINGS.items()}
                rows.append(row)
    number = f"Table {_NUMBERS[method]}. " if method in _NUMBERS else ""
    trials = mine[mine["n_samples"] > 0]
    n = len(trials[["dataset", "subject", "condition", "trial"]].drop_duplicates())
    frame = pd.DataFrame(rows).set_index(["", "Walking", "Figures"])
    return Table(
        f"{number}Average RMSE and correlation of thigh and shank angles by {method_label(method)}",
        frame,
        dict.fromkeys(frame.columns, 3),
        f"Mean over {n} trials (both legs where there are two), scored over the walk only, from "
        "its start A to its stop B.",
    )


def han_tables(results: pd.DataFrame) -> list[Table]:
    """Tables I (2-point) and II (plain integration), and the same for every other method.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``, with thighs or shanks among the segments, scored over the
        walk only.

    Returns
    -------
    list of Table
        Rows and columns as in the paper, with the published values below each row of this run;
        conditions other than normal and abnormal are further rows.

    Raises
    ------
    UserError
        If there is neither thigh nor shank.
    """
    chosen = _thighs_and_shanks(results)
    others = [m for m in method_order(chosen["method"]) if m not in _NUMBERS]
    return [_method_table(chosen, method) for method in [*_NUMBERS, *others]]


def _thighs_and_shanks(results: pd.DataFrame) -> pd.DataFrame:
    """Rows of thighs and shanks, with a column ``body``."""
    body = results["segment"].str.split("_").str[0]
    chosen = results.assign(body=body)[body.isin(SEGMENTS)]
    if chosen.empty:
        found = ", ".join(sorted(set(results["segment"]))) or "nothing"
        raise UserError(f"tables of thigh and shank: results hold {found}, expected one of these")
    return chosen


def comparison_with_published(results: pd.DataFrame) -> pd.DataFrame:
    """Compare the overall RMSE of every column with the published one.

    Parameters
    ----------
    results : pandas.DataFrame
        As for `han_tables`.

    Returns
    -------
    pandas.DataFrame
        Index axis and body part; columns the methods and, if published, ``paper <method>``,
        degrees; NaN where an axis is not scored.

    Raises
    ------
    UserError
        If there is neither thigh nor shank.
    """
    means = _thighs_and_shanks(results).pivot_table(
        index=["axis", "body"], columns="method", values="rmse_deg", aggfunc="mean"
    )
    means = means.reindex(list(_HEADINGS)).reindex(
        columns=[*dict.fromkeys([*means.columns, *_NUMBERS])]
    )
    for row in published("han_tables_1_and_2").to_dict("records"):
        if row["quantity"] == "rmse_deg" and row["condition"] == "overall":
            paper = [float(row[f"{axis}_{body}"]) for axis, body in _HEADINGS]
            means[f"paper {row['method']}"] = paper
    return means
