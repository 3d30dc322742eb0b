"""From samples as they come, with losses and jitter, to the ticks of a uniform clock."""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled
from narx.kernels.limits import COS_FRONTAL_MIN

# columns of the clock's state: whether there was a sample yet, time since the latest one, and
# time by which that one was past its tick, s
SEEN, SINCE, PAST = 0, 1, 2
LARGEST = 1.7e308
# a sample this close to a tick, in intervals, is on it
ON_TICK = 1e-3
# of a sample, as `narx.inference.stream.Quality`
ARRIVED, AFTER_PAUSE, MISSING, STARTING = 0, 1, 2, 3


@compiled(**EXACT_INNER)
def usable(sample: Any, limit: float) -> bool:
    """Tell a sample from a missing one."""
    for c in range(len(sample)):  # noqa: SIM110 - the compiler has no generators
        # NaN is not below the limit either
        if not abs(sample[c]) <= (limit if c < 3 else LARGEST):
            return False
    return True


@compiled(**EXACT)
def lay_out(
    samples: Any,
    intervals: Any,
    limit: float,
    interval: float,
    max_gap: float,
    latest: Any,
    clock: Any,
    tick_of: Any,
    past: Any,
    arrival: Any,
) -> Any:
    """Interpolate samples (B, N, C) at the ticks between them, along straight lines.

    intervals (B, N): time since the sample before, which may be missing. Missing are samples that
    are not finite, whose first three columns go beyond `limit`, or after no positive interval. A
    tick is a multiple of `interval`. After more than `max_gap` without a sample the clock stands
    still in between: the next sample is the next tick. State, changed in place: latest (B, C),
    the latest sample; clock (B, 3). Filled (B, N): tick_of, the newest tick at each sample (-1:
    that of an earlier call); past, the time since it; arrival. Returns ticks (M, C), those of a
    sensor one after another, and first (B + 1,), where each sensor's begin.
    """
    n_sensors, n_samples, n_columns = samples.shape
    ticks = np.empty((n_sensors * n_samples + 8, n_columns))
    first = np.zeros(n_sensors + 1, np.int64)
    n = 0
    for b in range(n_sensors):
        first[b] = n
        for k in range(n_samples):
            passed = intervals[b, k]
            if passed > 0.0:
                # an endless pause is as good as one twice too long
                clock[b, SINCE] = min(clock[b, SINCE] + passed, 2.0 * max_gap)
            arrival[b, k] = MISSING
            if passed > 0.0 and usable(samples[b, k], limit):
                since, rest = clock[b, SINCE], 0.0
                due = 1
                arrival[b, k] = ARRIVED
                paused = clock[b, SEEN] == 0.0 or since > max_gap * (1.0 + ON_TICK)
                if paused and clock[b, SEEN] > 0.0:
                    arrival[b, k] = AFTER_PAUSE
                if not paused:
                    elapsed = clock[b, PAST] + since
                    due = int(elapsed / interval + ON_TICK)
                    rest = elapsed - due * interval
                    if rest < ON_TICK * interval:
                        rest = 0.0
                if n + due > len(ticks):
                    longer = np.empty((2 * len(ticks) + due, n_columns))
                    longer[:n] = ticks[:n]
                    ticks = longer
                for i in range(due):
                    back = 0.0 if paused else (rest + (due - 1 - i) * interval) / since
                    for c in range(n_columns):
                        change = samples[b, k, c] - latest[b, c]
                        if back == 0.0:
                            ticks[n, c] = samples[b, k, c]
                        else:
                            ticks[n, c] = samples[b, k, c] - back * change
                    n += 1
                for c in range(n_columns):
                    latest[b, c] = samples[b, k, c]
                clock[b, SEEN], clock[b, SINCE], clock[b, PAST] = 1.0, 0.0, rest
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
    """Fill angles (B, N, 3) and starting (B, N) at the samples; past a tick they turn on.

    quality (B, N) comes as `lay_out` filled it and leaves as that of the angles. State, changed in
    place: latest_angles (B, 3) and latest_starting (B,) at the newest tick.
    """
    n_sensors, n_samples = tick_of.shape
    for b in range(n_sensors):
        for k in range(n_samples):
            tick = tick_of[b, k]
            if tick >= 0:
                latest_angles[b] = tick_angles[tick]
                latest_starting[b] = tick_starting[tick]
            starting[b, k] = latest_starting[b]
            if quality[b, k] == MISSING:
                angles[b, k] = np.nan
                continue
            if past[b, k] == 0.0:
                angles[b, k] = latest_angles[b]
            else:
                turn_on(latest_angles[b], samples[b, k], past[b, k], angles[b, k])
            if latest_starting[b]:
                quality[b, k] = STARTING


@compiled(**EXACT_INNER)
def turn_on(start: Any, sample: Any, duration: float, angles: Any) -> None:
    """Fill angles (3,): turned from `start` for less than a tick at the rates of a sample."""
    sin_s, cos_s = np.sin(start[0]), np.cos(start[0])
    sin_f, cos_f = np.sin(start[1]), np.cos(start[1])
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0.0 else COS_FRONTAL_MIN
    heading = (sample[2] * cos_s - sample[1] * sin_s) / cos_f
    angles[0] = start[0] + duration * (sample[0] - sin_f * heading)
    angles[1] = start[1] + duration * (sample[1] * cos_s + sample[2] * sin_s)
    angles[2] = start[2] + duration * heading
