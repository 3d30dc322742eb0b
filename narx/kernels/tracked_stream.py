"""Samples as they come, with losses and jitter, through network and tracker of many sensors.

`narx.kernels.clock.lay_out`, `narx.kernels.tracker.track` and `narx.kernels.clock.collect` in one
call, since a call costs more than the sample. Sensors are in groups of as many as there are lanes,
which take a tick side by side; those to which none is due are put back.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.clock import (
    AFTER_PAUSE,
    ARRIVED,
    CLOCK,
    DOUBTFUL,
    MISSING,
    PAST,
    STARTING,
    arrive,
    interpolate,
    on_time,
    passed_s,
    turn_on,
)
from narx.kernels.compiler import EXACT, EXACT_INNER, EXACT_VIEWS, compiled
from narx.kernels.leg import DOUBTFUL_GROWTH, std_growth
from narx.kernels.sizes import SCALAR, VECTOR
from narx.kernels.tracker import room, step
from narx.kernels.tracker_angles import corrected_rad
from narx.kernels.tracker_layout import (
    ALIGNMENT,
    CUBE,
    DELAY_S,
    INTERVAL,
    KNOWN,
    MOST_CORRECTED_RAD,
    PARAMETERS,
    SCALARS,
    SQUARE,
)
from narx.kernels.tracker_layout import MISSING as MISSING_S
from narx.kernels.transfer import copy_row


@compiled(**EXACT_VIEWS)
def _copy(source: Any, out: Any) -> None:
    for i in range(source.shape[0]):
        for lane in range(source.shape[1]):
            out[i, lane] = source[i, lane]


@compiled(**EXACT_INNER)
def _space(numbers: Any, n_columns: int, n_rows: int, width: int) -> Any:
    n_weights = len(numbers) - 10 - PARAMETERS
    return (
        room(int(numbers[2]), n_weights, int(numbers[1]), width),
        np.zeros((n_columns, width)),
        np.empty((n_rows, width)),
        np.empty(width, np.int64),
        np.empty(width, np.int64),
        np.empty(width),
        np.empty(width),
    )


@compiled(**EXACT_VIEWS)
def _follow(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any,
    space: Any, lanes: Any,
) -> None:  # fmt: skip
    n_sensors, n_samples, n_columns = samples.shape
    width, lost_most = len(lanes), int(numbers[0])
    n, n_rates = int(numbers[2]), int(numbers[3])
    limit, interval, max_gap, std_scale = numbers[4], numbers[5], numbers[6], numbers[7:10]
    p, weights = numbers[10 : 10 + PARAMETERS], numbers[10 + PARAMETERS :]
    in_step = stamps.shape[1] == 0 and interval <= max_gap
    for_step, tick, kept, arrivals, due, rest, since = space
    at_works = CLOCK + n_columns
    at_x = at_works + 1
    at_covariance = at_x + n
    at_scalars = at_covariance + n * n
    at_rates = at_scalars + SCALARS
    at_past = at_rates + 3 * n_rates
    n_past = (state.shape[1] - at_past) // 3
    for group in range(len(state)):
        rows = state[group]
        x, s = rows[at_x:at_covariance], rows[at_scalars:at_rates]
        covariance = rows[at_covariance:at_scalars].reshape(n, n, width)
        rates = rows[at_rates:at_past].reshape(3, n_rates, width)
        past = rows[at_past:].reshape(3, n_past, width)
        tracked = x, covariance, s, rates, past, rows[at_works:at_x]
        for k in range(n_samples):
            most = 0
            for lane in range(width):
                b = min(group * width + lane, n_sensors - 1)
                if in_step and on_time(rows, lane, samples, b, k, limit):
                    arrivals[lane], due[lane], rest[lane], since[lane] = ARRIVED, 1, 0.0, interval
                else:
                    clock = rows[:CLOCK, lane]
                    passed = passed_s(stamps, b, k, interval, clock)
                    arrivals[lane], lost, due[lane], rest[lane], since[lane] = arrive(
                        samples[b, k], passed, limit, interval, max_gap, lost_most, clock
                    )
                    for _ in range(lost):
                        s[MISSING_S, lane] += p[INTERVAL]
                most = max(most, due[lane])
            for i in range(most):
                together = True
                for lane in range(width):
                    if i < due[lane]:
                        b = min(group * width + lane, n_sensors - 1)
                        back = (rest[lane] + (due[lane] - 1 - i) * interval) / since[lane]
                        latest = rows[CLOCK:at_works, lane]
                        interpolate(samples[b, k], latest, back, tick[:, lane])
                    else:
                        together = False
                if not together:
                    _copy(rows, kept)
                step(tick, tracked, p, weights, for_step, lanes)
                for lane in range(width):
                    if i >= due[lane]:
                        copy_row(kept[:, lane], rows[:, lane])
            for lane in range(width):
                b, arrival = min(group * width + lane, n_sensors - 1), arrivals[lane]
                quality[b, k] = arrival
                if arrival == MISSING:
                    for axis in range(3):
                        angles[b, k, axis] = stds[b, k, axis] = math.nan
                    continue
                copy_row(samples[b, k], rows[CLOCK:at_works, lane])
                if rows[PAST, lane] == 0.0:
                    copy_row(x[:, lane], angles[b, k])
                else:
                    turn_on(x[:, lane], samples[b, k], rows[PAST, lane], angles[b, k])
                growth = std_growth(s[SQUARE, lane], s[CUBE, lane])
                most_corrected = 0.0
                for axis in range(3):
                    variance = (
                        covariance[axis, axis, lane] + (p[DELAY_S] * rates[axis, 0, lane]) ** 2
                    )
                    std = math.sqrt(max(variance, 0.0)) * growth * std_scale[axis]
                    corrected = corrected_rad(s, p, axis, lane)
                    most_corrected = max(most_corrected, corrected)
                    std = math.sqrt(std * std + corrected * corrected)
                    stds[b, k, axis] = max(std, s[KNOWN, lane] * p[ALIGNMENT])
                if arrival == AFTER_PAUSE:
                    continue
                if rows[at_works, lane] == 0.0:
                    quality[b, k] = STARTING
                elif growth > DOUBTFUL_GROWTH or most_corrected > MOST_CORRECTED_RAD:
                    quality[b, k] = DOUBTFUL


@compiled(**EXACT)
def follow_one(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any
) -> None:
    """Advance a sensor, as `follow_many` does."""
    space = _space(numbers, samples.shape[2], state.shape[1], len(SCALAR))
    _follow(samples, stamps, numbers, state, angles, stds, quality, space, SCALAR)


@compiled(**EXACT)
def follow_many(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any
) -> None:
    """Advance sensors over samples (B, N, C).

    stamps: as for `narx.kernels.clock.passed_s`. numbers: lost_most of
    `narx.kernels.clock.lay_out`, numbers of hidden neurons, states and past rates, then limit,
    interval and max_gap of `lay_out`, factors on the standard deviations (3), p and weights of
    `narx.kernels.tracker.track`. Changed in place: state (groups, S, 8), of each sensor clock (4),
    latest sample (C), whether the network carried the angles (1), then estimate, covariance,
    scalars, rates (3, n_rates) and past angles; lanes of the last group without a sensor repeat the
    last one. Filled: angles and stds (B, N, 3), NaN where a sample is missing; quality (B, N).
    """
    space = _space(numbers, samples.shape[2], state.shape[1], len(VECTOR))
    _follow(samples, stamps, numbers, state, angles, stds, quality, space, VECTOR)
