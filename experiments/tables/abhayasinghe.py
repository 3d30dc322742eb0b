"""Tables 1 to 3 of Abhayasinghe et al. (2019) and the values in the text of its section 3."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from narx.experiments.method_labels import method_label, method_order
from narx.experiments.published import published
from narx.experiments.tables.subjects import over_subjects
from narx.experiments.tables.table import Table

# a person's trials are repeated measures, so people are counted by name and dataset
_PERSON = ["dataset", "subject"]
_GROUP_ORDER = ("Males", "Females", "All")


def correlation_table(trials: pd.DataFrame, method: str = "giof") -> Table:
    """Table 1: correlation with the reference by group.

    Parameters
    ----------
    trials : pandas.DataFrame
        From `narx.experiments.peak_errors.swing_results`.
    method : str
        Method whose correlation is tabulated.

    Returns
    -------
    Table
        The printed columns (subjects, trials, mean, maximum, minimum, SD over trials), one row per
        group and ``All``, with the printed values.
    """
    mine = trials[trials["method"] == method]
    groups = [*mine["group"].unique(), *published("abhayasinghe_table_1")["group"], "All"]
    known = {name: k for k, name in enumerate(_GROUP_ORDER)}
    printed = published("abhayasinghe_table_1").set_index("group").to_dict("index")
    rows = []
    for group in sorted(set(groups), key=lambda name: (known.get(str(name), -1), str(name))):
        chosen = mine if group == "All" else mine[mine["group"] == group]
        r = chosen["r"].dropna()
        paper = printed.get(group, {})
        rows.append(
            {
                "Group": group,
                "No. of Subjects": len(chosen[_PERSON].drop_duplicates()),
                "No. of Trials": len(r),
                "Mean": r.mean(),
                "Max": r.max(),
                "Min": r.min(),
                "Std": r.std(ddof=1),
                **{
                    f"paper {name}": paper.get(column)
                    for name, column in (
                        ("Subjects", "n_subjects"), ("Trials", "n_trials"), ("Mean", "r_mean"),
                        ("Max", "r_max"), ("Min", "r_min"), ("Std", "r_sd"),
                    )
                },
            }
        )  # fmt: skip
    return Table(
        f"Table 1. Correlation between the thigh angle of {method_label(method)} and the reference",
        pd.DataFrame(rows).set_index("Group"),
        {
            f"{whose}{name}": 6 if name == "Std" else 4
            for whose in ("", "paper ")
            for name in ("Mean", "Max", "Min", "Std")
        },
        "Over trials (a leg counts as a trial), 1000 Hz, from minimum to minimum of the reference.",
    )


def _rms(values: pd.Series) -> float:
    array = values.dropna().to_numpy(dtype=float)
    return float(np.sqrt(np.mean(array**2))) if len(array) else float("nan")


def method_table(trials: pd.DataFrame, peaks: pd.DataFrame) -> Table:
    """Section 3 in one table: GIOF, the complementary filter and the other methods.

    Parameters
    ----------
    trials, peaks : pandas.DataFrame
        From `narx.experiments.peak_errors.swing_results`.

    Returns
    -------
    Table
        Correlation and RMSE over trials, RMSE and bias of the positive and negative peaks, one row
        per method, then the two printed rows.
    """
    rows = []
    for method in method_order(trials["method"]):
        mine = trials[trials["method"] == method]
        r, rmse = over_subjects(mine["r"]), over_subjects(mine["rmse_deg"])
        row: dict[str, object] = {"Method": method_label(method), "Trials": len(mine)}
        row |= {"r mean": r[0], "r SD": r[1], "RMSE mean": rmse[0], "RMSE SD": rmse[1]}
        row |= {"bias": mine["bias_deg"].mean(), "SD of error": mine["precision_deg"].mean()}
        for kind in ("positive", "negative"):
            error = peaks.loc[(peaks["method"] == method) & (peaks["peak"] == kind), "error_deg"]
            row |= {f"RMSE {kind} peaks": _rms(error), f"bias {kind} peaks": error.mean()}
        rows.append(row)
    text = published("abhayasinghe_text").set_index("quantity")["value"]
    printed = published("abhayasinghe_table_1").set_index("group")
    rows.append(
        {
            "Method": "paper, GIOF",
            "Trials": 374,
            "r mean": float(printed["r_mean"]["All"]),
            "r SD": float(printed["r_sd"]["All"]),
            "RMSE mean": float(text["rmse_mean_deg"]),
            "RMSE SD": float(text["rmse_sd_deg"]),
            "RMSE positive peaks": float(text["rmse_positive_peak_deg"]),
            "RMSE negative peaks": float(text["rmse_negative_peak_deg"]),
        }
    )
    rows.append(
        {
            "Method": "paper, GIOF, vision impaired",
            "Trials": int(text["vision_impaired_n_trials"]),
            "r mean": float(text["vision_impaired_r_mean"]),
            "r SD": float(text["vision_impaired_r_sd"]),
            "RMSE mean": float(text["vision_impaired_rmse_mean_deg"]),
            "RMSE SD": float(text["vision_impaired_rmse_sd_deg"]),
        }
    )
    return Table(
        "Thigh angle: correlation, RMSE (°) of trials and of peaks (°)",
        pd.DataFrame(rows).set_index("Method"),
        {
            "r mean": 4,
            "r SD": 4,
            **dict.fromkeys(("RMSE mean", "RMSE SD", "bias", "SD of error"), 2),
        }
        | {f"{q} {k} peaks": 2 for q in ("RMSE", "bias") for k in ("positive", "negative")},
        "Bias = reference - estimate, over trials and at the peaks; SD of error is within a trial, "
        "about its mean. The paper gives no value for the complementary filter's correlation, only "
        "that it is 'close to' GIOF's.",
    )


def operations_table(counts: Mapping[str, Mapping[str, float]]) -> Table:
    """Operations per sample, counted, with the printed counts and times.

    Parameters
    ----------
    counts : mapping of str to mapping of str to float
        By method, operations per sample by kind (``additions``, ``multiplications``,
        ``comparisons``, ``arctangents``, ...), means over a recording.

    Returns
    -------
    Table
        One row per method, one column per kind, then the printed rows.
    """
    kinds: list[str] = []
    for by_kind in counts.values():
        kinds += [kind for kind in by_kind if kind not in kinds]
    printed = ("additions", "multiplications", "comparisons", "arctangents")
    kinds += [kind for kind in printed if kind not in kinds]
    text = published("abhayasinghe_text").set_index("quantity")["value"].astype(float)
    rows: list[dict[str, object]] = [
        {"Method": method_label(method), **counts[method]} for method in method_order(counts)
    ]
    time = "time on ATmega328 (µs)"
    rows += [
        {
            "Method": "paper, CF",
            "additions": text["complementary_filter_additions"],
            "multiplications": text["complementary_filter_multiplications"],
            "arctangents": text["complementary_filter_arctangents"],
            time: text["complementary_filter_time_us"],
        },
        {
            "Method": "paper, GIOF (its two tests only)",
            "additions": text["giof_test_additions"],
            "multiplications": text["giof_test_multiplications"],
            "comparisons": text["giof_test_comparisons"],
            time: text["giof_time_walking_us"],
        },
        {"Method": "paper, 2-point (per angle)", "additions": 7.0, "multiplications": 4.0},
    ]
    frame = pd.DataFrame(rows).reindex(columns=["Method", *kinds, time])
    return Table(
        "Floating-point operations and arctangents per sample",
        frame.set_index("Method"),
        {**dict.fromkeys(kinds, 2), time: 0},
        "Counted while the method ran, mean over the walk, for one angle. The paper's times are "
        "the mean of GIOF while walking (225 µs without arctangent, 500 µs with) and that of the "
        "complementary filter; 2-point adds two arctangents per walk.",
    )


def phase_tables(
    durations: pd.DataFrame | None = None, timing: pd.DataFrame | None = None
) -> list[Table]:
    """Tables 2 and 3: phases of gait in the thigh angle and the signal that detects each point.

    Parameters
    ----------
    durations : pandas.DataFrame, optional
        Detected phases: columns ``phase`` (``b–c`` to ``f–g``, as printed) and ``share`` (of its
        stride, 0 to 1).
    timing : pandas.DataFrame, optional
        Detected events: columns ``point`` (a to f) and ``error_s`` (detected minus true time; NaN
        without a true time).

    Returns
    -------
    list of Table
        The printed rows with the measured values; dashes where there are none.
    """
    phases = []
    for row in published("abhayasinghe_table_2").to_dict("records"):
        share = pd.Series(dtype=float)
        if durations is not None:
            share = 100.0 * durations.loc[durations["phase"] == row["points"], "share"].dropna()
        phases.append(
            {
                "Point/Points": row["points"],
                "Phase/Point of Gait Cycle": row["phase"],
                # a point has no duration
                "n": len(share) if len(row["points"]) > 1 else None,
                "share of stride (%)": share.mean(),
                "SD (%)": share.std(ddof=1),
            }
        )
    points = []
    for row in published("abhayasinghe_table_3").to_dict("records"):
        error = pd.Series(dtype=float)
        if timing is not None:
            error = 1000.0 * timing.loc[timing["point"] == row["point"], "error_s"].dropna()
        points.append(
            {
                "Point": row["point"],
                "Signal to Detect Zero Crossing to Detect Each Point": row["signal"],
                "n": len(error),
                "mean error (ms)": error.mean(),
                "SD (ms)": error.std(ddof=1),
            }
        )
    return [
        Table(
            "Table 2. Phases of gait cycle as identified in the thigh angle waveform",
            pd.DataFrame(phases).astype({"n": "Int64"}).set_index("Point/Points"),
            note="Point g is point b of the next stride.",
        ),
        Table(
            "Table 3. Signal feature that can be used to detect each point of the stride cycle",
            pd.DataFrame(points).set_index("Point"),
            {"mean error (ms)": 0, "SD (ms)": 0},
            "Point c is not a zero crossing: it is the relative maximum of the derivative. Error = "
            "detected - true time, at points with a true event: heel strike (b) and toe-off (f) of "
            "the same foot, toe-off (c) and heel strike (e) of the other foot.",
        ),
    ]
