"""Interpolation over a short gap for `narx.kernels.tracker`."""

import math
from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled

# over a shorter gap than this the rates are interpolated linearly
LONGEST_BRIDGED_S = 0.35
# standard deviation of the interpolated angle, divided by the square of the gap: the root
# mean square of thighs and shanks in walking: 130 and 250 deg/s^2 about the sagittal axis
BRIDGED_RAD_S2 = math.radians(200.0)


@compiled(**EXACT_VIEWS)
def interpolate(gap: float, interval: float, now: Any, rates: Any, past: Any, means: Any) -> None:
    """Continue past rates and angles (3, lags) to the end of a gap whose rates become linear.

    now (3,): rates at the first sample after the gap, one interval after its end. Filled: means
    (2, 3), mean angle and mean rate of the ticks in the gap.
    """
    whole = gap + interval
    for axis in range(3):
        last, begin = rates[axis, 0], past[axis, 0]
        slope = (now[axis] - last) / whole
        means[0, axis] = begin + 0.5 * whole * (last + slope * (whole + gap) / 6.0)
        means[1, axis] = last + 0.5 * whole * slope
        for i in range(past.shape[1]):
            at = gap - i * interval
            past[axis, i] = begin + at * (last + 0.5 * slope * at)
        for i in range(rates.shape[1]):
            rates[axis, i] = last + slope * (gap - i * interval)
