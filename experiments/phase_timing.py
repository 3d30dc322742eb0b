"""Gait phases from one thigh compared with the true events, for Tables 2 and 3."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from narx.gait.phases import PHASES, GaitPhases

# a point further than this from every true event is not matched
LARGEST_ERROR_S = 0.3

# what ends or begins the phases by definition (Perry, Gait analysis, 1992): loading response ends
# when the other foot leaves the ground, terminal stance when it comes down; end of swing and end
# of mid stance (heel rise) are no events of a foot that leaves or touches
_OWN = {"b": "heel_strike", "f": "toe_off"}
_OTHER = {"c": "toe_off", "e": "heel_strike"}


def phase_shares(phases: GaitPhases) -> pd.DataFrame:
    """Length of every phase as a share of its stride.

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
        True times by event and foot: ``heel_strike_right``, ``toe_off_left``, ...; an event that
        is not in it is not compared.
    side : {"left", "right"}
        Of the thigh.
    start_s : float
        Time of the first sample on the clock of the events, s.

    Returns
    -------
    pandas.DataFrame
        Columns ``point`` and ``error_s`` (detected less true), a row a detected point: ``b``
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
