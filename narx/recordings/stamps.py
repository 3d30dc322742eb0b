"""Conversion of a file's time stamps to sampling times.

A stamp is often not the sampling time, but the arrival time of the packet, or a rounded time. If
the samples are regular and the stamps are not, a line through the stamps is the better clock. The
one on which the signal is smoother is chosen.
"""

from dataclasses import dataclass

import numpy as np

from narx.errors import RecordingError, UserError
from narx.recordings.arrival import regular_clock
from narx.types import BoolArray, FloatArray, IntArray

# a lower rate does not resolve a stride; no inertial sensor has a higher rate
MIN_RATE_HZ, MAX_RATE_HZ = 5.0, 20_000.0
# intervals this close to multiples of the median form a regular clock, possibly with lost samples
_REGULAR = 0.1
_REGULAR_SHARE = 0.98
# a regular clock loses less than half of its samples, apart from pauses
_MOSTLY_THERE, _PAUSE_S = 2.0, 0.5
# largest share of rows repeating the previous row's stamp that is treated as a logger fault
_RARE = 0.05
# fewer samples are too few to judge the fit of a line
_MIN_SAMPLES = 20
# the signal must be clearly smoother on the line
_SMOOTHER = 0.7
# intervals between stamps that are this much shorter than the mean one are those of arrival
_ARRIVAL = 0.1
# stamps this close are one; the age of the universe in microseconds is less than the other
_SAME_S, _MAX_TIME_S = 1e-9, 1e24
# times of day and of the hour; counters of 16 to 32 bits in ms, us and ns
_PERIODS_S = (
    86400.0,
    3600.0,
    *(
        2.0**bits * unit
        for unit, *sizes in ((1e-3, 16, 24, 32), (1e-6, 24, 31, 32), (1e-9, 32))
        for bits in sizes
    ),
)
# largest step across such a beginning, in intervals
_MOST_INTERVALS = 5.0
_UNITS = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}
_LONG_UNITS = {60.0: "minutes", 3600.0: "hours", 86400.0: "days"}


@dataclass(frozen=True)
class SamplingTimes:
    """Increasing sampling times, and the corresponding rows.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Increasing, s.
    rows : ndarray of int, shape (n,)
        Row of the file of each, from 0.
    notes : tuple of str
        Processing applied, as text.
    """

    time_s: FloatArray
    rows: IntArray
    notes: tuple[str, ...] = ()


def checked_rate_hz(value: object, what: str) -> float:
    """Refuse an implausible sampling rate of an inertial sensor on a person.

    Parameters
    ----------
    value : object
        Samples per second.
    what : str
        Source of the value, for messages.

    Returns
    -------
    float
        The rate.

    Raises
    ------
    UserError
        If it is not a number between 5 and 20000; the message suggests an interval where it looks
        like one.
    """
    try:
        rate = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        rate = np.nan
    if isinstance(value, bool) or not np.isfinite(rate) or rate <= 0:
        found = " ".join(str(value).split())[:60]  # an array has lines
        raise UserError(f"{what} is {found}, expected a positive number")
    if not MIN_RATE_HZ <= rate <= MAX_RATE_HZ:
        hint = f"; {1 / rate:g} Hz, if it is the interval in s" if rate < 0.2 else ""
        raise UserError(
            f"{what} is {value}, expected {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g} samples a second{hint}"
        )
    return rate


def sampling_times(time_s: FloatArray, values: FloatArray, where: str) -> SamplingTimes:
    """Determine the sampling times.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Stamps as in the file, s.
    values : ndarray, shape (N, K)
        Samples; NaN where missing.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    SamplingTimes
        The stamps themselves, if they are regular or the signal is smooth on them; else sorted
        stamps, or a regular clock.

    Raises
    ------
    RecordingError
        If a stamp is missing, the rate is not that of an inertial sensor in s, or time does not
        increase and no regular clock explains it.

    Notes
    -----
    Complete duplicates of the previous row are left out. Packet times are set so that the fastest
    packet has no delay; stamps in steps are treated as truncated; others get a least-squares line.
    The choice between stamps and line is by the error of cubic interpolation of each sample from
    its four neighbours.
    """
    missing = np.flatnonzero(~np.isfinite(time_s))
    if missing.size:
        raise RecordingError(f"{where}: the time is missing at data row {missing[0] + 1}")
    impossible = np.flatnonzero(np.abs(time_s) > _MAX_TIME_S)
    if impossible.size:
        raise RecordingError(
            f"{where}: the time is {time_s[impossible[0]]:g} s at data row {impossible[0] + 1}"
        )
    rows = np.arange(len(time_s))
    notes: list[str] = []
    if len(rows) < 2:
        return SamplingTimes(time_s, rows)
    if (np.diff(time_s) < _PAUSE_S).all() and _is_regular(time_s):
        _check_rate(time_s, where)
        return SamplingTimes(time_s, rows)
    time_s, period_s = _continued(time_s)
    if period_s:
        notes.append(f"time begins again after {period_s:.10g} s, continued from there")
    repeated = np.zeros(len(rows), dtype=bool)
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    at_once = np.diff(time_s) == 0
    # if whole packets share a stamp, a sensor at rest also repeats its values
    if at_once.mean() < _RARE:
        repeated[1:] = at_once & same.all(axis=1)
    # with jitter, equal stamps at rest are those of two samples
    if repeated.any() and not _is_regular(time_s[~repeated]):
        repeated &= regular_clock(time_s)[0] is None
    if repeated.any():
        rows = rows[~repeated]
        notes.append(
            f"{repeated.sum()} rows that repeat their predecessor left out, the first at data row "
            f"{np.flatnonzero(repeated)[0] + 1}"
        )
    time = time_s[rows]
    _check_rate(time, where)
    order = np.argsort(time, kind="stable")
    twice = _twice(time[order], values[rows][order])
    if twice.any() and _is_regular(time[order][~twice]):
        # rows sent or logged again
        once = order[~twice]
        notes.append(f"{twice.sum()} rows that occur twice left out")
        return SamplingTimes(time[once], rows[once], tuple(notes))
    disordered = bool((np.diff(time) < 0).any())
    # halves of a recording in the wrong order, or a counter that began again, leave a gap
    closed = np.diff(time[order]).max() <= 1.5 * np.diff(time).max()
    if disordered and closed and _is_regular(time[order]):
        moved = int((order != np.arange(len(order))).sum())
        notes.append(f"{moved} rows were out of order and are put in the order of their times")
        return SamplingTimes(time[order], rows[order], tuple(notes))
    if _is_regular(time):
        return SamplingTimes(time, rows, tuple(notes))
    clock, how = regular_clock(time) if len(time) >= _MIN_SAMPLES else (None, "")
    increasing = bool((np.diff(time) > _SAME_S).all())
    signal = values[rows]
    if clock is not None:
        off_line = _roughness(clock, signal)
        if not increasing or off_line < _SMOOTHER * _roughness(time, signal):
            return SamplingTimes(clock, rows, (*notes, how))
    if not increasing:
        wrong = int(np.flatnonzero(np.diff(time) <= _SAME_S)[0]) + 1
        raise RecordingError(
            f"{where}: time_s does not increase at data row {rows[wrong] + 1} "
            f"({time[wrong - 1]:g} s, then {time[wrong]:g} s)"
        )
    steps = np.diff(time)
    pauseless = steps[steps < _PAUSE_S]
    if clock is None and np.median(steps) < _ARRIVAL * np.mean(pauseless):
        raise RecordingError(
            f"{where}: most stamps are {np.median(steps):.3g} s apart, {np.mean(pauseless):.3g} s "
            "on average, as if taken at arrival, and no regular clock explains them"
        )
    return SamplingTimes(time, rows, tuple(notes))


def _continued(time_s: FloatArray) -> tuple[FloatArray, float]:
    """Continue a time of day or a counter that began again; 0 as its period if none did."""
    steps = np.diff(time_s)
    back = steps < 0
    interval = float(np.median(steps))
    if interval <= 0 or not back.any() or back.mean() > _RARE:
        return time_s, 0.0
    for period_s in _PERIODS_S:
        onward = steps[back] + period_s
        if (onward > 0).all() and (onward < _MOST_INTERVALS * interval).all():
            return time_s + np.r_[0.0, np.cumsum(back)] * period_s, period_s
    return time_s, 0.0


def _twice(time: FloatArray, values: FloatArray) -> BoolArray:
    """Rows with the same stamp and values as the previous one, in the order of the stamps."""
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    return np.r_[False, (np.diff(time) == 0) & same.all(axis=1)]


def _check_rate(time: FloatArray, where: str) -> None:
    steps = np.diff(time)
    forward = steps[steps > 0]
    if not forward.size:
        raise RecordingError(f"{where}: time_s never increases (stays at {time[0]:g} s)")
    # whole packets may share a stamp
    step = min(float(np.median(forward)), float((time[-1] - time[0]) / len(steps)) or np.inf)
    if step > 1.0 / MIN_RATE_HZ:
        likely = [
            name for factor, name in _UNITS.items() if MIN_RATE_HZ < 1 / (step * factor) < 5000
        ]
        raise RecordingError(
            f"{where}: time_s steps by {step:g} s ({1 / step:.3g} Hz); "
            + (f"{likely[0]}? " if likely else "")
            + f"Expected s, at {MIN_RATE_HZ:g} Hz or more"
        )
    mean = float(forward.sum() / len(steps))
    if mean < 1.0 / MAX_RATE_HZ:
        likely = [
            name for factor, name in _LONG_UNITS.items() if MIN_RATE_HZ < 1 / (mean * factor) < 1000
        ]
        raise RecordingError(
            f"{where}: time_s steps by {mean:g} s ({1 / mean:.3g} Hz); "
            + (f"{likely[0]}? " if likely else "")
            + f"Expected s, at {MAX_RATE_HZ:g} Hz or less"
        )


def _is_regular(time: FloatArray) -> bool:
    steps = np.diff(time)
    interval = float(np.median(steps))
    if not (steps > _SAME_S).all() or interval <= 0:
        return False
    multiples = steps / interval
    # packets: samples at a short interval, each followed by a long interval
    if np.mean(steps[steps < _PAUSE_S]) > _MOSTLY_THERE * interval:
        return False
    near = np.abs(multiples - np.maximum(1.0, np.round(multiples))) < _REGULAR
    return bool(np.mean(near) >= _REGULAR_SHARE)


def _roughness(time: FloatArray, values: FloatArray) -> float:
    """Error of interpolating each sample from its neighbours, the largest per cent left out."""
    neighbours = [time[k : len(time) - 4 + k] for k in (0, 1, 3, 4)]
    here = time[2:-2]
    spacing = np.diff(time)
    if not (spacing > 0).all():
        return np.inf
    predicted = np.zeros((len(here), values.shape[1]))
    for k, own in zip((0, 1, 3, 4), neighbours, strict=True):
        weight = np.ones(len(here))
        for other in neighbours:
            if other is not own:
                weight *= (here - other) / (own - other)
        predicted += weight[:, None] * values[k : len(time) - 4 + k]
    error = np.linalg.norm(values[2:-2] - predicted, axis=1)
    error = error[np.isfinite(error)]
    if not error.size:
        return 0.0
    return float(np.sqrt(np.mean(np.minimum(error, np.quantile(error, 0.99)) ** 2)))
