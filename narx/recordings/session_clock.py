"""Align the clocks of a session's sensors by their stamps, common movement, or a common event."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.signal import butter, correlate, correlation_lags, sosfiltfilt

from narx.errors import RecordingError, UserError
from narx.recordings.trial import ImuRecording
from narx.types import FloatArray

Alignment = Literal["auto", "stamps", "correlation"]
BY_STAMPS = "sensors aligned by their time stamps"

_RATE_HZ = 100.0
# thigh and shank do not turn at the same time, but walk and stand together
_SMOOTH_HZ = 1.0
_MIN_CORRELATION = 0.5
# the shock of a foot contact reaches the whole leg within milliseconds
_SHOCK_HZ = 15.0
_SHOCK_WINDOW_S = 0.3
_MIN_SHOCK_CORRELATION = 0.3
_MIN_OVERLAP = 0.5
# A larger disagreement between time stamps and movement is reported; it is certain if the sensors
# move together with the other offset, and clearly less with the stamps. A steady walk correlates
# nearly as well some strides apart.
_DOUBT_S = 1.5
_CERTAIN_CORRELATION, _CERTAIN_MARGIN = 0.8, 0.3


def clock_offsets_s(
    recordings: Mapping[str, ImuRecording], align: Alignment | Mapping[str, float], where: str
) -> tuple[dict[str, float], list[str]]:
    """Find the offset of each sensor's clock, so that all share the clock of the first.

    Parameters
    ----------
    recordings : mapping of str to ImuRecording
        Recording of each segment; the first gives the clock.
    align : {"auto", "stamps", "correlation"}, or mapping of str to float
        ``stamps`` uses the time stamps; ``correlation`` finds the lag at which the sensors move
        together; ``auto`` uses the time stamps if they overlap. A mapping gives the time of one
        event, such as a tap on all sensors, on the own clock of each, s.
    where : str
        Name of the session, for messages.

    Returns
    -------
    offsets_s : dict of str to float
        Offset to add to the times of each segment, s.
    notes : list of str
        Method used, as text.

    Raises
    ------
    UserError
        If the choice is unknown, or the event is not given for every sensor, within its recording.
    RecordingError
        If the sensors do not move together; with ``auto``, also if their movement certainly
        contradicts their time stamps.

    Notes
    -----
    The lag is that of the smoothed angular speeds (below 1 Hz: walking and standing), refined, if
    both accelerometers register the foot contacts (above 15 Hz), to that of the shocks within
    0.3 s of it. It is accurate to 2 ms on simulated walks and to 60 ms on the one recorded pair of
    sensors with known clocks; time stamps of one clock are more accurate.
    """
    if isinstance(align, Mapping):
        return _by_event(recordings, align, where)
    if align not in get_args(Alignment):
        raise UserError(f"align is '{align}', expected one of {', '.join(get_args(Alignment))}")
    first, *others = recordings
    offsets = {first: 0.0}
    if not others:
        return offsets, []
    if align == "stamps" or (align == "auto" and _overlap(recordings) >= _MIN_OVERLAP):
        offsets |= dict.fromkeys(others, 0.0)
        doubts = _doubts(recordings, offsets, where if align == "auto" else None)
        return offsets, [BY_STAMPS, *doubts]
    notes = []
    for segment in others:
        lag = _lag_s(recordings[first], recordings[segment])
        if lag is None:
            raise RecordingError(
                f"{where}: '{first}' and '{segment}' do not move together, so their clocks cannot "
                "be aligned; expected recordings of the same walk with its begin or end"
            )
        offsets[segment] = lag.offset_s
        notes.append(f"'{segment}' moved by {lag.offset_s:+.3f} s, by {lag.how}")
    return offsets, notes


def _by_event(
    recordings: Mapping[str, ImuRecording], event_s: Mapping[str, float], where: str
) -> tuple[dict[str, float], list[str]]:
    if set(event_s) != set(recordings):
        raise UserError(
            f"align has an event for {', '.join(sorted(event_s)) or 'no sensor'}, expected one for "
            f"each of {', '.join(sorted(recordings))}"
        )
    for segment, one in recordings.items():
        begin, end = float(one.time_s[0]), float(one.time_s[-1])
        if not begin <= event_s[segment] <= end:
            raise UserError(
                f"{where}: align.{segment} is {event_s[segment]:g}, expected a time within its "
                f"recording, {begin:.2f} to {end:.2f} s"
            )
    first = event_s[next(iter(recordings))]
    offsets = {segment: first - event_s[segment] for segment in recordings}
    moved = ", ".join(f"'{s}' moved by {offset:+.3f} s" for s, offset in offsets.items() if offset)
    note = "sensors aligned by the given event" + (f": {moved}" if moved else "")
    return offsets, [note, *_doubts(recordings, offsets)]


def _doubts(
    recordings: Mapping[str, ImuRecording],
    offsets: Mapping[str, float],
    refusing: str | None = None,
) -> list[str]:
    """Report sensors that do not move together with these offsets.

    What is certain is refused, if the name of a session is given.
    """
    first, *others = recordings
    notes = []
    for segment in others:
        lag = _lag_s(recordings[first], recordings[segment], offsets[segment])
        apart_s = 0.0 if lag is None else abs(lag.offset_s - offsets[segment])
        if lag is None or apart_s <= _DOUBT_S:
            continue
        apart = f"by their movement '{first}' and '{segment}' are {apart_s:.2f} s apart"
        if refusing is not None and lag.is_certain:
            raise RecordingError(
                f"{refusing}: {apart}, but not by their time stamps; align=correlation uses the "
                "movement, align=stamps the stamps"
            )
        notes.append(f"{apart} (align=correlation to use this)")
    return notes


def _overlap(recordings: Mapping[str, ImuRecording]) -> float:
    begin = max(one.time_s[0] for one in recordings.values())
    end = min(one.time_s[-1] for one in recordings.values())
    shortest = min(one.time_s[-1] - one.time_s[0] for one in recordings.values())
    return float((end - begin) / shortest)


@dataclass(frozen=True)
class _Lag:
    """Offset to add to another recording's times, how it was found, and how sure it is."""

    offset_s: float
    how: str
    is_certain: bool


def _lag_s(one: ImuRecording, other: ImuRecording, instead_of_s: float = 0.0) -> _Lag | None:
    """Find the offset of another recording; certain if it is clearly better than another one."""
    begin = one.time_s[0], other.time_s[0]
    speeds = [_on_grid(r, np.linalg.norm(r.gyroscope_rad_s, axis=1)) for r in (one, other)]
    if min(map(len, speeds)) < 2 * _RATE_HZ:
        return None
    smooth = butter(2, _SMOOTH_HZ, fs=_RATE_HZ, output="sos")
    slow, slow_other = (sosfiltfilt(smooth, speed) for speed in speeds)
    coarse = _best_lag(slow, slow_other)
    if coarse is None or coarse[1] < _MIN_CORRELATION:
        return None
    given = _best_lag(slow, slow_other, around_s=instead_of_s - float(begin[0] - begin[1]))
    is_certain = coarse[1] > _CERTAIN_CORRELATION and (
        given is None or given[1] < coarse[1] - _CERTAIN_MARGIN
    )
    lag_s, how = coarse[0], "their angular speeds (to some 200 ms)"
    shocks = [_shocks(recording) for recording in (one, other)]
    if shocks[0] is not None and shocks[1] is not None:
        fine = _best_lag(shocks[0], shocks[1], around_s=coarse[0])
        if fine is not None and fine[1] > _MIN_SHOCK_CORRELATION:
            lag_s, how = fine[0], "the shocks of foot contacts (to some 50 ms)"
    return _Lag(float(begin[0] - begin[1] + lag_s), how, is_certain)


def _on_grid(recording: ImuRecording, values: FloatArray) -> FloatArray:
    there = np.isfinite(values)
    if there.sum() < 2:
        return np.empty(0)
    grid = np.arange(recording.time_s[0], recording.time_s[-1], 1.0 / _RATE_HZ)
    return np.interp(grid, recording.time_s[there], values[there])


def _shocks(recording: ImuRecording) -> FloatArray | None:
    if recording.sampling_rate_hz < 3 * _SHOCK_HZ:
        return None
    size = _on_grid(recording, np.linalg.norm(recording.accelerometer_m_s2, axis=1))
    if len(size) < 2 * _RATE_HZ:
        return None
    high = butter(2, _SHOCK_HZ, "highpass", fs=_RATE_HZ, output="sos")
    return np.abs(sosfiltfilt(high, size))


def _best_lag(
    one: FloatArray, other: FloatArray, around_s: float | None = None
) -> tuple[float, float] | None:
    """Return the lag of the second signal, s, and the correlation at this lag."""
    a, b = one - one.mean(), other - other.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    if size == 0:
        return None
    correlation = correlate(a, b) / size
    lags = correlation_lags(len(a), len(b)) / _RATE_HZ
    if around_s is not None:
        correlation = np.where(np.abs(lags - around_s) < _SHOCK_WINDOW_S, correlation, -1.0)
    best = int(np.argmax(correlation))
    step = 0.0
    if 0 < best < len(lags) - 1:
        left, peak, right = correlation[best - 1 : best + 2]
        bend = left - 2 * peak + right
        step = 0.5 * (left - right) / bend if bend < 0 else 0.0
    return float(lags[best] + np.clip(step, -0.5, 0.5) / _RATE_HZ), float(correlation[best])
