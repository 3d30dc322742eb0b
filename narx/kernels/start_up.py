"""The first seconds, before the network takes over: integrate, and average the posture.

The method is described in `narx.inference.start_up`.
"""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, compiled
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.transfer import copy_row

# layout of the state, after angles, rates and weighted sum of angles (three each)
POSTURE_WEIGHT, TIME_S, MOVING_S, MEAN_SQUARE, KNOWN = 9, 10, 11, 12, 13
STATE_SIZE = 14

# time constant and threshold of movement: root mean square of the rates over about a second, far
# above that of sway in standing
MOVEMENT_TIME_CONSTANT_S = 1.0
MOVEMENT_RAD_S = 0.35


@compiled(**EXACT)
def run_start_up(
    rates: Any,
    interval: float,
    duration: float,
    averaged_from: float,
    averaging: float,
    leak: float,
    gain: float,
    settling: float,
    coupled: bool,
    state: Any,
    angles: Any,
) -> int:
    """Fill angles (N, 3) from rates (N, 3) until there was enough movement; return their number.

    state (14,), created by `narx.inference.start_up.StartUp.begin`, is changed in place.
    """
    known = state[KNOWN] > 0.0
    rate, tilt = np.empty(3), np.empty(3)
    for k in range(len(rates)):
        if state[MOVING_S] >= duration:
            return k
        if coupled:
            # extrapolated to the time of the sample: with the tilt of the previous sample, the
            # lag would add up to degrees per minute
            for axis in range(3):
                tilt[axis] = state[axis] + interval * state[3 + axis]
            sin_s, cos_s = np.sin(tilt[0]), np.cos(tilt[0])
            sin_f, cos_f = np.sin(tilt[1]), np.cos(tilt[1])
            if abs(cos_f) < COS_FRONTAL_MIN:
                cos_f = -COS_FRONTAL_MIN if cos_f < 0 else COS_FRONTAL_MIN
            rate[2] = (rates[k, 2] * cos_s - rates[k, 1] * sin_s) / cos_f
            rate[1] = rates[k, 1] * cos_s + rates[k, 2] * sin_s
            rate[0] = rates[k, 0] - sin_f * rate[2]
        else:
            copy_row(rates[k], rate)
        state[TIME_S] += interval
        square = rates[k, 0] ** 2 + rates[k, 1] ** 2 + rates[k, 2] ** 2
        change = (square - state[MEAN_SQUARE]) * interval / (MOVEMENT_TIME_CONSTANT_S + interval)
        state[MEAN_SQUARE] += change
        if state[MEAN_SQUARE] > MOVEMENT_RAD_S**2:
            state[MOVING_S] += interval
        damping = 1.0
        if not known:
            damping += interval * (leak + gain / (state[TIME_S] + settling))
        weight = 0.0
        into = state[MOVING_S] - averaged_from
        if 0.0 < into < averaging:
            weight = np.sin(np.pi * into / averaging) ** 2
        for axis in range(3):
            step = 0.5 * interval * (rate[axis] + state[3 + axis])
            state[axis] = (state[axis] + step) / damping
            state[3 + axis] = rate[axis]
            state[6 + axis] += weight * state[axis]
            angles[k, axis] = state[axis]
        state[POSTURE_WEIGHT] += weight
    return len(rates)


@compiled(**EXACT)
def split_for_network(
    state: Any, interval: float, posture: Any, deviation: Any, earlier: Any
) -> None:
    """Fill the network's initial values (3,): posture, deviation from it now and a sample ago."""
    known = state[KNOWN] > 0.0 and state[POSTURE_WEIGHT] != 0.0
    for axis in range(3):
        posture[axis] = state[6 + axis] / state[POSTURE_WEIGHT] if known else 0.0
        deviation[axis] = state[axis] - posture[axis]
        earlier[axis] = deviation[axis] - interval * state[3 + axis]
