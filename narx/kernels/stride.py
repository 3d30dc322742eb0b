"""Stride frequency sample by sample, for `narx.gait.stride_frequency.StrideFrequencyTracker`."""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled

# RMS below which there is no walking: a third of that of the slowest gait (about 0.5 rad/s)
MINIMUM_RMS_RAD_S = 0.15

# low-passed rate, its mean square, stride time, time since the last crossing, whether the rate has
# been below zero since, whether there has been a stride
TrackerState = tuple[float, float, float, float, bool, bool]


def track(
    state: TrackerState, sagittal_rate_rad_s: float, constants: tuple[float, ...]
) -> TrackerState:
    """Process one sample; plain arithmetic, so that its operations can be counted."""
    before, mean_square, stride_s, since_s, armed, seen = state
    interval_s, low_pass, mean_square_gain, shortest_s, longest_s, smoothing = constants
    rate = before + low_pass * (sagittal_rate_rad_s - before)
    mean_square = mean_square + mean_square_gain * (rate * rate - mean_square)
    since_s = since_s + interval_s
    if rate < 0.0:
        return rate, mean_square, stride_s, since_s, True, seen
    threshold_square = max(0.25 * mean_square, MINIMUM_RMS_RAD_S * MINIMUM_RMS_RAD_S)
    if armed and rate * rate > threshold_square:
        armed = False
        # the crossing lies between the two samples
        past = (rate - threshold_square**0.5) / max(rate - before, 1e-12)
        past_s = interval_s * min(1.0, past)
        lasted_s = since_s - past_s
        since_s = past_s
        if shortest_s <= lasted_s <= longest_s:
            weight = smoothing if seen else 1.0
            seen = True
            stride_s = stride_s + weight * (lasted_s - stride_s)
    return rate, mean_square, stride_s, since_s, armed, seen


_track = compiled(**EXACT_INNER)(track)


@compiled(**EXACT)
def track_all(rate: Any, state: TrackerState, constants: tuple[float, ...]) -> Any:
    """Stride frequency in Hz at each sample of rate (N,), rad/s."""
    out = np.empty(len(rate))
    for k in range(len(rate)):
        state = _track(state, rate[k], constants)
        out[k] = 1.0 / state[2]
    return out
