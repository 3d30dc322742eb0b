"""Plausibility checks: implausible recordings are refused, single faults removed and noted."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from narx.errors import RecordingError
from narx.recordings.faults import (
    IMPOSSIBLE_RAD_S,
    repeats_of_a_slower_sensor,
    without_faults,
)
from narx.recordings.overflow import without_overflow
from narx.recordings.stamps import sampling_times
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording
from narx.types import FloatArray

# more samples than this beyond a gyroscope's range mean a wrong unit, fewer are faults
_IMPOSSIBLE_SHARE = 0.005
# as most samples may be missing
_CODE_SHARE = 0.5
# largest deviation of a leg's angle from its running mean over two seconds
_MAX_SWING_RAD = np.radians(180.0)
_SWING_WINDOW_S = 2.0
# any walking turns a sensor faster than this
_SLOW_RAD_S = np.radians(6.0)
_STRIDES_HZ = (0.4, 3.0)
# times in minutes have intervals below this, if the rate is above 7 Hz
_FAST_S = 1.0 / 400.0
# times in tenths of a second have intervals above this, if the rate is below 250 Hz
_SLOW_S = 1.0 / 25.0
_MAX_SLOW_SWING_RAD = np.radians(90.0)
_STRIDES_SHARE = 0.5
# above the 50 g measured on a shank and the range of any accelerometer
_IMPOSSIBLE_M_S2 = 1000.0 * GRAVITY_M_S2
# Several sensors in one table: rows some way apart are of one sensor, and much closer to each other
# than neighbouring rows. No leg returns to its rate within this time.
_INTERLEAVED_S, _INTERLEAVED_RATIO = 0.15, 4.0
_INTERLEAVED_RAD_S = np.radians(5.0)
_MOST_SENSORS = 8
# largest ratio of ticks of the clock to samples
_MAX_TICKS_PER_SAMPLE = 20
_MAX_TICKS = 5_000_000


def admit(recording: ImuRecording, where: str) -> ImuRecording:
    """Check a recording, and remove artefacts.

    Parameters
    ----------
    recording : ImuRecording
        Recording as read.
    where : str
        Its name, for messages.

    Returns
    -------
    ImuRecording
        Sampling times instead of time stamps, faults as NaN, and notes on all changes.

    Raises
    ------
    RecordingError
        If the rate, the clock, or the gyroscope's unit is implausible; the message is one line.
    """
    if recording.n_samples < 2:
        raise RecordingError(f"{where}: {recording.n_samples} samples, expected at least 2")
    times = sampling_times(recording.time_s, recording.gyroscope_rad_s, where)
    gyroscope = recording.gyroscope_rad_s[times.rows]
    there = gyroscope[np.isfinite(gyroscope).all(axis=1)]
    if len(there) < 2:
        raise RecordingError(f"{where}: no two gyroscope samples, expected a recording")
    if not there.any():
        raise RecordingError(
            f"{where}: the gyroscope is zero throughout, expected angular rates; was it off?"
        )
    force, force_notes = _without_impossible(recording.accelerometer_m_s2[times.rows])
    _check_size(times.time_s, where)
    _check_range(gyroscope, where)
    time = times.time_s
    _check_interleaved(time, gyroscope, where)
    notes = [*recording.notes, *times.notes, *force_notes]
    repeats = repeats_of_a_slower_sensor(gyroscope)
    if repeats is not None:
        notes.append(
            f"a slower sensor than the file's clock: {repeats.sum()} rows that repeat their "
            "predecessor left out"
        )
        if (~repeats).sum() < 2:
            raise RecordingError(
                f"{where}: the gyroscope has one value throughout, expected angular rates; has it "
                "stopped?"
            )
        time, gyroscope, force = time[~repeats], gyroscope[~repeats], force[~repeats]
    gyroscope, overflow = without_overflow(gyroscope, float(np.median(np.diff(time))), where)
    gyroscope, faults = without_faults(time, gyroscope)
    _check_minutes(time, gyroscope, where)
    _check_tenths(time, gyroscope, where)
    _check_unit(time, gyroscope, where)
    return replace(
        recording,
        time_s=time,
        gyroscope_rad_s=gyroscope,
        accelerometer_m_s2=force,
        notes=tuple(dict.fromkeys([*notes, *overflow, *faults])),
    )


def check_gravity(accelerometer_m_s2: FloatArray, where: str) -> None:
    """Refuse an accelerometer that does not measure gravity, with the likely cause.

    Parameters
    ----------
    accelerometer_m_s2 : ndarray, shape (N, 3)
        Specific force; rows with NaN are left out.
    where : str
        Name of the recording, for messages.

    Raises
    ------
    RecordingError
        If the median of its size is not between 0.6 and 1.7 g.
    """
    size = np.linalg.norm(accelerometer_m_s2, axis=1)
    size = size[np.isfinite(size)]
    if not size.size:
        return
    middle = float(np.median(size))
    if 0.6 * GRAVITY_M_S2 < middle < 1.7 * GRAVITY_M_S2:
        return
    guesses = {1.0: "g", 1e3: "mg or cm/s^2", GRAVITY_M_S2**2: "m/s^2, not g"}
    guess = next((unit for one, unit in guesses.items() if 0.7 * one < middle < 1.5 * one), None)
    if guess is None:
        guess = "gravity subtracted" if middle < 5.0 else "raw counts"
    raise RecordingError(
        f"{where}: the accelerometer's median size is {middle:.3g} m/s^2, expected about 9.8; "
        f"{guess}?"
    )


def _without_impossible(force: FloatArray) -> tuple[FloatArray, list[str]]:
    beyond = (np.abs(force) > _IMPOSSIBLE_M_S2).any(axis=1)
    nothing = (force == 0).all(axis=1)
    notes = []
    if beyond.any():
        notes.append(f"{beyond.sum()} accelerometer samples beyond 1000 g taken as missing")
    if nothing.any():
        notes.append(f"{nothing.sum()} accelerometer samples of exactly zero taken as missing")
    return np.where((beyond | nothing)[:, None], np.nan, force), notes


def _check_size(time: FloatArray, where: str) -> None:
    ticks = (time[-1] - time[0]) / np.median(np.diff(time))
    if ticks > max(_MAX_TICKS, _MAX_TICKS_PER_SAMPLE * len(time)):
        k = int(np.argmax(np.diff(time)))
        raise RecordingError(
            f"{where}: {time[k + 1] - time[k]:g} s without a sample after {time[k]:g} s; expected "
            "one recording, cut it there"
        )


def _check_interleaved(time: FloatArray, rate: FloatArray, where: str) -> None:
    """Refuse rows of several sensors in turn."""
    most = min(_MOST_SENSORS, int(_INTERLEAVED_S / float(np.median(np.diff(time)))))
    squares = [_step_square(rate, k) for k in range(1, most + 1)]
    if len(squares) < 2 or not squares[0] > _INTERLEAVED_RAD_S**2:
        return
    k = int(np.argmin(squares))
    if squares[0] > _INTERLEAVED_RATIO * squares[k]:
        raise RecordingError(
            f"{where}: each row continues the one {k + 1} rows before, not its neighbour: the rows "
            f"of {k + 1} sensors? Expected one sensor in a file"
        )


def _step_square(rate: FloatArray, rows: int) -> float:
    """Mean square change of the rate over some rows, without the largest per cent."""
    change = np.sum((rate[rows:] - rate[:-rows]) ** 2, axis=1)
    change = change[np.isfinite(change)]
    if not change.size:
        return np.inf
    return float(np.mean(np.minimum(change, np.quantile(change, 0.99))))


def _check_range(rate: FloatArray, where: str) -> None:
    valid = rate[np.isfinite(rate).all(axis=1)]
    if not len(valid):
        return
    peaks = np.abs(valid).max(axis=1)
    beyond = peaks > IMPOSSIBLE_RAD_S
    codes = np.unique(valid[np.abs(valid) > IMPOSSIBLE_RAD_S])
    # a single value, such as -9999, is a code for missing samples
    most = _CODE_SHARE if len(codes) == 1 else _IMPOSSIBLE_SHARE
    if beyond.mean() > most:
        bounded = np.clip(valid, -1e300, 1e300)
        whole = any(np.allclose(w, np.round(w), atol=1e-6) for w in (bounded, np.degrees(bounded)))
        raise RecordingError(
            f"{where}: the gyroscope reaches {_rate_deg_s(np.quantile(peaks, 0.999))} deg/s, "
            "beyond any gyroscope on a leg; "
            + ("raw counts?" if whole else "deg/s in a column of rad/s, or raw counts?")
        )


def _rate_deg_s(rate_rad_s: float) -> str:
    # beyond all sense it would overflow
    degrees = float(np.degrees(min(rate_rad_s, 1e300)))
    return f"{degrees:.0f}" if degrees < 1e6 else f"{degrees:.3g}"


def _check_unit(time: FloatArray, rate: FloatArray, where: str) -> None:
    """Refuse swings larger than those of any leg, and strides of a fraction of a degree."""
    interval = float(np.median(np.diff(time)))
    if not np.isfinite(rate).all(axis=1).any():
        return
    known = np.nan_to_num(rate - np.nanmedian(rate, axis=0))
    window = round(_SWING_WINDOW_S / interval)
    if len(time) < 2 * window:
        return
    angle = np.cumsum(known, axis=0) * interval
    swing = np.abs(angle - uniform_filter1d(angle, window, axis=0, mode="nearest"))
    wide = float(np.quantile(swing.max(axis=1), 0.9))
    if wide > _MAX_SWING_RAD:
        raise RecordingError(
            f"{where}: by its gyroscope the segment swings by {np.degrees(wide):.0f} deg to either "
            "side, which no leg does; deg/s in a column of rad/s, or a wrong scale?"
        )
    fastest = float(np.quantile(np.linalg.norm(known, axis=1), 0.999))
    if 0 < fastest < _SLOW_RAD_S and _strides(known, interval):
        raise RecordingError(
            f"{where}: the gyroscope never turns faster than {np.degrees(fastest):.2g} deg/s, yet "
            "as regularly as a walk; rad/s in a column of deg/s?"
        )


def _check_minutes(time: FloatArray, rate: FloatArray, where: str) -> None:
    """Refuse a walk that is sixty times too fast."""
    interval = float(np.median(np.diff(time)))
    fast = interval < _FAST_S and np.isfinite(rate).all(axis=1).sum() > 0.9 * len(rate)
    if fast and _strides(np.nan_to_num(rate - np.nanmedian(rate, axis=0)), 60.0 * interval):
        raise RecordingError(
            f"{where}: the segment swings as in a walk, but sixty times as fast, at "
            f"{1.0 / interval:.4g} Hz; are the times in minutes?"
        )


def _check_tenths(time: FloatArray, rate: FloatArray, where: str) -> None:
    """Refuse a walk that is ten times too slow, and swings ten times too far."""
    interval = float(np.median(np.diff(time)))
    if interval < _SLOW_S or not np.isfinite(rate).all(axis=1).any():
        return
    known = np.nan_to_num(rate - np.nanmedian(rate, axis=0))
    angle = np.cumsum(known, axis=0) * interval
    window = min(len(time), round(10.0 * _SWING_WINDOW_S / interval))
    swing = np.abs(angle - uniform_filter1d(angle, window, axis=0, mode="nearest"))
    if np.quantile(swing.max(axis=1), 0.9) > _MAX_SLOW_SWING_RAD and _strides(known, interval / 10):
        raise RecordingError(
            f"{where}: the segment swings as in a walk, but a tenth as fast and ten times as far, "
            f"at {1.0 / interval:.4g} Hz; are the times in tenths of a second?"
        )


def _strides(rate: FloatArray, interval_s: float) -> bool:
    """Return whether most of the power lies in one narrow band of stride frequencies."""
    segment = min(len(rate), round(10.0 / interval_s))
    frequency, power = welch(rate, 1.0 / interval_s, nperseg=segment, axis=0)
    total = power.sum(axis=1)
    inside = (frequency >= _STRIDES_HZ[0]) & (frequency <= _STRIDES_HZ[1])
    if segment * interval_s < 5.0 or not total[inside].any():
        return False
    peak = int(np.flatnonzero(inside)[np.argmax(total[inside])])
    around = total[max(0, peak - 1) : peak + 2].sum()
    return bool(around > _STRIDES_SHARE * total[1:].sum())
