"""Does the error grow over a long walk, and does a predicted standard deviation hold."""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from experiments.evaluated import Evaluated
from experiments.method_labels import method_label, method_order
from experiments.tables.table import Table
from narx.drift import drift_test
from narx.recording import kind_of
from narx.segment_angles import AXES
from narx.uncertainty import calibration


def drift_table(
    evaluated: Iterable[Evaluated], methods: Sequence[str], window_s: float = 300.0
) -> Table | None:
    """RMSE of the last minutes beside that of the first, for walks that have both.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Trials; those shorter than twice the window are left out.
    methods : sequence of str
        Which methods.
    window_s : float
        Length of the first and of the last window, s.

    Returns
    -------
    Table or None
        A row a trial, axis and method; None where no walk is long enough.
    """
    rows = []
    for one in evaluated:
        time_s = one.time_s[one.scored]
        if not len(time_s) or time_s[-1] - time_s[0] < 2 * window_s:
            continue
        for method in method_order(set(methods) & set(one.estimates_rad)):
            error = np.deg2rad(one.error_deg(method)[one.scored])
            for axis, name in enumerate(AXES):
                if not np.isfinite(error[:, axis]).any():
                    continue
                test = drift_test(time_s, error[:, axis], window_s)
                rows.append(
                    {
                        "Walk": f"{one.subject} {one.condition} {one.segment}",
                        "Axis": name,
                        "Method": method_label(method),
                        "minutes": (time_s[-1] - time_s[0]) / 60.0,
                        "first": test.first_deg,
                        "last": test.last_deg,
                        "change": test.change_deg,
                        "95 % low": test.low_deg,
                        "95 % high": test.high_deg,
                        "p": test.p_value,
                    }
                )
    if not rows:
        return None
    return Table(
        f"RMSE (°) in the first and the last {window_s / 60.0:g} minutes",
        pd.DataFrame(rows).set_index(["Walk", "Axis", "Method"]),
        dict.fromkeys(("first", "last", "change", "95 % low", "95 % high"), 2)
        | {"p": 3, "minutes": 0},
        "Welch's t test between blocks of 10 s, their autocorrelation taken into account.",
    )


def coverage_table(evaluated: Iterable[Evaluated]) -> Table | None:
    """How often the error stays within the predicted 68 and 95 % bands.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Trials, some with predicted standard deviations.

    Returns
    -------
    Table or None
        A row a kind of segment, axis and method, all trials together; None without predictions.
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
        "Calibrated is 68, 95 and a factor of 1; a factor above 1 says the prediction is too sure.",
    )
