"""Tables 1 to 4 of Tham et al. (2020): the values of a run and the published ones.

Meaning of the columns: a subject's value is the mean over trials and legs. *Error* is the
bias (its mean over subjects) and the precision (the SD of the error within a trial, mean over
subjects); *RMSE* and *r* are mean and SD over subjects. The paper is not explicit about the SD of
the error; see ``experiments/published/README.md``.
"""

from collections.abc import Container, Iterable, Mapping

import numpy as np
import pandas as pd

from narx.errors import UserError
from narx.evaluation.significance import bootstrap_mean
from narx.experiments.method_labels import BLOCKS, method_block, method_label, method_order
from narx.experiments.published import published
from narx.experiments.tables.subjects import condition_order, over_subjects, subject_means
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES

_COLUMNS = ("Error mean", "Error SD", "RMSE mean", "RMSE SD", "r mean", "r SD")
_PRINTED = (
    "error_mean_deg", "error_sd_deg", "rmse_mean_deg", "rmse_sd_deg", "r_mean", "r_sd",
)  # fmt: skip
_DECIMALS = {"r mean": 2, "r SD": 2, "paper r mean": 2, "paper r SD": 2}
_METHODS = ("complementary_filter", "narx", "pseudo_integrator")


def _printed() -> dict[tuple[str, str, str], dict[str, float]]:
    """Published values by axis, condition and method."""
    rows = published("tham_tables_2_to_4").to_dict("records")
    return {
        (row["axis"], row["condition"], row["method"]): {name: row[name] for name in _PRINTED}
        for row in rows
    }


def _knees(results: pd.DataFrame) -> pd.DataFrame:
    knees = results[results["segment"].str.startswith("knee")]
    if knees.empty:
        found = ", ".join(sorted(set(results["segment"]))) or "nothing"
        raise UserError(f"tables of the knee angle: results hold {found}, expected a knee")
    return knees


def demographics_table(subjects: Iterable[Mapping[str, object]]) -> Table:
    """Table 1: the subjects.

    Parameters
    ----------
    subjects : iterable of mapping
        One mapping per subject with ``subject``, ``gender``, ``age_years``, ``height_m`` and
        ``mass_kg``; missing values are shown as dashes.

    Returns
    -------
    Table
        One row per subject, then mean and SD.
    """
    columns = {
        "subject": "Subject",
        "gender": "Gender",
        "age_years": "Age (years)",
        "height_m": "Height (m)",
        "mass_kg": "Mass (kg)",
    }
    frame = pd.DataFrame(list(subjects)).reindex(columns=list(columns)).rename(columns=columns)
    numbers = list(columns.values())[2:]
    values = frame[numbers].astype(float)
    summary = pd.DataFrame([values.mean(), values.std(ddof=1)]).assign(Subject=["mean", "SD"])
    summary["Gender"] = ""
    frame[numbers] = values
    return Table(
        "Table 1. Demographic characteristics of the subjects",
        pd.concat([frame, summary[frame.columns]], ignore_index=True),
        {"Age (years)": 1, "Height (m)": 2, "Mass (kg)": 1},
    )


def _axis_table(
    knees: pd.DataFrame, axis: str, number: int, note: str, not_causal: Container[str]
) -> Table:
    means = subject_means(knees[knees["axis"] == axis], ("condition", "method"))
    printed = _printed()
    rows = []
    for condition in condition_order(means["condition"]):
        for method in method_order([*_METHODS, *means["method"]]):
            subjects = means[(means["condition"] == condition) & (means["method"] == method)]
            row: dict[str, object] = {
                "Block": method_block(method),
                "Speed": condition.capitalize(),
                "Method": method_label(method, not_causal),
            }
            row["n"] = int(subjects["rmse_deg"].notna().sum())
            error = over_subjects(subjects["bias_deg"])[0]
            precision = over_subjects(subjects["precision_deg"])[0]
            rmse, r = over_subjects(subjects["rmse_deg"]), over_subjects(subjects["r"])
            row |= dict(zip(_COLUMNS, (error, precision, *rmse, *r), strict=True))
            # the published values are of the paper's own network
            paper = printed.get((axis, condition, method.removesuffix("_as_printed")), {})
            row |= {
                f"paper {name}": paper.get(column, float("nan"))
                for name, column in zip(_COLUMNS, _PRINTED, strict=True)
            }
            rows.append(row)
    return Table(
        f"Table {number}. Error (°), RMSE (°) and correlation coefficient (r) between the methods "
        f"and the reference, knee angle in the {axis} plane",
        pd.DataFrame(
            [row for block in BLOCKS for row in rows if row["Block"] == block],
        ).set_index(["Block", "Speed", "Method"]),
        _DECIMALS,
        note,
    )


def tham_tables(
    results: pd.DataFrame,
    skip_s: float,
    subjects: Iterable[Mapping[str, object]] | None = None,
    not_causal: Container[str] = (),
) -> list[Table]:
    """Tables 1 to 4 with the printed values.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``, with knees among the segments.
    skip_s : float
        Seconds left out at the start of each trial, for the notes below the tables.
    subjects : iterable of mapping, optional
        For Table 1 (`demographics_table`); left out if not given.
    not_causal : container of str
        Rows that use later samples.

    Returns
    -------
    list of Table
        Table 1 if there are demographics, then 2 (sagittal), 3 (frontal), 4 (transverse); further
        methods and speeds as further rows.

    Raises
    ------
    UserError
        If no knee is among the segments.
    """
    knees = _knees(results)
    note = (
        f"Error = reference - estimate; scored from {skip_s:g} s on. Error SD is the SD within a "
        "trial (precision), RMSE SD and r SD are over the n subjects, each the mean of their legs. "
        "A dash is an angle that the method does not observe, or a value that is not printed."
    )
    tables = [] if subjects is None else [demographics_table(subjects)]
    return tables + [
        _axis_table(knees, axis, number, note, not_causal)
        for number, axis in enumerate(AXES, start=2)
    ]


def interval_table(results: pd.DataFrame, method: str = "narx", seed: int = 0) -> Table:
    """RMSE of a method with its bootstrap interval and the printed mean.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``, with knees among the segments.
    method : str
        Which method.
    seed : int
        Of the bootstrap.

    Returns
    -------
    Table
        One row per plane and speed: n, RMSE with 95 % interval over subjects, the paper's RMSE,
        and whether the mean and the whole interval are below it.
    """
    knees = _knees(results)
    knees = knees[knees["method"] == method]
    printed = _printed()
    rows = []
    for axis in AXES:
        means = subject_means(knees[knees["axis"] == axis], ("condition",))
        for condition in condition_order(means["condition"]):
            rmse = bootstrap_mean(
                means.loc[means["condition"] == condition, "rmse_deg"].to_numpy(), seed=seed
            )
            key = (axis, condition, method)
            known = key in printed
            paper = printed[key]["rmse_mean_deg"] if known else float("nan")
            rows.append(
                {
                    "Plane": axis,
                    "Speed": condition.capitalize(),
                    "n": rmse.n,
                    "RMSE": rmse.mean,
                    "95 % low": rmse.low,
                    "95 % high": rmse.high,
                    "paper RMSE": paper,
                    "mean below": bool(rmse.mean < paper) if known else None,
                    # of few people there is no interval
                    "interval below": (
                        bool(rmse.high < paper) if known and not np.isnan(rmse.high) else None
                    ),
                }
            )
    return Table(
        f"RMSE (°) of {method_label(method)} with its 95 % confidence interval over subjects",
        pd.DataFrame(rows).set_index(["Plane", "Speed"]),
        dict.fromkeys(("RMSE", "95 % low", "95 % high"), 2),
        "Expanded percentile bootstrap over subjects.",
    )


def comparison_with_published(results: pd.DataFrame) -> pd.DataFrame:
    """Compare every cell of Tables 2 to 4 with its published RMSE.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``, with knees among the segments.

    Returns
    -------
    pandas.DataFrame
        One row per axis, condition and method that observes the axis: ``bias_deg``,
        ``precision_deg``, ``rmse_deg``, ``r``, means over subjects, and ``paper rmse_deg``, NaN
        if none is published.

    Raises
    ------
    UserError
        If no knee is among the segments.
    """
    means = subject_means(_knees(results), ("axis", "condition", "method"))
    numbers = ["bias_deg", "precision_deg", "rmse_deg", "r"]
    cells = means.groupby(["axis", "condition", "method"], sort=False)[numbers].mean()
    cells = cells.dropna(subset=["rmse_deg"]).reset_index()
    printed = _printed()
    paper = [
        printed.get((row["axis"], row["condition"], row["method"]), {}).get("rmse_mean_deg")
        for row in cells.to_dict("records")
    ]
    cells["paper rmse_deg"] = pd.Series(paper, index=cells.index, dtype=float)
    return cells
