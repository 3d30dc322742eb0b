"""Network and Kalman filter in one recurrence: angles, mean posture, and gyroscope bias.

The network propagates the angles from sample to sample during walking; a small Kalman filter
estimates their covariance, and corrects angles, posture and bias once per swing of the leg.
`narx.inference.tracker.PostureTracker` has the model and the parameters.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled
from narx.kernels.kalman import measure, spread
from narx.kernels.limits import COS_FRONTAL_MIN

# states of the filter; the last two only with an accelerometer
ANGLES, CENTRE, BIAS, LEAN, VELOCITY = 0, 3, 6, 9, 10
GYROSCOPE_STATES, AIDED_STATES = 10, 12
# centre, bias and lean are constant from sample to sample
CONSTANT = VELOCITY - CENTRE

# further scalars: turn rate, swing and its turning points, timers, sums over the swing, rest
(
    TURN, SWING, HIGH, LOW, SPAN, RISING, SINCE, IDLE, PERIOD, TRUST, SCATTER, MISSING, SAMPLES,
) = range(13)  # fmt: skip
SUM_ANGLES, SUM_TURN, BEFORE, ODD, MEAN_RATE, KNOWN = 13, 16, 17, 19, 22, 25
SCALARS = 26

# parameters; rates are per sample
(
    INTERVAL, LEAK, ANGLE_NOISE, RATE_NOISE, CENTRE_DECAY, CENTRE_NOISE, BIAS_NOISE,
    START_VARIANCE, KNOWN_ENOUGH, TURN_GAIN, TURN_LEAST, SWING_DECAY, SPAN_DECAY, SPAN_SHARE,
    SWING_LEAST, IDLE_MOST,
    RETURN_VARIANCE, PERIOD_SHARE, OUTLIER, EARLY, REST_GAIN, REST_LEAST, REST_VARIANCE,
    VELOCITY_NOISE, SPEED, RATE_SCALE, ANGLE_SCALE,
) = range(27)  # fmt: skip
CYCLE_VARIANCE, VELOCITY_VARIANCE = 27, 30
PARAMETERS = 32

SHORTEST_SWING_S, LONGEST_SWING_S = 0.5, 2.5
# a longer gap leaves no more of the angle than this one
LONGEST_GAP_S = 1.0
# larger than the bias of any current gyroscope
MOST_BIAS_RAD_S = math.radians(10.0)


@compiled(**EXACT_INNER)
def _propagate(covariance: Any, change: Any, decay: float, moved: Any) -> None:
    """Propagate the covariance over one sample: x <- (1 + change) x, two centres times `decay`."""
    n = len(covariance)
    if decay != 1.0:
        for i in range(CENTRE, CENTRE + 2):
            for j in range(n):
                covariance[i, j] *= decay
                covariance[j, i] *= decay
    # only angles and velocity change; half of the products, since the matrix is symmetric
    n_moving = n - CONSTANT
    for row in range(n_moving):
        i = row if row < CENTRE else row + CONSTANT
        moved[row] = 0.0
        for k in range(n):
            if change[i, k] != 0.0:
                for j in range(n):
                    moved[row, j] += change[i, k] * covariance[k, j]
    for row in range(n_moving):
        i = row if row < CENTRE else row + CONSTANT
        for j in range(CENTRE, VELOCITY):
            covariance[i, j] += moved[row, j]
            covariance[j, i] = covariance[i, j]
        for other in range(row + 1):
            j = other if other < CENTRE else other + CONSTANT
            total = moved[row, j] + moved[other, i]
            for k in range(n):
                if change[j, k] != 0.0:
                    total += moved[row, k] * change[j, k]
            covariance[i, j] += total
            covariance[j, i] = covariance[i, j]


@compiled(**EXACT_INNER)
def _network(
    weights: Any, n_hidden: int, rate: float, rates: Any, past: Any, about: float, p: Any
) -> float:
    """One output of the network about a posture; rates and angles before, newest first.

    Without hidden neurons `weights` are the coefficients of a linear recursion, in s and 1.
    """
    n_in, n_out = len(rates) + 1, len(past)
    if n_hidden == 0:
        linear = weights[0] * rate
        for i in range(n_in - 1):
            linear += weights[1 + i] * rates[i]
        for i in range(n_out):
            linear += weights[n_in + i] * (past[i] - about)
        return linear
    width = n_in + n_out
    first_bias, second = n_hidden * width, n_hidden * (width + 1)
    total = weights[-1]
    for h in range(n_hidden):
        at = h * width
        argument = weights[first_bias + h] + weights[at] * (rate / p[RATE_SCALE])
        for i in range(n_in - 1):
            argument += weights[at + 1 + i] * (rates[i] / p[RATE_SCALE])
        for i in range(n_out):
            argument += weights[at + n_in + i] * ((past[i] - about) / p[ANGLE_SCALE])
        total += weights[second + h] * math.tanh(argument)
    return total * p[ANGLE_SCALE]


@compiled(**EXACT_INNER)
def _advance(
    own: Any,
    x: Any,
    s: Any,
    p: Any,
    weights: Any,
    n_hidden: int,
    rates: Any,
    past: Any,
    works: bool,
) -> tuple[float, float]:
    """Propagate the angles over one sample; return turn rate and cosine of the frontal angle.

    own (3,): gyroscope without bias; rates and past (3, lags): past rates of the angles and past
    angles, newest first. Without the network, the trapezoidal rule is used.
    """
    dt = p[INTERVAL]
    n_out = past.shape[1]
    n_past = len(weights) - 1 - n_out
    if n_hidden > 0:
        # hidden neurons have two weights more than features; one output bias
        n_past = (len(weights) - 1) // n_hidden - 3 - n_out
    tilt = np.empty(2)
    for axis in range(2):
        # extrapolated to the time of the sample: a lag would act like a bias
        tilt[axis] = 2.0 * past[axis, 0] - past[axis, 1] if n_out > 1 else past[axis, 0]
    sin_s, cos_s = math.sin(tilt[0]), math.cos(tilt[0])
    sin_f, cos_f = math.sin(tilt[1]), math.cos(tilt[1])
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0.0 else COS_FRONTAL_MIN
    turn = (own[2] * cos_s - own[1] * sin_s) / cos_f
    s[TURN] += p[TURN_GAIN] * (turn - s[TURN])
    for axis in range(3):
        rate = turn
        if axis == 0:
            rate = own[0] - sin_f * turn
        elif axis == 1:
            rate = own[1] * cos_s + own[2] * sin_s
        if works:
            about = x[CENTRE + axis] + (x[LEAN] * s[TURN] if axis == 1 else 0.0)
            angle = about + _network(
                weights, n_hidden, rate, rates[axis, :n_past], past[axis], about, p
            )
        else:
            angle = past[axis, 0] + 0.5 * dt * (rate + rates[axis, 0])
        for i in range(rates.shape[1] - 1, 0, -1):
            rates[axis, i] = rates[axis, i - 1]
        rates[axis, 0] = rate
        x[axis] = angle
    return turn, cos_f


@compiled(**EXACT_INNER)
def _swing_ends(own_sagittal: float, s: Any, p: Any) -> bool:
    """Track the swing of the leg; return True when a forward swing has just reversed."""
    s[SWING] = (s[SWING] + p[INTERVAL] * own_sagittal) / p[SWING_DECAY]
    s[HIGH], s[LOW] = max(s[HIGH], s[SWING]), min(s[LOW], s[SWING])
    s[SPAN] *= p[SPAN_DECAY]
    least = max(p[SPAN_SHARE] * s[SPAN], p[SWING_LEAST])
    if s[RISING] == 0.0 and s[SWING] - s[LOW] > least:
        s[RISING], s[HIGH] = 1.0, s[SWING]
    if s[RISING] == 0.0 or s[HIGH] - s[SWING] <= least:
        return False
    s[SPAN] = max(s[SPAN], s[HIGH] - s[LOW])
    s[RISING], s[LOW] = 0.0, s[SWING]
    return True


@compiled(**EXACT_INNER)
def _learn_from_swing(x: Any, covariance: Any, s: Any, p: Any, work: Any) -> None:
    """Update by a swing: its mean angle measures the posture, less noisily if it resembles gait."""
    direction = work[0]
    turn = s[SUM_TURN] / s[SAMPLES]
    if abs(turn) > p[TURN_LEAST]:
        # a person who turns does not return to the previous heading
        covariance[CENTRE + 2, CENTRE + 2] += (turn * s[SINCE]) ** 2
    net = (x[0] - s[BEFORE]) ** 2 + (x[1] - s[BEFORE + 1]) ** 2
    doubt = 1.0 + net / p[RETURN_VARIANCE]
    doubt += ((s[SINCE] / s[PERIOD] - 1.0) / p[PERIOD_SHARE]) ** 2 if s[PERIOD] > 0.0 else 3.0
    for axis in range(3):
        direction[:] = 0.0
        direction[axis], direction[CENTRE + axis] = 1.0, -1.0
        about = x[CENTRE + axis]
        if axis == 1:
            direction[LEAN] = -turn
            about += x[LEAN] * turn
        residual = about - s[SUM_ANGLES + axis] / s[SAMPLES]
        variance = p[CYCLE_VARIANCE + axis] * doubt
        expected = spread(covariance, direction, work[1]) + variance
        excess = residual**2 / (p[OUTLIER] * expected)
        if excess <= 1.0:
            s[ODD + axis] = 0.0
        elif s[ODD + axis] * residual > 0.0:
            # two outliers in a row with the same sign: the posture has changed, or was wrong before
            share = p[EARLY] / (p[EARLY] + s[TRUST])
            covariance[axis, axis] += residual**2 * share
            covariance[CENTRE + axis, CENTRE + axis] += residual**2 * (1.0 - share)
            s[ODD + axis] = 0.0
        else:
            s[ODD + axis] = math.copysign(1.0, residual)
            continue
        measure(x, covariance, work, variance, residual)
    s[TRUST] += 1.0 / doubt


@compiled(**EXACT_INNER)
def _level(x: Any, force: Any) -> tuple[float, float, float, float]:
    """Horizontal specific force, forward and left, and its derivatives by the two tilt angles."""
    sin_s, cos_s, sin_f, cos_f = math.sin(x[0]), math.cos(x[0]), math.sin(x[1]), math.cos(x[1])
    up = sin_s * force[0] + cos_s * force[2]
    forward = cos_s * force[0] - sin_s * force[2]
    left = cos_f * force[1] + sin_f * up
    return forward, left, -up, cos_f * up - sin_f * force[1]


@compiled(**EXACT_INNER)
def step(
    axis_rates: Any,
    force: Any,
    x: Any,
    covariance: Any,
    s: Any,
    p: Any,
    weights: Any,
    n_hidden: int,
    rates: Any,
    past: Any,
    work: Any,
    change: Any,
    moved: Any,
) -> bool:
    """Advance by a valid sample; return whether the network propagated the angles."""
    n, dt = len(x), p[INTERVAL]
    aided = n == AIDED_STATES
    if s[MISSING] > 0.0:
        # the motion during the gap is unknown, except that legs return to their posture
        for axis in range(3):
            covariance[axis, axis] += p[START_VARIANCE] * min(s[MISSING], LONGEST_GAP_S) ** 2
        s[MISSING], s[RISING], s[SWING], s[HIGH], s[LOW] = 0.0, 0.0, 0.0, 0.0, 0.0
        s[SINCE : IDLE + 1], s[PERIOD], s[SUM_ANGLES:BEFORE], s[SAMPLES] = 0.0, 0.0, 0.0, 0.0
        s[IDLE] = p[IDLE_MOST]
    own, carried, direction = work[2, :3], work[2, 3:6], work[0]
    square, scatter, mean_square = 0.0, 0.0, 0.0
    for axis in range(3):
        own[axis] = axis_rates[axis] - x[BIAS + axis]
        square += own[axis] ** 2
        away = axis_rates[axis] - s[MEAN_RATE + axis]
        s[MEAN_RATE + axis] += p[REST_GAIN] * away
        scatter += away**2
    s[SCATTER] += p[REST_GAIN] * (scatter - s[SCATTER])
    works = s[IDLE] < p[IDLE_MOST] and (
        max(covariance[CENTRE, CENTRE], covariance[CENTRE + 1, CENTRE + 1]) < p[KNOWN_ENOUGH]
    )
    turn, cos_f = _advance(own, x, s, p, weights, n_hidden, rates, past, works)
    if abs(x[0]) > math.pi:
        whole = math.copysign(2.0 * math.pi, x[0])
        x[0] -= whole
        past[0] -= whole
    carried[:] = x[:3]
    # with a known start the estimated posture does not decay to zero, and the heading never does
    decay, noise = (1.0, 0.0) if s[KNOWN] > 0.0 else (p[CENTRE_DECAY], p[CENTRE_NOISE])
    leak = p[LEAK] * dt if works else 0.0
    coupling = dt * s[TURN] if abs(s[TURN]) > p[TURN_LEAST] else 0.0
    for axis in range(3):
        change[axis, axis], change[axis, CENTRE + axis] = -leak, leak
        change[axis, BIAS + axis] = -dt
    for axis in range(2):
        x[CENTRE + axis] *= decay
    change[0, 1], change[1, 0], change[1, LEAN] = -coupling, coupling, leak * s[TURN]
    if aided:
        forward, left, by_sagittal, by_frontal = _level(x, force)
        ahead, aside = x[VELOCITY], x[VELOCITY + 1]
        x[VELOCITY] += dt * (forward + turn * aside)
        x[VELOCITY + 1] += dt * (left - turn * ahead)
        change[VELOCITY, 0], change[VELOCITY, VELOCITY + 1] = dt * by_sagittal, dt * turn
        change[VELOCITY + 1, 1], change[VELOCITY + 1, VELOCITY] = dt * by_frontal, -dt * turn
    _propagate(covariance, change, decay, moved)
    for axis in range(3):
        covariance[axis, axis] += p[ANGLE_NOISE] + p[RATE_NOISE] * square / cos_f**2
        covariance[BIAS + axis, BIAS + axis] += p[BIAS_NOISE]
    for axis in range(2):
        covariance[CENTRE + axis, CENTRE + axis] += noise
    for i in range(VELOCITY, n):
        covariance[i, i] += p[VELOCITY_NOISE]
    for axis in range(3):
        mean_square += s[MEAN_RATE + axis] ** 2
    if s[SCATTER] < p[REST_LEAST] and mean_square < MOST_BIAS_RAD_S**2:
        for axis in range(3):
            direction[:] = 0.0
            direction[BIAS + axis] = 1.0
            residual = s[MEAN_RATE + axis] - x[BIAS + axis]
            measure(x, covariance, work, p[REST_VARIANCE], residual)
    s[SINCE] += dt
    s[IDLE] += dt
    s[SAMPLES] += 1.0
    s[SUM_TURN] += turn
    for axis in range(3):
        s[SUM_ANGLES + axis] += carried[axis]
    for i in range(VELOCITY, n):
        direction[:] = 0.0
        direction[i] = 1.0
        usual = p[SPEED] if i == VELOCITY else 0.0
        measure(x, covariance, work, p[VELOCITY_VARIANCE + i - VELOCITY], usual - x[i])
    if _swing_ends(own[0], s, p):
        swung = SHORTEST_SWING_S < s[SINCE] < LONGEST_SWING_S
        if swung:
            _learn_from_swing(x, covariance, s, p, work)
            if s[ODD] == 0.0 and s[ODD + 1] == 0.0:
                s[IDLE] = 0.0
        s[PERIOD] = s[SINCE] if swung else 0.0
        s[SINCE], s[SAMPLES], s[SUM_ANGLES:BEFORE] = 0.0, 0.0, 0.0
        s[BEFORE], s[BEFORE + 1] = x[0], x[1]
    for axis in range(3):
        # a correction is not a movement: past angles are shifted by the same amount
        correction = x[axis] - carried[axis]
        for i in range(past.shape[1] - 1, 0, -1):
            past[axis, i] = past[axis, i - 1] + correction
        past[axis, 0] = x[axis]
    return works


@compiled(**EXACT)
def track(
    axis_rates: Any,
    force: Any,
    x: Any,
    covariance: Any,
    s: Any,
    p: Any,
    weights: Any,
    n_hidden: int,
    rates: Any,
    past: Any,
    angles: Any,
    variances: Any,
    works: Any,
) -> None:
    """Advance over samples (N, 3), NaN where missing; fill angles, their variances, and works.

    x (n,), covariance (n, n), s (SCALARS,), rates and past (3, lags) are the state, changed in
    place; p (PARAMETERS,) is from `narx.inference.tracker`.
    """
    n = len(x)
    work, change, moved = np.zeros((3, n)), np.zeros((n, n)), np.zeros((n, n))
    for k in range(len(axis_rates)):
        there = True
        for axis in range(3):
            there &= math.isfinite(axis_rates[k, axis])
            if len(x) == AIDED_STATES:
                there &= math.isfinite(force[k, axis])
        if not there:
            s[MISSING] += p[INTERVAL]
            angles[k] = math.nan
            variances[k] = math.nan
            works[k] = False
            continue
        works[k] = step(
            axis_rates[k],
            force[k],
            x,
            covariance,
            s,
            p,
            weights,
            n_hidden,
            rates,
            past,
            work,
            change,
            moved,
        )
        for axis in range(3):
            angles[k, axis] = x[axis]
            variances[k, axis] = covariance[axis, axis]
