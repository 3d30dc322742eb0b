"""Growth of the error during a long walk."""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.evaluation.drift import drift_test
from narx.evaluation.significance import bootstrap_mean
from narx.experiments.method_labels import method_label, method_order
from narx.experiments.tables.table import Table
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of


def drift_table(
    evaluated: Iterable[Evaluated],
    methods: Sequence[str],
    window_s: float = 300.0,
    shortest_s: float = 1200.0,
    seed: int = 0,
) -> Table | None:
    """RMSE of the last minutes compared with the first, over subjects.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Trials.
    methods : sequence of str
        Methods to tabulate.
    window_s : float
        Length of the first and of the last window, s.
    shortest_s : float
        Shorter trials are left out, s.
    seed : int
        Seed of the bootstrap.

    Returns
    -------
    Table or None
        One row per kind of segment, axis and method; None if no trial is long enough.
    """
    rows = [
        row for one in evaluated if _lasts(one, shortest_s) for row in _rows(one, methods, window_s)
    ]
    if not rows:
        return None
    angles = pd.DataFrame(rows)
    shown = []
    for (segment, axis, method), here in angles.groupby(["Segment", "Axis", "Method"], sort=False):
        # both legs and all trials are averaged within a person first
        people = here.groupby("person", sort=False)[["first", "last", "change"]].mean()
        change = bootstrap_mean(people["change"], seed=seed)
        shown.append(
            {
                "Segment": segment,
                "Axis": axis,
                "Method": method_label(str(method)),
                "subjects": len(people),
                "first": people["first"].mean(),
                "last": people["last"].mean(),
                "change": change.mean,
                "low": change.low,
                "high": change.high,
                "grows": f"{here['grows'].sum()} of {len(here)}",
                "shrinks": f"{here['shrinks'].sum()} of {len(here)}",
            }
        )
    table = pd.DataFrame(shown)
    table["order"] = table["Axis"].map(AXES.index)
    minutes = f"{window_s / 60.0:g}"
    return Table(
        f"Drift: RMSE (°) in the first and the last {minutes} minutes, over subjects",
        table.sort_values(["Segment", "order"], kind="stable")
        .drop(columns="order")
        .set_index(["Segment", "Axis", "Method"]),
        dict.fromkeys(("first", "last", "change", "low", "high"), 2),
        f"Trials of {shortest_s / 60.0:g} minutes or more. change: mean RMSE of blocks of 10 s, "
        "last minus first; low and high: its 95 % interval, expanded percentile bootstrap over "
        "subjects. grows, shrinks: single angles whose change is significant at 5 % (by chance "
        "2.5 % in each), against the scatter of all windows about a straight line.",
    )


def _lasts(one: Evaluated, shortest_s: float) -> bool:
    return len(one.time_s) / one.sampling_rate_hz >= shortest_s


def _rows(one: Evaluated, methods: Sequence[str], window_s: float) -> Iterable[dict[str, object]]:
    time_s = one.time_s[one.scored]
    for method in method_order(set(methods) & set(one.estimates_rad)):
        error = np.deg2rad(one.error_deg(method)[one.scored])
        for axis, name in enumerate(AXES):
            if not np.isfinite(error[:, axis]).any():
                continue
            test = drift_test(time_s, error[:, axis], window_s)
            yield {
                "Segment": kind_of(one.segment),
                "Axis": name,
                "Method": method,
                "person": (one.dataset, one.subject),
                "first": test.first_deg,
                "last": test.last_deg,
                "change": test.change_deg,
                "grows": test.grows,
                "shrinks": test.p_value < 0.05 and not test.grows,
            }
