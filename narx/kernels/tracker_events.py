"""What a tracker does now and then, for one of the sensors side by side: gaps and swings.

Arrays are those of `narx.kernels.tracker.step`, which end with the sensors; `lane` is the sensor.
"""

import math
from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled
from narx.kernels.kalman import measure, spread
from narx.kernels.sample_steps import turned
from narx.kernels.short_gap import BRIDGED_RAD_S2, LONGEST_BRIDGED_S, interpolate
from narx.kernels.tracker_layout import (
    BEFORE,
    BIAS,
    CENTRE,
    CYCLE_VARIANCE,
    DIRECTION,
    EARLY,
    HIGH,
    IDLE,
    IDLE_MOST,
    INTERVAL,
    KNOWN,
    KNOWN_ENOUGH,
    LEAN,
    LONGEST_GAP_S,
    LONGEST_SWING_S,
    LOW,
    MEANS,
    MISSING,
    MOST_DOUBT,
    MOST_NET,
    NOW,
    ODD,
    OUTLIER,
    PERIOD,
    PERIOD_SHARE,
    REOPENED,
    RETURN_VARIANCE,
    RISING,
    SAMPLES,
    SHORTEST_SWING_S,
    SINCE,
    START_VARIANCE,
    SUM_ANGLES,
    SUM_TURN,
    SWING,
    SWING_DECAY,
    TRUST,
    TURN_LEAST,
)


@compiled(**EXACT_VIEWS)
def end_gap(tick: Any, state: Any, p: Any, work: Any, lane: int) -> None:
    """Interpolate over a short gap, up to the sample before the present one, or lose track."""
    x, covariance, s, rates, past, _ = state
    dt, gap = p[INTERVAL], s[MISSING, lane]
    s[MISSING, lane] = 0.0
    if gap >= LONGEST_BRIDGED_S:
        _lose_track(covariance, s, p, gap, lane)
        return
    now = turned(
        tick[0, lane] - x[BIAS, lane],
        tick[1, lane] - x[BIAS + 1, lane],
        tick[2, lane] - x[BIAS + 2, lane],
        past[0, 0, lane],
        past[1, 0, lane],
    )
    for axis in range(3):
        work[NOW, axis, lane] = now[axis]
    last, means = rates[0, 0, lane], work[MEANS : MEANS + 2, :, lane]
    interpolate(gap, dt, work[NOW, :, lane], rates[:, :, lane], past[:, :, lane], means)
    n_lost, swing_time = gap / dt, dt / (p[SWING_DECAY] - 1.0)
    kept = math.exp(-gap / swing_time)
    area = (1.0 - kept) * swing_time * 0.5 * (last + rates[0, 0, lane])
    s[SWING, lane] = kept * s[SWING, lane] + area
    for axis in range(3):
        x[axis, lane] = past[axis, 0, lane]
        covariance[axis, axis, lane] += (BRIDGED_RAD_S2 * gap**2) ** 2
        s[SUM_ANGLES + axis, lane] += n_lost * means[0, axis]
    s[SUM_TURN, lane] += n_lost * means[1, 2]
    s[SAMPLES, lane] += n_lost
    s[SINCE, lane] += gap
    s[IDLE, lane] += gap


@compiled(**EXACT_VIEWS)
def _lose_track(covariance: Any, s: Any, p: Any, gap: float, lane: int) -> None:
    """Forget the present swing in a gap: the motion is unknown, except that legs return."""
    for axis in range(3):
        covariance[axis, axis, lane] += p[START_VARIANCE] * min(gap, LONGEST_GAP_S) ** 2
    for row in (RISING, SWING, HIGH, LOW, PERIOD):
        s[row, lane] = 0.0
    _begin_swing(s, lane)
    s[IDLE, lane] = p[IDLE_MOST]


@compiled(**EXACT_VIEWS)
def _begin_swing(s: Any, lane: int) -> None:
    s[SINCE, lane], s[SAMPLES, lane], s[SUM_TURN, lane] = 0.0, 0.0, 0.0
    for axis in range(3):
        s[SUM_ANGLES + axis, lane] = 0.0


@compiled(**EXACT_VIEWS)
def end_swing(state: Any, p: Any, work: Any, lane: int) -> None:
    """Learn from the swing that has just ended, unless its duration is not that of a step."""
    x, _, s, _, _, _ = state
    swung = SHORTEST_SWING_S < s[SINCE, lane] < LONGEST_SWING_S
    if swung and _learn_from_swing(state, p, work, lane):
        s[IDLE, lane] = 0.0
    s[PERIOD, lane] = s[SINCE, lane] if swung else 0.0
    _begin_swing(s, lane)
    s[BEFORE, lane], s[BEFORE + 1, lane] = x[0, lane], x[1, lane]


@compiled(**EXACT_VIEWS)
def _learn_from_swing(state: Any, p: Any, work: Any, lane: int) -> bool:
    """Update by a swing: its mean angle measures the posture, less noisily if it resembles gait.

    Returns whether the leg walks.
    """
    x, covariance, s, _, _, _ = state
    turn = s[SUM_TURN, lane] / s[SAMPLES, lane]
    if abs(turn) > p[TURN_LEAST]:
        # a person who turns does not return to the previous heading
        covariance[CENTRE + 2, CENTRE + 2, lane] += (turn * s[SINCE, lane]) ** 2
    net = (x[0, lane] - s[BEFORE, lane]) ** 2 + (x[1, lane] - s[BEFORE + 1, lane]) ** 2
    doubt, period = 1.0 + net / p[RETURN_VARIANCE], s[PERIOD, lane]
    doubt += ((s[SINCE, lane] / period - 1.0) / p[PERIOD_SHARE]) ** 2 if period > 0.0 else 3.0
    if net > p[MOST_NET] and s[KNOWN, lane] == 0.0:
        # a sensor in a hand has reached its pocket: its angle has been learned from other motion
        for axis in range(2):
            covariance[axis, axis, lane] += p[REOPENED]
    unknown = 0.0
    for axis in range(2):
        at = CENTRE + axis
        relative = covariance[axis, axis, lane] - 2.0 * covariance[axis, at, lane]
        unknown = max(unknown, relative + covariance[at, at, lane])
    walks = doubt < MOST_DOUBT or unknown > p[KNOWN_ENOUGH]
    for axis in range(3):
        for i in range(len(x)):
            work[DIRECTION, i, lane] = 0.0
        work[DIRECTION, axis, lane], work[DIRECTION, CENTRE + axis, lane] = 1.0, -1.0
        about = x[CENTRE + axis, lane]
        if axis == 1:
            work[DIRECTION, LEAN, lane] = -turn
            about += x[LEAN, lane] * turn
        residual = about - s[SUM_ANGLES + axis, lane] / s[SAMPLES, lane]
        variance = p[CYCLE_VARIANCE + axis] * doubt
        expected = spread(covariance, work, lane) + variance
        excess = residual**2 / (p[OUTLIER] * expected)
        if excess <= 1.0:
            s[ODD + axis, lane] = 0.0
        elif s[ODD + axis, lane] * residual > 0.0:
            # two outliers in a row with the same sign: the posture has changed, or was wrong
            # before; a heading far from the mean is a turn, never an error
            share = (p[EARLY] / (p[EARLY] + s[TRUST, lane])) ** 2 if axis < 2 else 0.0
            covariance[axis, axis, lane] += residual**2 * share
            covariance[CENTRE + axis, CENTRE + axis, lane] += residual**2 * (1.0 - share)
            s[ODD + axis, lane] = 0.0
        else:
            s[ODD + axis, lane] = math.copysign(1.0, residual)
            continue
        measure(x, covariance, work, variance, residual, lane)
    s[TRUST, lane] += 1.0 / doubt
    return walks and s[ODD, lane] == 0.0 and s[ODD + 1, lane] == 0.0
