"""Start-up, network and washout, sample by sample, for many sensors in sequence."""

from typing import Any

from narx.kernels.compiler import INNER, JIT, compiled
from narx.kernels.functions import sine_cosine, tanh
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.start_up import run_start_up, split_for_network

# columns of the scales (3 axes, 4)
RATE_OFFSET, RATE_SCALE, ANGLE_OFFSET, ANGLE_SCALE = 0, 1, 2, 3


@compiled(**INNER)
def turned(u_s: float, u_f: float, u_t: float, sagittal: float, frontal: float) -> Any:
    """Rates of the angles from those of the gyroscope, as `narx.kernels.euler.angle_rates`."""
    sin_s, cos_s = sine_cosine(sagittal, None)
    sin_f, cos_f = sine_cosine(frontal, None)
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0.0 else COS_FRONTAL_MIN
    heading = (u_t * cos_s - u_f * sin_s) / cos_f
    return u_s - sin_f * heading, u_f * cos_s + u_t * sin_s, heading


@compiled(**INNER)
def start_network(
    start: Any, interval: float, scales: Any, n_past: int, posture: Any, deviation: Any, state: Any
) -> None:
    """Set the network's state as if it had run during the start-up; deviation (2, 3)."""
    split_for_network(start, interval, posture, deviation[0], deviation[1])
    for axis in range(3):
        scale = scales[axis]
        for i in range(n_past):
            state[axis, i] = (start[3 + axis] - scale[RATE_OFFSET]) / scale[RATE_SCALE]
        for m in range(n_past, state.shape[1]):
            followed = deviation[0 if m == n_past else 1, axis]
            state[axis, m] = (followed - scale[ANGLE_OFFSET]) / scale[ANGLE_SCALE]


@compiled(**JIT)
def run_network(
    weights: Any,
    scales: Any,
    gain: float,
    coupled: bool,
    rates: Any,
    posture: Any,
    state: Any,
    mean: Any,
    angles: Any,
    shape: Any,
) -> None:
    """Run network and washout over rates (N, 3); state (3, S) and mean (3,) are changed."""
    n_hidden, n_in, n_out = len(shape[0]), len(shape[2]), len(shape[3])
    n_features, n_past, n_state = n_in + n_out, n_in - 1, n_in - 1 + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    for k in range(len(rates)):
        u_s, u_f, u_t = rates[k, 0], rates[k, 1], rates[k, 2]
        if coupled:
            # extrapolated to the time of the sample, as in `narx.kernels.coupled_tile`
            ahead_s, ahead_f = state[0, n_past], state[1, n_past]
            if n_out > 1:
                ahead_s += ahead_s - state[0, n_past + 1]
                ahead_f += ahead_f - state[1, n_past + 1]
            u_s, u_f, u_t = turned(
                u_s,
                u_f,
                u_t,
                scales[0, ANGLE_SCALE] * ahead_s + scales[0, ANGLE_OFFSET] + posture[0],
                scales[1, ANGLE_SCALE] * ahead_f + scales[1, ANGLE_OFFSET] + posture[1],
            )
        turning = (u_s, u_f, u_t)
        for axis in range(3):
            scale = scales[axis]
            present = (turning[axis] - scale[RATE_OFFSET]) / scale[RATE_SCALE]
            out = weights[slope + n_hidden]
            for j in range(n_hidden):
                z = weights[bias + j]
                for m in range(n_out - 1, -1, -1):
                    z += weights[j * n_features + n_in + m] * state[axis, n_past + m]
                for i in range(n_past, 0, -1):
                    z += weights[j * n_features + i] * state[axis, i - 1]
                z += weights[j * n_features] * present
                out += weights[slope + j] * tanh(z)
            for i in range(n_state - 1, 0, -1):
                state[axis, i] = state[axis, i - 1]
            if n_past > 0:
                state[axis, 0] = present
            state[axis, n_past] = out
            deviation = scale[ANGLE_SCALE] * out + scale[ANGLE_OFFSET]
            mean[axis] += gain * (deviation - mean[axis])
            angles[k, axis] = deviation + posture[axis] - mean[axis]


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
    posture: Any,
    deviation: Any,
    state: Any,
    mean: Any,
    angles: Any,
    starting: Any,
    shape: Any,
) -> None:
    """Advance B sensors; sensor b has the samples ``first[b]`` to ``first[b + 1]``.

    start_up: its parameters, as for `run_start_up`. Changed in place: start (B, 14),
    taken_over (B,), posture (B, 3), state (B, 3, S), mean (B, 3). Filled: angles (M, 3), starting
    (M,).
    """
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
                start_network(
                    start[b], interval, scales, len(shape[2]) - 1, posture[b], deviation, state[b]
                )
        if begin < end:
            run_network(
                weights, scales, gain, coupled, samples[begin:end], posture[b], state[b], mean[b],
                angles[begin:end], shape,
            )  # fmt: skip
