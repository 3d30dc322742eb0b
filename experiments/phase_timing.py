"""Compare the gait phases detected on one thigh with the true events, for Tables 2 and 3."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from narx.gait.phases import PHASES, GaitPhases

# a detected point further than this from every true event is not matched
LARGEST_ERROR_S = 0.3

# events that delimit the phases (Perry, Gait analysis, 1992): loading response ends at the other
# foot's toe-off, terminal stance at its heel strike; the end of swing and the end of mid stance
# (heel rise) coincide with neither a heel strike nor a toe-off
_OWN = {"b": "heel_strike", "f": "toe_off"}
_OTHER = {"c": "toe_off", "e": "heel_strike"}


def phase_shares(phases: GaitPhases) -> pd.DataFrame:
    """Duration of every phase as a share of its stride.

    Parameters
    ----------
    phases : GaitPhases
        Of one thigh.

    Returns
    -------
    pandas.DataFrame
        Columns ``phase`` (``b–c`` to ``f–g``, as printed) and ``share`` (of the time from b to
        g), one row per stride and phase; NaN where a point was not found.
    """
    times = phases.times_s
    stride = times["g"] - times["b"]
    return pd.concat(
        [
            pd.DataFrame({"phase": f"{begin}–{end}", "share": (times[end] - times[begin]) / stride})
            for begin, end in PHASES.values()
        ],
        ignore_index=True,
    )


def event_errors(
    phases: GaitPhases, events_s: Mapping[str, ArrayLike], side: str, start_s: float = 0.0
) -> pd.DataFrame:
    """Match detected points with true events.

    Parameters
    ----------
    phases : GaitPhases
        Of one thigh, times from the first sample.
    events_s : mapping of str to array_like
        True times by event and foot: ``heel_strike_right``, ``toe_off_left``, ...; missing events
        are not compared.
    side : {"left", "right"}
        Side of the thigh.
    start_s : float
        Time of the first sample on the clock of the events, s.

    Returns
    -------
    pandas.DataFrame
        Columns ``point`` and ``error_s`` (detected minus true), one row per detected point: ``b``
        against the foot's own heel strike, ``c`` the other foot's toe-off, ``e`` the other foot's
        heel strike, ``f`` its own toe-off. NaN where no true event is within `LARGEST_ERROR_S`.
    """
    other = {"left": "right", "right": "left"}[side]
    truth = {point: f"{event}_{side}" for point, event in _OWN.items()}
    truth |= {point: f"{event}_{other}" for point, event in _OTHER.items()}
    tables = []
    for point in sorted(truth):
        found = phases.times_s[point]
        found = found[np.isfinite(found)] + start_s
        true = np.asarray(events_s.get(truth[point], ()), dtype=float)
        error = np.full(len(found), np.nan)
        if len(true) and len(found):
            nearest = true[np.argmin(np.abs(found[:, None] - true), axis=1)]
            error = found - nearest
            error[np.abs(error) > LARGEST_ERROR_S] = np.nan
        tables.append(pd.DataFrame({"point": point, "error_s": error}))
    return pd.concat(tables, ignore_index=True)
