"""The start-up's recursion, sample by sample (`narx.inference.start_up` explains it)."""

import numba
import numpy as np

from narx.kernels.euler import COS_FRONTAL_MIN

# time constant and threshold of what counts as movement: root mean square of the rates over
# about a second, which sway in standing stays far below
MOVEMENT_TIME_CONSTANT_S = 1.0
MOVEMENT_RAD_S = 0.35


@numba.njit(cache=True, nogil=True)
def run_start_up(  # type: ignore[no-untyped-def]
    rates,
    interval,
    duration,
    averaged_from,
    averaging,
    leak,
    gain,
    settling,
    coupled,
    state,
    angles,
):
    """Advance the state and fill the angles; returns how many samples the start-up took."""
    known = state[13] > 0.0
    rate, tilt = np.empty(3), np.empty(3)
    for k in range(len(rates)):
        if state[11] >= duration:
            return k
        if coupled:
            # extrapolated to the time of the sample: with the tilt of the sample before, the
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
            rate[:] = rates[k]
        state[10] += interval
        square = rates[k, 0] ** 2 + rates[k, 1] ** 2 + rates[k, 2] ** 2
        state[12] += (square - state[12]) * interval / (MOVEMENT_TIME_CONSTANT_S + interval)
        if state[12] > MOVEMENT_RAD_S**2:
            state[11] += interval
        damping = 1.0
        if not known:
            damping += interval * (leak + gain / (state[10] + settling))
        weight = 0.0
        into = state[11] - averaged_from
        if 0.0 < into < averaging:
            weight = np.sin(np.pi * into / averaging) ** 2
        for axis in range(3):
            step = 0.5 * interval * (rate[axis] + state[3 + axis])
            state[axis] = (state[axis] + step) / damping
            state[3 + axis] = rate[axis]
            state[6 + axis] += weight * state[axis]
            angles[k, axis] = state[axis]
        state[9] += weight
    return len(rates)
