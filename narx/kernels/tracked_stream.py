"""Samples as they come, with losses and jitter, through network and tracker of many sensors.

`narx.kernels.clock.lay_out`, `narx.kernels.tracker.track` and `narx.kernels.clock.collect` in one
call, since a call costs more than the sample.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.clock import (
    AFTER_PAUSE,
    CLOCK,
    DOUBTFUL,
    MISSING,
    PAST,
    STARTING,
    arrive,
    interpolate,
    passed_s,
    turn_on,
)
from narx.kernels.compiler import EXACT, compiled
from narx.kernels.leg import DOUBTFUL_GROWTH, std_growth
from narx.kernels.tracker import (
    CUBE,
    INTERVAL,
    PARAMETERS,
    SCALARS,
    SQUARE,
    room,
    step,
)
from narx.kernels.tracker import MISSING as MISSING_S
from narx.kernels.transfer import copy_row


@compiled(**EXACT)
def follow(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any
) -> None:
    """Advance sensors over samples (B, N, C).

    numbers: lost_most of `narx.kernels.clock.lay_out`, numbers of hidden neurons, states and past
    rates, then limit, interval and max_gap of `lay_out`, factors on the standard deviations (3), p
    and weights of `narx.kernels.tracker.track`. Changed in place: state
    (B, S), clock (4), latest sample (C), whether the network carried the angles (1), then estimate,
    covariance, scalars, rates (3, n_rates) and past angles. Filled: angles and stds (B, N, 3), NaN
    where a sample is missing; quality (B, N).
    """
    n_sensors, n_samples, n_columns = samples.shape
    lost_most, n_hidden = int(numbers[0]), int(numbers[1])
    n_states, n_rates = int(numbers[2]), int(numbers[3])
    limit, interval, max_gap, std_scale = numbers[4], numbers[5], numbers[6], numbers[7:10]
    p, weights = numbers[10 : 10 + PARAMETERS], numbers[10 + PARAMETERS :]
    work, moved, features, arguments = room(n_states, len(weights), n_hidden)
    tick = np.empty(n_columns)
    force = tick[3:]
    at_works = CLOCK + n_columns
    at_x = at_works + 1
    at_covariance = at_x + n_states
    at_scalars = at_covariance + n_states * n_states
    at_rates = at_scalars + SCALARS
    at_past = at_rates + 3 * n_rates
    for b in range(n_sensors):
        clock, latest = state[b, :CLOCK], state[b, CLOCK:at_works]
        x = state[b, at_x:at_covariance]
        covariance = state[b, at_covariance:at_scalars].reshape(n_states, n_states)
        s = state[b, at_scalars:at_rates]
        rates = state[b, at_rates:at_past].reshape(3, n_rates)
        past = state[b, at_past:].reshape(3, (state.shape[1] - at_past) // 3)
        for k in range(n_samples):
            sample = samples[b, k]
            passed = passed_s(stamps, b, k, interval, clock)
            arrival, lost, due, rest, since = arrive(
                sample, passed, limit, interval, max_gap, lost_most, clock
            )
            quality[b, k] = arrival
            if arrival == MISSING:
                angles[b, k] = math.nan
                stds[b, k] = math.nan
                continue
            for _ in range(lost):
                s[MISSING_S] += p[INTERVAL]
            for i in range(due):
                back = (rest + (due - 1 - i) * interval) / since
                interpolate(sample, latest, back, tick)
                works = step(
                    tick, force, x, covariance, s, p, weights, rates, past,
                    work, moved, features, arguments,
                )  # fmt: skip
                state[b, at_works] = 1.0 if works else 0.0
            copy_row(sample, latest)
            if clock[PAST] == 0.0:
                copy_row(x, angles[b, k])
            else:
                turn_on(x, sample, clock[PAST], angles[b, k])
            growth = std_growth(s[SQUARE], s[CUBE])
            for axis in range(3):
                variance = max(covariance[axis, axis], 0.0)
                stds[b, k, axis] = math.sqrt(variance) * growth * std_scale[axis]
            if arrival == AFTER_PAUSE:
                continue
            if state[b, at_works] == 0.0:
                quality[b, k] = STARTING
            elif growth > DOUBTFUL_GROWTH:
                quality[b, k] = DOUBTFUL
