"""Samples as they come, with losses and jitter, through start-up and network of many sensors.

`narx.kernels.clock.lay_out`, `narx.kernels.sample_steps.run_method` and
`narx.kernels.clock.collect` in one call, since a call costs more than the sample. Sensors are in
groups of as many as there are lanes, whose networks take a regular sample side by side.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.clock import (
    ARRIVED,
    CLOCK,
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
from narx.kernels.sample_steps import network_step, start_network
from narx.kernels.sizes import SCALAR, VECTOR
from narx.kernels.start_up import STATE_SIZE, run_start_up
from narx.kernels.transfer import copy_row

# numbers of `follow`: clock, sizes of the network, standard deviations after the start-up and in
# it, start-up, whether the network is coupled, washout, scales, weights
LIMIT, INTERVAL, MAX_GAP, LOST_MOST, HIDDEN, INPUT_LAGS, OUTPUT_LAGS = range(7)
STDS, START_UP, COUPLED, GAIN, SCALES, WEIGHTS = 7, 13, 19, 20, 21, 33
# rows of a group's state, after those of the clock; the angles are those of the newest tick
LATEST, ANGLES, IN_START_UP, TAKEN_OVER, START = CLOCK, CLOCK + 3, CLOCK + 6, CLOCK + 7, CLOCK + 8
MEMORY = START + STATE_SIZE


@compiled(**EXACT_VIEWS)
def _tick(numbers: Any, shape: Any, sensor: Any, tick: Any, room: Any) -> None:
    """Advance a sensor's state (S,) by a tick: rates (1, 3, 1)."""
    interval, coupled = numbers[INTERVAL], numbers[COUPLED] != 0.0
    scales = numbers[SCALES:WEIGHTS].reshape(3, 4)
    # contiguous, for the machine code of whole recordings: the same bits
    deviation, start, memory, found = room
    sensor[IN_START_UP] = 0.0
    copy_row(sensor[MEMORY:], memory[:, 0])
    if sensor[TAKEN_OVER] == 0.0:
        copy_row(sensor[START:MEMORY], start)
        taken = run_start_up(
            tick.reshape(1, 3),
            interval,
            numbers[START_UP],
            numbers[START_UP + 1],
            numbers[START_UP + 2],
            numbers[START_UP + 3],
            numbers[START_UP + 4],
            numbers[START_UP + 5],
            coupled,
            start,
            found.reshape(1, 3),
        )
        copy_row(start, sensor[START:MEMORY])
        sensor[IN_START_UP] = float(taken)
        if taken == 0:
            sensor[TAKEN_OVER] = 1.0
            start_network(start, interval, scales, len(shape[2]) - 1, deviation, memory)
    if sensor[TAKEN_OVER] != 0.0:
        network_step(
            numbers[WEIGHTS:], scales, numbers[GAIN], coupled, tick, 0, memory, found, shape, SCALAR
        )
        copy_row(memory[:, 0], sensor[MEMORY:])
    copy_row(found[0, :, 0], sensor[ANGLES:IN_START_UP])


@compiled(**EXACT_VIEWS)
def _one_sample(
    samples: Any, stamps: Any, b: int, k: int, numbers: Any, shape: Any, sensor: Any, tick: Any,
    room: Any,
) -> int:  # fmt: skip
    """Advance a sensor's state (S,) to its sample `k`, whatever it is; return the arrival."""
    sample, latest, interval = samples[b, k], sensor[LATEST:ANGLES], numbers[INTERVAL]
    clock = sensor[:CLOCK]
    passed = passed_s(stamps, b, k, interval, clock)
    arrival, _, due, rest, since = arrive(
        sample, passed, numbers[LIMIT], interval, numbers[MAX_GAP], int(numbers[LOST_MOST]), clock
    )
    for i in range(due):
        interpolate(sample, latest, (rest + (due - 1 - i) * interval) / since, tick[0, :, 0])
        _tick(numbers, shape, sensor, tick, room)
    if arrival != MISSING:
        copy_row(sample, latest)
    return int(arrival)


@compiled(**EXACT_INNER)
def _space(n_rows: int, width: int) -> Any:
    return (
        (
            np.empty((2, 3)),
            np.empty(STATE_SIZE),
            np.empty((n_rows - MEMORY, 1)),
            np.empty((1, 3, 1)),
        ),
        np.empty((1, 3, 1)),
        np.empty((1, 3, width)),
        np.empty(width, np.bool_),
        np.empty(width, np.int8),
        np.empty((n_rows, width)),
    )


@compiled(**EXACT_VIEWS)
def _follow(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any,
    space: Any, lanes: Any,
) -> None:  # fmt: skip
    n_sensors, n_samples = quality.shape
    limit, width = numbers[LIMIT], len(lanes)
    in_step = stamps.shape[1] == 0 and numbers[INTERVAL] <= numbers[MAX_GAP]
    room, tick, rates, regular, arrivals, kept = space
    scales, coupled = numbers[SCALES:WEIGHTS].reshape(3, 4), numbers[COUPLED] != 0.0
    # only the lengths count
    shape = (
        numbers[: int(numbers[HIDDEN])],
        numbers[:1],
        numbers[: int(numbers[INPUT_LAGS])],
        numbers[: int(numbers[OUTPUT_LAGS])],
    )
    for group in range(len(state)):
        rows = state[group]
        found = rows[ANGLES:IN_START_UP].reshape(1, 3, width)
        for k in range(n_samples):
            n_regular = 0
            for lane in range(width):
                b = min(group * width + lane, n_sensors - 1)
                regular[lane] = (
                    in_step
                    and rows[TAKEN_OVER, lane] != 0.0
                    and on_time(rows, lane, samples, b, k, limit)
                )
                n_regular += regular[lane]
                for axis in range(3):
                    rates[0, axis, lane] = samples[b, k, axis] if regular[lane] else 0.0
            if 0 < n_regular < width:
                for row in range(len(rows)):
                    for lane in range(width):
                        kept[row, lane] = rows[row, lane]
            if n_regular > 0:
                network_step(
                    numbers[WEIGHTS:], scales, numbers[GAIN], coupled, rates, 0, rows[MEMORY:],
                    found, shape, lanes,
                )  # fmt: skip
            for lane in range(width):
                b = min(group * width + lane, n_sensors - 1)
                if regular[lane]:
                    arrivals[lane] = ARRIVED
                    rows[IN_START_UP, lane] = 0.0
                    for axis in range(3):
                        rows[LATEST + axis, lane] = rates[0, axis, lane]
                else:
                    if n_regular > 0:
                        copy_row(kept[:, lane], rows[:, lane])
                    arrivals[lane] = _one_sample(
                        samples, stamps, b, k, numbers, shape, rows[:, lane], tick, room
                    )
            for lane in range(width):
                b = min(group * width + lane, n_sensors - 1)
                arrival, starting = arrivals[lane], rows[IN_START_UP, lane] != 0.0
                quality[b, k] = STARTING if starting and arrival == ARRIVED else arrival
                if arrival == MISSING:
                    for axis in range(3):
                        angles[b, k, axis] = stds[b, k, axis] = math.nan
                    continue
                for axis in range(3):
                    angles[b, k, axis] = rows[ANGLES + axis, lane]
                    stds[b, k, axis] = numbers[STDS + axis + (3 if starting else 0)]
                if rows[PAST, lane] != 0.0:
                    turn_on(found[0, :, lane], samples[b, k], rows[PAST, lane], angles[b, k])


@compiled(**EXACT)
def follow_one(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any
) -> None:
    """Advance a sensor, as `follow_many` does."""
    space = _space(state.shape[1], len(SCALAR))
    _follow(samples, stamps, numbers, state, angles, stds, quality, space, SCALAR)


@compiled(**EXACT)
def follow_many(
    samples: Any, stamps: Any, numbers: Any, state: Any, angles: Any, stds: Any, quality: Any
) -> None:
    """Advance sensors over samples (B, N, 3).

    stamps: as for `narx.kernels.clock.passed_s`. numbers and state (groups, S, 8), which is changed
    in place, are laid out as above; lanes of the last group without a sensor repeat the last one.
    Filled: angles and stds (B, N, 3), NaN where a sample is missing; quality (B, N).
    """
    space = _space(state.shape[1], len(VECTOR))
    _follow(samples, stamps, numbers, state, angles, stds, quality, space, VECTOR)
