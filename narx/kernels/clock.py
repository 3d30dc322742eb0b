"""Interpolate samples with losses and jitter to the ticks of a uniform clock."""

import math
from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_VIEWS, compiled
from narx.kernels.limits import COS_FRONTAL_MIN, FORCE_LIMIT_M_S2
from narx.kernels.transfer import copy_row

# columns of the clock's state: whether there has been a sample, time since the latest one, time
# from the newest tick to that sample, and the latest time stamp, s
SEEN, SINCE, PAST, STAMP = 0, 1, 2, 3
CLOCK = 4
LARGEST = 1.7e308
# a sample closer to a tick than this, in intervals, counts as on the tick
ON_TICK = 1e-3
# quality of a sample, as `narx.inference.stream.Quality`
ARRIVED, AFTER_PAUSE, MISSING, STARTING, DOUBTFUL = 0, 1, 2, 3, 4


@compiled(**EXACT_VIEWS)
def usable(sample: Any, limit: float) -> bool:
    """Return whether a sample is not missing."""
    for c in range(len(sample)):  # noqa: SIM110 - the compiler has no generators
        # NaN is not below the limit either
        if not abs(sample[c]) <= (limit if c < 3 else FORCE_LIMIT_M_S2):
            return False
    return True


@compiled(**EXACT_VIEWS)
def passed_s(stamps: Any, b: int, k: int, interval: float, clock: Any) -> float:
    """Time since the previous sample; 0 or NaN for a time stamp that does not increase.

    stamps (B, N), s, or (B, 0) if samples follow each other at the sampling rate.
    """
    if stamps.shape[1] == 0:
        return interval
    stamp, before = stamps[b, k], clock[STAMP]
    if not abs(stamp) <= LARGEST:
        return math.nan
    if math.isnan(before):
        clock[STAMP] = stamp
        return interval
    if stamp <= before:
        return 0.0
    clock[STAMP] = stamp
    return float(stamp - before)


@compiled(**EXACT)
def longest_pause(interval: float, max_gap: float, lost_most: int) -> float:
    """Time without a sample that is as good as any longer one."""
    return float(max(2.0 * max_gap, (lost_most + 2) * interval))


@compiled(**EXACT_VIEWS)
def arrive(
    sample: Any,
    passed: float,
    limit: float,
    interval: float,
    max_gap: float,
    lost_most: int,
    clock: Any,
) -> tuple[int, int, int, float, float]:
    """Advance the clock (4,) to a sample.

    Returns the arrival; the number of ticks lost in a gap longer than `max_gap`, at most
    `lost_most`; the number of ticks due after them, none if the sample is missing; the time from
    the last of these to the sample; and the time since the previous sample.
    """
    if passed > 0.0:
        # an endless pause is as good as one a little too long
        clock[SINCE] = min(clock[SINCE] + passed, longest_pause(interval, max_gap, lost_most))
    if not passed > 0.0 or not usable(sample, limit):
        return MISSING, 0, 0, 0.0, 0.0
    since = clock[SINCE]
    arrival, lost, due, rest = ARRIVED, 0, 1, 0.0
    if clock[SEEN] == 0.0 or since > max_gap * (1.0 + ON_TICK):
        if clock[SEEN] > 0.0:
            arrival = AFTER_PAUSE
        lost = min(int(since / interval + 0.5) - 1, lost_most)
    else:
        elapsed = clock[PAST] + since
        due = int(elapsed / interval + ON_TICK)
        rest = elapsed - due * interval
        if rest < ON_TICK * interval:
            rest = 0.0
    clock[SEEN], clock[SINCE], clock[PAST] = 1.0, 0.0, rest
    return arrival, max(lost, 0), due, rest, since


@compiled(**EXACT_VIEWS)
def on_time(rows: Any, lane: int, samples: Any, b: int, k: int, limit: float) -> bool:
    """Return whether a sample without time stamp is the next tick, as usual.

    rows (S, W): state of sensors, that of the clock first. If so, `arrive` would leave the clock as
    it is, unless no interval may be interpolated.
    """
    return bool(
        rows[SEEN, lane] != 0.0
        and rows[SINCE, lane] == 0.0
        and rows[PAST, lane] == 0.0
        and usable(samples[b, k], limit)
    )


@compiled(**EXACT_VIEWS)
def interpolate(sample: Any, latest: Any, back: float, tick: Any) -> None:
    """Interpolate a tick that precedes the sample by a share of the time since the latest one."""
    for c in range(len(sample)):
        tick[c] = sample[c]
        if back != 0.0:
            tick[c] -= back * (sample[c] - latest[c])


@compiled(**EXACT)
def lay_out(
    samples: Any,
    stamps: Any,
    limit: float,
    interval: float,
    max_gap: float,
    lost_most: int,
    latest: Any,
    clock: Any,
    tick_of: Any,
    past: Any,
    arrival: Any,
) -> Any:
    """Interpolate samples (B, N, C) linearly at the ticks between them.

    stamps: as for `passed_s`. A sample is missing if it is not finite, if one of its first three
    columns exceeds `limit`, or if its stamp does not increase. Ticks are multiples of `interval`.
    During more than `max_gap` without a sample the clock is paused, except for up to `lost_most`
    ticks, which are NaN: the next sample is the next tick. State, changed in place: latest (B, C),
    the latest sample; clock (B, 4). Filled (B, N): tick_of, the newest tick at each sample (-1:
    from an earlier call); past, the time since; arrival. Returns ticks (M, C), grouped by sensor,
    and first (B + 1,), the index of each sensor's first tick.
    """
    n_sensors, n_samples, n_columns = samples.shape
    ticks = np.empty((n_sensors * n_samples + 8, n_columns))
    first = np.zeros(n_sensors + 1, np.int64)
    n = 0
    for b in range(n_sensors):
        first[b] = n
        for k in range(n_samples):
            passed = passed_s(stamps, b, k, interval, clock[b])
            arrival[b, k], lost, due, rest, since = arrive(
                samples[b, k], passed, limit, interval, max_gap, lost_most, clock[b]
            )
            if n + lost + due > len(ticks):
                longer = np.empty((2 * len(ticks) + lost + due, n_columns))
                for i in range(n):
                    copy_row(ticks[i], longer[i])
                ticks = longer
            ticks[n : n + lost] = math.nan
            n += lost
            for i in range(due):
                back = (rest + (due - 1 - i) * interval) / since
                interpolate(samples[b, k], latest[b], back, ticks[n])
                n += 1
            if arrival[b, k] != MISSING:
                copy_row(samples[b, k], latest[b])
            tick_of[b, k] = n - 1 if n > first[b] else -1
            past[b, k] = clock[b, PAST]
    first[n_sensors] = n
    return ticks[:n], first


@compiled(**EXACT)
def collect(
    tick_angles: Any,
    tick_starting: Any,
    tick_of: Any,
    past: Any,
    samples: Any,
    latest_angles: Any,
    latest_starting: Any,
    angles: Any,
    starting: Any,
    quality: Any,
) -> None:
    """Fill angles (B, N, 3) and starting (B, N) at the samples, integrating past the newest tick.

    quality (B, N) is changed from that of the samples, as filled by `lay_out`, to that of the
    angles. State, changed in place: latest_angles (B, 3) and latest_starting (B,) at the newest
    tick.
    """
    n_sensors, n_samples = tick_of.shape
    for b in range(n_sensors):
        for k in range(n_samples):
            tick = tick_of[b, k]
            if tick >= 0:
                copy_row(tick_angles[tick], latest_angles[b])
                latest_starting[b] = tick_starting[tick]
            starting[b, k] = latest_starting[b]
            if quality[b, k] == MISSING:
                angles[b, k] = np.nan
                continue
            if past[b, k] == 0.0:
                copy_row(latest_angles[b], angles[b, k])
            else:
                turn_on(latest_angles[b], samples[b, k], past[b, k], angles[b, k])
            if latest_starting[b] and quality[b, k] != AFTER_PAUSE:
                quality[b, k] = STARTING


@compiled(**EXACT_VIEWS)
def turn_on(start: Any, sample: Any, duration: float, angles: Any) -> None:
    """Fill angles (3,): `start`, advanced for less than a tick at the rates of a sample."""
    sin_s, cos_s = np.sin(start[0]), np.cos(start[0])
    sin_f, cos_f = np.sin(start[1]), np.cos(start[1])
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0.0 else COS_FRONTAL_MIN
    heading = (sample[2] * cos_s - sample[1] * sin_s) / cos_f
    angles[0] = start[0] + duration * (sample[0] - sin_f * heading)
    angles[1] = start[1] + duration * (sample[1] * cos_s + sample[2] * sin_s)
    angles[2] = start[2] + duration * heading
