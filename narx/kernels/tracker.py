"""Network and Kalman filter in one recurrence: angles, mean posture, and gyroscope bias.

The network propagates the angles from sample to sample during walking; a small Kalman filter
estimates their covariance, and corrects angles, posture and bias once per swing of the leg.
`narx.inference.tracker.PostureTracker` has the model and the parameters.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled
from narx.kernels.functions import sine_cosine
from narx.kernels.kalman import DIRECTION, measure, measure_state, spread
from narx.kernels.leg import std_growth
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.network_step import OUTPUT, three_outputs
from narx.kernels.short_gap import BRIDGED_RAD_S2, LONGEST_BRIDGED_S, interpolate
from narx.kernels.tracker_covariance import (
    AIDED_STATES,
    BIAS,
    CENTRE,
    CHANGE,
    CONSTANT,
    LEAN,
    VELOCITY,
    propagate,
)

# further scalars: turn rate, swing and its turning points, timers, sums over the swing, rest
(
    TURN, SWING, HIGH, LOW, SPAN, RISING, SINCE, IDLE, PERIOD, TRUST, SCATTER, MISSING, SAMPLES,
) = range(13)  # fmt: skip
SUM_ANGLES, SUM_TURN, BEFORE, ODD, MEAN_RATE, KNOWN = 13, 16, 17, 19, 22, 25
# means of the square and the cube of the sagittal rate in walking
SQUARE, CUBE = 26, 27
SCALARS = 28

# parameters; rates are per sample
(
    INTERVAL, LEAK, ANGLE_NOISE, RATE_NOISE, CENTRE_DECAY, CENTRE_NOISE, BIAS_NOISE,
    START_VARIANCE, KNOWN_ENOUGH, TURN_GAIN, TURN_LEAST, SWING_DECAY, SPAN_DECAY, SPAN_SHARE,
    SWING_LEAST, IDLE_MOST,
    RETURN_VARIANCE, PERIOD_SHARE, OUTLIER, EARLY, REST_GAIN, REST_LEAST, REST_VARIANCE,
    VELOCITY_NOISE, SPEED, RATE_SCALE, ANGLE_SCALE,
) = range(27)  # fmt: skip
CYCLE_VARIANCE, VELOCITY_VARIANCE, LEG_GAIN = 27, 30, 32
PARAMETERS = 33

# rows of the intermediate results of `step`, after those of the functions that it calls
OWN, CARRIED, ABOUT, NOW, MEANS = 3, 4, 6, 7, 8

SHORTEST_SWING_S, LONGEST_SWING_S = 0.5, 2.5
# a swing with more doubt, while the angle is known, is a change of posture such as sitting down
MOST_DOUBT = 50.0
# once the posture is established, an angle so far from it is not that of a walking leg
FAR_RAD = math.radians(50.0)
# a longer gap leaves no more of the angle than this one
LONGEST_GAP_S = 1.0
# larger than the bias of any current gyroscope
MOST_BIAS_RAD_S = math.radians(10.0)


@compiled(**EXACT_INNER)
def _rates_of_angles(sagittal: float, frontal: float, work: Any) -> float:
    """Fill work[NOW] with the rates of the angles; return the cosine of the frontal angle."""
    sin_s, cos_s = sine_cosine(sagittal, None)
    sin_f, cos_f = sine_cosine(frontal, None)
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0.0 else COS_FRONTAL_MIN
    turn = (work[OWN, 2] * cos_s - work[OWN, 1] * sin_s) / cos_f
    work[NOW, 0] = work[OWN, 0] - sin_f * turn
    work[NOW, 1] = work[OWN, 1] * cos_s + work[OWN, 2] * sin_s
    work[NOW, 2] = turn
    return float(cos_f)


@compiled(**EXACT_INNER)
def _bridge(x: Any, covariance: Any, s: Any, p: Any, rates: Any, past: Any, work: Any) -> None:
    """Interpolate over a short gap, up to the sample before the present one."""
    dt, gap = p[INTERVAL], s[MISSING]
    _rates_of_angles(past[0, 0], past[1, 0], work)
    last, means = rates[0, 0], work[MEANS : MEANS + 2]
    interpolate(gap, dt, work[NOW], rates, past, means)
    n_lost, swing_time = gap / dt, dt / (p[SWING_DECAY] - 1.0)
    kept = math.exp(-gap / swing_time)
    s[SWING] = kept * s[SWING] + (1.0 - kept) * swing_time * 0.5 * (last + rates[0, 0])
    for axis in range(3):
        x[axis] = past[axis, 0]
        covariance[axis, axis] += (BRIDGED_RAD_S2 * gap**2) ** 2
        s[SUM_ANGLES + axis] += n_lost * means[0, axis]
    s[SUM_TURN] += n_lost * means[1, 2]
    s[SAMPLES] += n_lost
    s[SINCE] += gap
    s[IDLE] += gap
    s[MISSING] = 0.0


@compiled(**EXACT_INNER)
def _lose_track(covariance: Any, s: Any, p: Any) -> None:
    """Forget the present swing in a gap: the motion is unknown, except that legs return."""
    for axis in range(3):
        covariance[axis, axis] += p[START_VARIANCE] * min(s[MISSING], LONGEST_GAP_S) ** 2
    s[MISSING], s[RISING], s[SWING], s[HIGH], s[LOW] = 0.0, 0.0, 0.0, 0.0, 0.0
    s[SINCE : IDLE + 1], s[PERIOD], s[SUM_ANGLES:BEFORE], s[SAMPLES] = 0.0, 0.0, 0.0, 0.0
    s[IDLE] = p[IDLE_MOST]


@compiled(**EXACT_INNER)
def _advance(
    x: Any,
    s: Any,
    p: Any,
    weights: Any,
    rates: Any,
    past: Any,
    works: bool,
    work: Any,
    features: Any,
    arguments: Any,
) -> tuple[float, float]:
    """Propagate the angles over one sample; return turn rate and cosine of the frontal angle.

    work[OWN]: gyroscope without bias; rates and past (3, lags): past rates of the angles and past
    angles, newest first. Without the network, the trapezoidal rule is used.
    """
    n_out = past.shape[1]
    n_past = features.shape[1] - 1 - n_out
    # extrapolated to the time of the sample: a lag would act like a bias
    sagittal, frontal = past[0, 0], past[1, 0]
    if n_out > 1:
        sagittal = 2.0 * sagittal - past[0, 1]
        frontal = 2.0 * frontal - past[1, 1]
    cos_f = _rates_of_angles(sagittal, frontal, work)
    turn = work[NOW, 2]
    s[TURN] += p[TURN_GAIN] * (turn - s[TURN])
    if works:
        rate_scale, angle_scale = p[RATE_SCALE], p[ANGLE_SCALE]
        for axis in range(3):
            about = x[CENTRE + axis] + (x[LEAN] * s[TURN] if axis == 1 else 0.0)
            work[ABOUT, axis] = about
            features[axis, 0] = work[NOW, axis] / rate_scale
            for i in range(n_past):
                features[axis, 1 + i] = rates[axis, i] / rate_scale
            for i in range(n_out):
                features[axis, 1 + n_past + i] = (past[axis, i] - about) / angle_scale
        three_outputs(weights, features, arguments, work)
        for axis in range(3):
            x[axis] = work[ABOUT, axis] + work[OUTPUT, axis] * angle_scale
    else:
        for axis in range(3):
            x[axis] = past[axis, 0] + 0.5 * p[INTERVAL] * (work[NOW, axis] + rates[axis, 0])
    for axis in range(3):
        for i in range(rates.shape[1] - 1, 0, -1):
            rates[axis, i] = rates[axis, i - 1]
        rates[axis, 0] = work[NOW, axis]
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
def _learn_from_swing(x: Any, covariance: Any, s: Any, p: Any, work: Any) -> bool:
    """Update by a swing: its mean angle measures the posture, less noisily if it resembles gait.

    Returns whether the leg walks.
    """
    turn = s[SUM_TURN] / s[SAMPLES]
    if abs(turn) > p[TURN_LEAST]:
        # a person who turns does not return to the previous heading
        covariance[CENTRE + 2, CENTRE + 2] += (turn * s[SINCE]) ** 2
    net = (x[0] - s[BEFORE]) ** 2 + (x[1] - s[BEFORE + 1]) ** 2
    doubt = 1.0 + net / p[RETURN_VARIANCE]
    doubt += ((s[SINCE] / s[PERIOD] - 1.0) / p[PERIOD_SHARE]) ** 2 if s[PERIOD] > 0.0 else 3.0
    unknown = 0.0
    for axis in range(2):
        at = CENTRE + axis
        relative = covariance[axis, axis] - 2.0 * covariance[axis, at] + covariance[at, at]
        unknown = max(unknown, relative)
    walks = doubt < MOST_DOUBT or unknown > p[KNOWN_ENOUGH]
    for axis in range(3):
        work[DIRECTION] = 0.0
        work[DIRECTION, axis], work[DIRECTION, CENTRE + axis] = 1.0, -1.0
        about = x[CENTRE + axis]
        if axis == 1:
            work[DIRECTION, LEAN] = -turn
            about += x[LEAN] * turn
        residual = about - s[SUM_ANGLES + axis] / s[SAMPLES]
        variance = p[CYCLE_VARIANCE + axis] * doubt
        expected = spread(covariance, work) + variance
        excess = residual**2 / (p[OUTLIER] * expected)
        if excess <= 1.0:
            s[ODD + axis] = 0.0
        elif s[ODD + axis] * residual > 0.0:
            # two outliers in a row with the same sign: the posture has changed, or was wrong
            # before; a heading far from the mean is a turn, never an error
            share = (p[EARLY] / (p[EARLY] + s[TRUST])) ** 2 if axis < 2 else 0.0
            covariance[axis, axis] += residual**2 * share
            covariance[CENTRE + axis, CENTRE + axis] += residual**2 * (1.0 - share)
            s[ODD + axis] = 0.0
        else:
            s[ODD + axis] = math.copysign(1.0, residual)
            continue
        measure(x, covariance, work, variance, residual)
    s[TRUST] += 1.0 / doubt
    return walks and s[ODD] == 0.0 and s[ODD + 1] == 0.0


@compiled(**EXACT_INNER)
def _level(x: Any, force: Any) -> tuple[float, float, float, float]:
    """Horizontal specific force, forward and left, and its derivatives by the two tilt angles."""
    sin_s, cos_s = sine_cosine(x[0], None)
    sin_f, cos_f = sine_cosine(x[1], None)
    up = sin_s * force[0] + cos_s * force[2]
    forward = cos_s * force[0] - sin_s * force[2]
    left = cos_f * force[1] + sin_f * up
    return forward, left, -up, cos_f * up - sin_f * force[1]


@compiled(**EXACT_INNER)
def room(n_states: int, n_weights: int, n_hidden: int) -> Any:
    """Return arrays for the intermediate results of `step`: work, moved, features, arguments."""
    # hidden neurons have two weights more than features; one output bias
    width = (n_weights - 1) // n_hidden - 2 if n_hidden > 0 else n_weights
    return (
        np.zeros((10, n_states)),
        np.zeros((n_states - CONSTANT, n_states + 1)),
        np.zeros((3, width)),
        np.zeros((3, n_hidden)),
    )


@compiled(**EXACT_INNER)
def step(
    axis_rates: Any,
    force: Any,
    x: Any,
    covariance: Any,
    s: Any,
    p: Any,
    weights: Any,
    rates: Any,
    past: Any,
    work: Any,
    moved: Any,
    features: Any,
    arguments: Any,
) -> bool:
    """Advance by a valid sample; return whether the network propagated the angles.

    work, moved, features and arguments, from `room`, are overwritten.
    """
    n, dt = len(x), p[INTERVAL]
    aided = n == AIDED_STATES
    bridged = 0.0 < s[MISSING] < LONGEST_BRIDGED_S
    if s[MISSING] > 0.0 and not bridged:
        _lose_track(covariance, s, p)
    square, scatter, mean_square = 0.0, 0.0, 0.0
    for axis in range(3):
        own = axis_rates[axis] - x[BIAS + axis]
        work[OWN, axis] = own
        square += own**2
        away = axis_rates[axis] - s[MEAN_RATE + axis]
        s[MEAN_RATE + axis] += p[REST_GAIN] * away
        scatter += away**2
    s[SCATTER] += p[REST_GAIN] * (scatter - s[SCATTER])
    if bridged:
        _bridge(x, covariance, s, p, rates, past, work)
    walks = s[IDLE] < p[IDLE_MOST]
    if walks:
        own_square = work[OWN, 0] ** 2
        s[SQUARE] += p[LEG_GAIN] * (own_square - s[SQUARE])
        s[CUBE] += p[LEG_GAIN] * (own_square * work[OWN, 0] - s[CUBE])
    works = walks and (
        max(covariance[CENTRE, CENTRE], covariance[CENTRE + 1, CENTRE + 1]) < p[KNOWN_ENOUGH]
    )
    if s[TRUST] > p[EARLY]:
        works &= max(abs(x[0] - x[CENTRE]), abs(x[1] - x[CENTRE + 1])) < FAR_RAD
    turn, cos_f = _advance(x, s, p, weights, rates, past, works, work, features, arguments)
    if abs(x[0]) > math.pi:
        whole = math.copysign(2.0 * math.pi, x[0])
        x[0] -= whole
        for i in range(past.shape[1]):
            past[0, i] -= whole
    for axis in range(3):
        work[CARRIED, axis] = x[axis]
    # with a known start the estimated posture does not decay to zero, and the heading never does
    decay, noise = (1.0, 0.0) if s[KNOWN] > 0.0 else (p[CENTRE_DECAY], p[CENTRE_NOISE])
    leak = p[LEAK] * dt if works else 0.0
    for axis in range(2):
        x[CENTRE + axis] *= decay
    work[CHANGE, 0], work[CHANGE, 2], work[CHANGE, 3] = leak, dt, leak * s[TURN]
    work[CHANGE, 1] = dt * s[TURN] if abs(s[TURN]) > p[TURN_LEAST] else 0.0
    # the mean heading turns with the person; a threshold would amplify rounding errors
    x[CENTRE + 2] += dt * s[TURN] * min(max(abs(s[TURN]) / p[TURN_LEAST] - 1.0, 0.0), 1.0)
    if aided:
        forward, left, by_sagittal, by_frontal = _level(x, force)
        ahead, aside = x[VELOCITY], x[VELOCITY + 1]
        x[VELOCITY] += dt * (forward + turn * aside)
        x[VELOCITY + 1] += dt * (left - turn * ahead)
        work[CHANGE, 4], work[CHANGE, 5] = dt * by_sagittal, dt * by_frontal
        work[CHANGE, 6] = dt * turn
    propagate(covariance, decay, work, moved)
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
            residual = s[MEAN_RATE + axis] - x[BIAS + axis]
            measure_state(x, covariance, BIAS + axis, work, p[REST_VARIANCE], residual)
    s[SINCE] += dt
    s[IDLE] += dt
    s[SAMPLES] += 1.0
    s[SUM_TURN] += turn
    for axis in range(3):
        s[SUM_ANGLES + axis] += work[CARRIED, axis]
    for i in range(VELOCITY, n):
        usual = p[SPEED] if i == VELOCITY else 0.0
        variance = p[VELOCITY_VARIANCE + i - VELOCITY]
        measure_state(x, covariance, i, work, variance, usual - x[i])
    if _swing_ends(work[OWN, 0], s, p):
        swung = SHORTEST_SWING_S < s[SINCE] < LONGEST_SWING_S
        if swung and _learn_from_swing(x, covariance, s, p, work):
            s[IDLE] = 0.0
        s[PERIOD] = s[SINCE] if swung else 0.0
        s[SINCE], s[SAMPLES], s[SUM_ANGLES:BEFORE] = 0.0, 0.0, 0.0
        s[BEFORE], s[BEFORE + 1] = x[0], x[1]
    for axis in range(3):
        # a correction is not a movement: past angles are shifted by the same amount
        correction = x[axis] - work[CARRIED, axis]
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
    growths: Any,
    works: Any,
) -> None:
    """Advance over samples (N, 3), NaN where missing.

    Fills angles and their variances (N, 3), growths of the standard deviation and works (N,).

    x (n,), covariance (n, n), s (SCALARS,), rates and past (3, lags) are the state, changed in
    place; p (PARAMETERS,) is from `narx.inference.tracker`.
    """
    work, moved, features, arguments = room(len(x), len(weights), n_hidden)
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
            growths[k] = math.nan
            works[k] = False
            continue
        works[k] = step(
            axis_rates[k], force[k], x, covariance, s, p, weights, rates, past,
            work, moved, features, arguments,
        )  # fmt: skip
        for axis in range(3):
            angles[k, axis] = x[axis]
            variances[k, axis] = covariance[axis, axis]
        growths[k] = std_growth(s[SQUARE], s[CUBE])
