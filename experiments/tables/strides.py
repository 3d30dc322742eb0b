"""Tables for a gait laboratory: errors per stride, reliability, the gait cycle."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from narx.evaluation.reliability import reliability
from narx.evaluation.strides import StrideSet, mean_waveforms
from narx.evaluation.waveform_test import waveform_test
from narx.experiments.method_labels import method_label
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES


def stride_errors_table(strides: pd.DataFrame, title: str) -> Table:
    """Summarise the errors of range of motion and peaks over strides.

    Parameters
    ----------
    strides : pandas.DataFrame
        From `narx.evaluation.strides.stride_table`, of joints or segments of one kind.
    title : str
        Joint or segment, for the title.

    Returns
    -------
    Table
        One row per axis and method: means over subjects of each subject's mean (and SD) over
        strides; error = reference - estimate.
    """
    errors = strides.assign(
        range_error=strides["range_reference"] - strides["range_estimate"],
        maximum_error=strides["maximum_reference"] - strides["maximum_estimate"],
        minimum_error=strides["minimum_reference"] - strides["minimum_estimate"],
    )
    rows = []
    for axis in AXES:
        for method, group in errors[errors["axis"] == axis].groupby("method", sort=False):
            by_subject = group.groupby(["dataset", "subject"])
            mean = by_subject.mean(numeric_only=True).mean()
            spread = by_subject.std(numeric_only=True).mean()
            rows.append(
                {
                    "Axis": axis,
                    "Method": method_label(str(method)),
                    "strides": len(group),
                    "range of motion": mean["range_reference"],
                    "its error": mean["range_error"],
                    "its SD": spread["range_error"],
                    "error in %": 100.0 * mean["range_error"] / mean["range_reference"],
                    "highest angle, error": mean["maximum_error"],
                    "SD (highest)": spread["maximum_error"],
                    "lowest angle, error": mean["minimum_error"],
                    "SD (lowest)": spread["minimum_error"],
                    "RMSE in % of range": 100.0 * mean["rmse"] / mean["range_reference"],
                }
            )
    frame = pd.DataFrame(rows).set_index(["Axis", "Method"])
    return Table(
        f"{title}: range of motion and peaks per stride (degrees)",
        frame,
        note="Means over subjects; SD over the strides of a subject. Strides from foot contact to "
        "foot contact without a missing sample.",
    )


def reliability_table(strides: pd.DataFrame, title: str) -> Table | None:
    """Tabulate the agreement of each walk's mean range of motion with the reference.

    Parameters
    ----------
    strides : pandas.DataFrame
        From `narx.evaluation.strides.stride_table`, of joints or segments of one kind.
    title : str
        Joint or segment, for the title.

    Returns
    -------
    Table or None
        One row per axis and method; None with fewer than five walks.
    """
    keys = ["dataset", "subject", "condition", "trial", "segment", "axis", "method"]
    walks = strides.groupby(keys, sort=False)[["range_reference", "range_estimate"]].mean()
    rows = []
    for axis in AXES:
        part = walks[walks.index.get_level_values("axis") == axis]
        for method, group in part.groupby("method", sort=False):
            found = reliability(
                group["range_reference"].to_numpy(), group["range_estimate"].to_numpy()
            )
            if found is None:
                continue
            rows.append(
                {
                    "Axis": axis,
                    "Method": method_label(str(method)),
                    "walks": found.n,
                    "ICC(2,1)": found.icc_2_1,
                    "95 % interval of ICC(2,1)": _interval(found.icc_2_1_interval),
                    "ICC(3,1)": found.icc_3_1,
                    "95 % interval of ICC(3,1)": _interval(found.icc_3_1_interval),
                    "SEM": found.sem,
                    "MDC": found.mdc,
                }
            )
    if not rows:
        return None
    return Table(
        f"{title}: reliability of the range of motion of a walk against the reference",
        pd.DataFrame(rows).set_index(["Axis", "Method"]),
        decimals={"ICC(2,1)": 2, "ICC(3,1)": 2, "SEM": 2, "MDC": 2},
        note="A target is the mean over strides of one leg in one walk. SEM and minimal detectable "
        "change (95 %) in degrees.",
    )


def cycle_table(sets: Sequence[StrideSet], methods: Sequence[str], title: str) -> Table | None:
    """Test where in the cycle a method differs from the reference (SPM1D, paired by subject).

    Parameters
    ----------
    sets : sequence of StrideSet
        Of joints or segments of one kind.
    methods : sequence of str
        Methods to test.
    title : str
        Joint or segment, for the title.

    Returns
    -------
    Table or None
        One row per axis and method; None with fewer than three subjects.
    """
    rows = []
    for axis, name in enumerate(AXES):
        for method in methods:
            found = waveform_test(*mean_waveforms(sets, method, axis))
            if found is None:
                continue
            rows.append(
                {
                    "Axis": name,
                    "Method": method_label(method),
                    "subjects": found.n_subjects,
                    "differs over, % of the cycle": found.share_percent,
                    "where (%)": ", ".join(f"{b:.0f}-{e:.0f}" for b, e, _ in found.clusters),
                    "smallest p": min((p for *_, p in found.clusters), default=np.nan),
                    "largest mean difference": found.largest_difference_deg,
                }
            )
    if not rows:
        return None
    return Table(
        f"{title}: where the mean waveform differs from the reference (SPM1D paired t, 5 %)",
        pd.DataFrame(rows).set_index(["Axis", "Method"]),
        decimals={"differs over, % of the cycle": 0, "smallest p": 3},
        note="With few subjects only large and consistent differences are found: no difference "
        "found is not agreement. Differences in degrees.",
    )


def _interval(bounds: tuple[float, float]) -> str:
    return f"{bounds[0]:.2f} to {bounds[1]:.2f}"
