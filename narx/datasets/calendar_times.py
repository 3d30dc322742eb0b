"""Times of day in text: ISO 8601, or with a date in any order before or after them."""

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from narx.types import FloatArray

_DAY_S = 86_400.0
_OF_THE_HOUR = re.compile(r"\s*(\d{1,3}):([0-5]?\d[.,]\d+)\s*")
_TIME_OF_DAY = re.compile(
    r"(?<!\d)([01]?\d|2[0-3]):([0-5]\d):([0-5]\d(?:[.,:]\d+)?)\s*([AaPp]\.?[Mm]\.?)?(?![\d:])"
)


def seconds_of(cells: Sequence[str]) -> FloatArray:
    """Convert dates and times to seconds from the first.

    Parameters
    ----------
    cells : sequence of str
        ISO 8601, with or without a zone; or texts with a time such as ``22:13:20.04`` or
        ``10:13:20,04 PM``, and a date of any form; or minutes and seconds with decimals, all of
        them, such as ``13:20.04``, which begin again at the hour.

    Returns
    -------
    ndarray, shape (N,)
        Seconds; NaN where a cell has neither form.

    Notes
    -----
    Without ISO 8601 the order of day and month is unknown, so the date is only compared with that
    of the previous row: the time of day begins again at midnight. A recording that leaves out more
    than a day is therefore not converted (NaN).
    """
    stamps = pd.to_datetime(pd.Series(cells), format="ISO8601", utc=True, errors="coerce")
    if re.match(r"\s*\d{4}", cells[0]) and stamps.notna().iloc[0]:
        return np.asarray((stamps - stamps.iloc[0]).dt.total_seconds(), dtype=np.float64)
    if all(of_hour := [_OF_THE_HOUR.fullmatch(cell) for cell in cells]):
        pairs = [(match[1], match[2].replace(",", ".")) for match in of_hour if match]
        of_hour_s = np.array([60.0 * int(minutes) + float(seconds) for minutes, seconds in pairs])
        return of_hour_s - of_hour_s[0]
    of_day = np.full(len(cells), np.nan)
    dates = []
    for row, cell in enumerate(cells):
        match = _TIME_OF_DAY.search(cell)
        dates.append(cell[: match.start()] + cell[match.end() :] if match else "")
        if match is None:
            continue
        hours = int(match[1])
        if match[4]:
            hours = hours % 12 + 12 * (match[4][0] in "Pp")
        # some write the milliseconds behind a third colon
        of_day[row] = 3600.0 * hours + 60.0 * int(match[2]) + float(re.sub("[,:]", ".", match[3]))
    midnights = np.r_[False, np.diff(of_day) < -0.5 * _DAY_S]
    changes = np.r_[False, np.array(dates[1:], dtype=object) != np.array(dates[:-1], dtype=object)]
    if any(map(str.strip, dates)) and (changes != midnights).any():
        return np.where(changes != midnights, np.nan, of_day)
    return of_day - of_day[0] + np.cumsum(midnights) * _DAY_S
