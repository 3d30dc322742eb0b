"""Coverage of predicted standard deviations."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.evaluation.uncertainty import calibration
from narx.experiments.method_labels import method_label
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of


def coverage_table(evaluated: Iterable[Evaluated]) -> Table | None:
    """Share of errors within the predicted 68 and 95 % bands.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Trials, some with predicted standard deviations.

    Returns
    -------
    Table or None
        One row per kind of segment, axis, condition and method, all its trials together, and the
        range of single trials; None without predictions.
    """
    errors: dict[tuple[str, str, str, str], list[tuple[np.ndarray, np.ndarray]]] = {}
    for one in evaluated:
        for method, std in one.std_rad.items():
            error = np.deg2rad(one.error_deg(method))
            for axis, name in enumerate(AXES):
                key = kind_of(one.segment), name, one.condition, method
                errors.setdefault(key, []).append((error[:, axis], std[:, axis]))
    rows = []
    for (segment, axis_name, condition, method), pairs in errors.items():
        result = calibration(*(np.concatenate(column) for column in zip(*pairs, strict=True)))
        if not result.n_samples:
            continue
        single = [one for one in (calibration(*pair) for pair in pairs) if one.n_samples]
        row = {
            "Segment": segment,
            "Axis": axis_name,
            "Condition": condition,
            "Method": method_label(method),
            "trials": len(single),
        }
        for level, field in ((68, "coverage_68"), (95, "coverage_95")):
            shares = [100 * getattr(one, field) for one in single]
            row[f"within {level} % band"] = 100 * getattr(result, field)
            row[f"trials, {level} %"] = f"{min(shares):.0f} to {max(shares):.0f}"
        row["predicted SD (°)"] = result.sharpness_deg
        row["factor needed"] = result.scale
        rows.append(row)
    if not rows:
        return None
    return Table(
        "Share of errors (%) within the predicted bands",
        pd.DataFrame(rows).set_index(["Segment", "Axis", "Condition", "Method"]),
        {"trials": 0, "predicted SD (°)": 2, "factor needed": 2},
        "A calibrated SD gives 68, 95 and a factor of 1; a factor above 1 means overconfidence. "
        "The errors of a trial share its posture, so single trials differ from their mean.",
    )
