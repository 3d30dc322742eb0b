"""Start-up, network and washout, sample by sample, for many sensors in sequence."""

from typing import Any

from narx.kernels.compiler import JIT, VIEWS, compiled
from narx.kernels.functions import (
    load,
    magnitude,
    sine_cosine,
    splat,
    store,
    tanh,
    where_less,
)
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.sizes import SCALAR
from narx.kernels.start_up import run_start_up, split_for_network

# columns of the scales (3 axes, 4)
RATE_OFFSET, RATE_SCALE, ANGLE_OFFSET, ANGLE_SCALE = 0, 1, 2, 3
# rows of the network's memory: posture and slow mean of the deviation (3 each), then of each axis
# past inputs and outputs, newest first
POSTURE, MEAN, PAST = 0, 3, 6


@compiled(**VIEWS)
def turned(u_s: Any, u_f: Any, u_t: Any, sagittal: Any, frontal: Any) -> Any:
    """Rates of the angles from those of the gyroscope, as `narx.kernels.euler.angle_rates`.

    Returns them and the cosine of the frontal angle, which is limited.
    """
    sin_s, cos_s = sine_cosine(sagittal, None)
    sin_f, cos_f = sine_cosine(frontal, None)
    size = magnitude(cos_f)
    zero = size - size
    least = zero + COS_FRONTAL_MIN
    cos_f = where_less(size, least, where_less(cos_f, zero, zero - least, least), cos_f)
    heading = (u_t * cos_s - u_f * sin_s) / cos_f
    return u_s - sin_f * heading, u_f * cos_s + u_t * sin_s, heading, cos_f


@compiled(**VIEWS)
def start_network(
    start: Any, interval: float, scales: Any, n_past: int, deviation: Any, memory: Any
) -> None:
    """Set the memory (R, 1) as if the network had run during the start-up; deviation (2, 3)."""
    split_for_network(start, interval, memory[POSTURE:MEAN, 0], deviation[0], deviation[1])
    n_state = (len(memory) - PAST) // 3
    for axis in range(3):
        scale, at = scales[axis], PAST + axis * n_state
        for i in range(n_past):
            memory[at + i, 0] = (start[3 + axis] - scale[RATE_OFFSET]) / scale[RATE_SCALE]
        for m in range(n_past, n_state):
            followed = deviation[0 if m == n_past else 1, axis]
            memory[at + m, 0] = (followed - scale[ANGLE_OFFSET]) / scale[ANGLE_SCALE]


@compiled(**VIEWS)
def network_step(
    weights: Any,
    scales: Any,
    gain: float,
    coupled: bool,
    rates: Any,
    k: int,
    memory: Any,
    angles: Any,
    shape: Any,
    lanes: Any,
) -> None:
    """Run network and washout over sample `k` of rates (N, 3, W); memory (R, W) is changed."""
    n_hidden, n_in, n_out = len(shape[0]), len(shape[2]), len(shape[3])
    n_features, n_past, n_state = n_in + n_out, n_in - 1, n_in - 1 + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    u_s, u_f = load(lanes, rates, (k, 0, 0)), load(lanes, rates, (k, 1, 0))
    u_t = load(lanes, rates, (k, 2, 0))
    if coupled:
        # extrapolated to the time of the sample, as in `narx.kernels.coupled_tile`
        at_s, at_f = PAST + n_past, PAST + n_state + n_past
        ahead_s, ahead_f = load(lanes, memory, (at_s, 0)), load(lanes, memory, (at_f, 0))
        if n_out > 1:
            ahead_s = ahead_s + (ahead_s - load(lanes, memory, (at_s + 1, 0)))
            ahead_f = ahead_f + (ahead_f - load(lanes, memory, (at_f + 1, 0)))
        posture_s = load(lanes, memory, (POSTURE, 0))
        posture_f = load(lanes, memory, (POSTURE + 1, 0))
        u_s, u_f, u_t, _ = turned(
            u_s,
            u_f,
            u_t,
            scales[0, ANGLE_SCALE] * ahead_s + scales[0, ANGLE_OFFSET] + posture_s,
            scales[1, ANGLE_SCALE] * ahead_f + scales[1, ANGLE_OFFSET] + posture_f,
        )
    turning = (u_s, u_f, u_t)
    for axis in range(3):
        scale, at = scales[axis], PAST + axis * n_state
        present = (turning[axis] - scale[RATE_OFFSET]) / scale[RATE_SCALE]
        out = splat(lanes, weights[slope + n_hidden])
        for j in range(n_hidden):
            z = splat(lanes, weights[bias + j])
            for m in range(n_out - 1, -1, -1):
                past = load(lanes, memory, (at + n_past + m, 0))
                z = z + weights[j * n_features + n_in + m] * past
            for i in range(n_past, 0, -1):
                z = z + weights[j * n_features + i] * load(lanes, memory, (at + i - 1, 0))
            z = z + weights[j * n_features] * present
            out = out + weights[slope + j] * tanh(z)
        for i in range(n_state - 1, 0, -1):
            store(lanes, memory, (at + i, 0), load(lanes, memory, (at + i - 1, 0)))
        if n_past > 0:
            store(lanes, memory, (at, 0), present)
        store(lanes, memory, (at + n_past, 0), out)
        deviation = scale[ANGLE_SCALE] * out + scale[ANGLE_OFFSET]
        mean = load(lanes, memory, (MEAN + axis, 0))
        mean = mean + gain * (deviation - mean)
        store(lanes, memory, (MEAN + axis, 0), mean)
        angle = deviation + load(lanes, memory, (POSTURE + axis, 0)) - mean
        store(lanes, angles, (k, axis, 0), angle)


@compiled(**JIT)
def run_method(
    first: Any,
    samples: Any,
    interval: float,
    start_up: Any,
    weights: Any,
    scales: Any,
    gain: float,
    coupled: bool,
    start: Any,
    taken_over: Any,
    memory: Any,
    deviation: Any,
    angles: Any,
    starting: Any,
    shape: Any,
) -> None:
    """Advance B sensors; sensor b has the samples ``first[b]`` to ``first[b + 1]``.

    start_up: its parameters, as for `run_start_up`. Changed in place: start (B, 14),
    taken_over (B,), memory (B, R, 1). Filled: angles (M, 3), starting (M,).
    """
    rates, estimated = samples.reshape(len(samples), 3, 1), angles.reshape(len(samples), 3, 1)
    for b in range(len(first) - 1):
        begin, end = first[b], first[b + 1]
        if begin < end and not taken_over[b]:
            taken = run_start_up(
                samples[begin:end],
                interval,
                start_up[0],
                start_up[1],
                start_up[2],
                start_up[3],
                start_up[4],
                start_up[5],
                coupled,
                start[b],
                angles[begin:end],
            )
            starting[begin : begin + taken] = True
            begin += taken
            if begin < end:
                taken_over[b] = True
                start_network(start[b], interval, scales, len(shape[2]) - 1, deviation, memory[b])
        for k in range(begin, end):
            network_step(
                weights, scales, gain, coupled, rates, k, memory[b], estimated, shape, SCALAR
            )
