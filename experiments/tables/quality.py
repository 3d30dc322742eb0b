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
        One row per kind of segment, axis and method, all trials together; None without predictions.
    """
    errors: dict[tuple[str, str, str], list[tuple[np.ndarray, np.ndarray]]] = {}
    for one in evaluated:
        for method, std in one.std_rad.items():
            error = np.deg2rad(one.error_deg(method))
            for axis, name in enumerate(AXES):
                key = kind_of(one.segment), name, method
                errors.setdefault(key, []).append((error[:, axis], std[:, axis]))
    rows = []
    for (segment, axis_name, method), pairs in errors.items():
        result = calibration(*(np.concatenate(column) for column in zip(*pairs, strict=True)))
        if result.n_samples:
            rows.append(
                {
                    "Segment": segment,
                    "Axis": axis_name,
                    "Method": method_label(method),
                    "within 68 % band": 100 * result.coverage_68,
                    "within 95 % band": 100 * result.coverage_95,
                    "predicted SD (°)": result.sharpness_deg,
                    "factor needed": result.scale,
                }
            )
    if not rows:
        return None
    return Table(
        "Share of errors (%) within the predicted bands",
        pd.DataFrame(rows).set_index(["Segment", "Axis", "Method"]),
        {"predicted SD (°)": 2, "factor needed": 2},
        "A calibrated SD gives 68, 95 and a factor of 1; a factor above 1 means overconfidence.",
    )
