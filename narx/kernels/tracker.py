"""Network and Kalman filter in one recurrence: angles, mean posture, and gyroscope bias.

The network propagates the angles from sample to sample during walking; a small Kalman filter
estimates their covariance, and corrects angles, posture and bias once per swing of the leg.
`narx.inference.tracker.PostureTracker` has the model and the parameters.

A step advances several sensors side by side, the lanes of a vector (`narx.kernels.lanes`), or one.
The operations are the same, so the results are, to the last bit.
"""

import math
from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, EXACT_VIEWS, compiled
from narx.kernels.functions import load, magnitude, sine_cosine, splat, store, where_less
from narx.kernels.kalman import measure_state
from narx.kernels.leg import std_growth
from narx.kernels.sizes import SCALAR
from narx.kernels.tracker_angles import add_correction, advance, corrected_rad, within_a_turn
from narx.kernels.tracker_covariance import propagate
from narx.kernels.tracker_events import end_gap, end_swing
from narx.kernels.tracker_layout import (
    AIDED_STATES,
    ANGLE_NOISE,
    BIAS,
    BIAS_NOISE,
    CARRIED,
    CENTRE,
    CENTRE_DECAY,
    CENTRE_NOISE,
    CHANGE,
    CONSTANT,
    CUBE,
    DELAY_S,
    DOUBT_SPAN,
    EARLY,
    EVENTS,
    FAR_RAD,
    HIGH,
    IDLE,
    IDLE_MOST,
    INTERVAL,
    KNOWN,
    KNOWN_ENOUGH,
    LEAK,
    LEG_GAIN,
    LOW,
    MEAN_RATE,
    MISSING,
    MOST_BIAS_RAD_S,
    NEAR_RAD,
    OWN,
    RATE_NOISE,
    REST_GAIN,
    REST_LEAST,
    REST_VARIANCE,
    RESTS,
    RISING,
    SAMPLES,
    SCATTER,
    SINCE,
    SPAN,
    SPAN_DECAY,
    SPAN_SHARE,
    SPEED,
    SQUARE,
    SUM_ANGLES,
    SUM_TURN,
    SWING,
    SWING_DECAY,
    SWING_LEAST,
    SWUNG,
    TRUST,
    TURN,
    TURN_LEAST,
    TURNING,
    TURNING_GAIN,
    VELOCITY,
    VELOCITY_NOISE,
    VELOCITY_VARIANCE,
    WORK,
)


@compiled(**EXACT_INNER)
def room(n_states: int, n_weights: int, n_hidden: int, width: int) -> Any:
    """Return arrays for the intermediate results of `step`: work, moved, features, arguments."""
    # hidden neurons have two weights more than features; one output bias
    n_features = (n_weights - 1) // n_hidden - 2 if n_hidden > 0 else n_weights
    return (
        np.zeros((WORK, n_states, width)),
        np.zeros((n_states - CONSTANT, n_states + 1, width)),
        np.zeros((3, n_features, width)),
        np.zeros((3, n_hidden, width)),
    )


@compiled(**EXACT_VIEWS)
def _any(row: Any) -> bool:
    for value in row:  # noqa: SIM110 - the compiler has no generators
        if value != 0.0:
            return True
    return False


@compiled(**EXACT_VIEWS)
def _add(lanes: Any, array: Any, row: int, value: Any) -> None:
    store(lanes, array, (row, 0), load(lanes, array, (row, 0)) + value)


@compiled(**EXACT_VIEWS)
def _grow(lanes: Any, covariance: Any, i: int, value: Any) -> None:
    store(lanes, covariance, (i, i, 0), load(lanes, covariance, (i, i, 0)) + value)


@compiled(**EXACT_VIEWS)
def _remember_rates(tick: Any, state: Any, p: Any, work: Any, lanes: Any) -> Any:
    """Fill work[OWN], update the means of the rates; return the square of the former."""
    x, _, s, _, _, _ = state
    square = scatter = splat(lanes, 0.0)
    for axis in range(3):
        rate, mean = load(lanes, tick, (axis, 0)), load(lanes, s, (MEAN_RATE + axis, 0))
        own, away = rate - load(lanes, x, (BIAS + axis, 0)), rate - mean
        store(lanes, work, (OWN, axis, 0), own)
        store(lanes, s, (MEAN_RATE + axis, 0), mean + p[REST_GAIN] * away)
        square, scatter = square + own * own, scatter + away * away
    _add(lanes, s, SCATTER, p[REST_GAIN] * (scatter - load(lanes, s, (SCATTER, 0))))
    return square


@compiled(**EXACT_VIEWS)
def _limited(share: Any, lanes: Any) -> Any:
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    return where_less(share, zero, zero, where_less(share, one, share, one))


@compiled(**EXACT_VIEWS)
def _works(state: Any, p: Any, work: Any, lanes: Any) -> Any:
    """Fill and return works, the network's share in the propagation of the angles, 0 to 1.

    Where the leg walks, its mean square and cube are updated. The share falls along a line as the
    posture becomes uncertain, and far from an established one: a threshold would amplify rounding
    errors.
    """
    x, covariance, s, _, _, works = state
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    idle_most = splat(lanes, p[IDLE_MOST])
    walks = where_less(load(lanes, s, (IDLE, 0)), idle_most, one, zero)
    own, gain = load(lanes, work, (OWN, 0, 0)), p[LEG_GAIN] * walks
    _add(lanes, s, SQUARE, gain * (own * own - load(lanes, s, (SQUARE, 0))))
    _add(lanes, s, CUBE, gain * (own * own * own - load(lanes, s, (CUBE, 0))))
    sagittal = load(lanes, covariance, (CENTRE, CENTRE, 0))
    frontal = load(lanes, covariance, (CENTRE + 1, CENTRE + 1, 0))
    doubt = where_less(sagittal, frontal, frontal, sagittal)
    known = _limited((p[KNOWN_ENOUGH] - doubt) / (DOUBT_SPAN * p[KNOWN_ENOUGH]), lanes)
    sagittal = magnitude(load(lanes, x, (0, 0)) - load(lanes, x, (CENTRE, 0)))
    frontal = magnitude(load(lanes, x, (1, 0)) - load(lanes, x, (CENTRE + 1, 0)))
    away = where_less(sagittal, frontal, frontal, sagittal)
    near = _limited((FAR_RAD - away) / (FAR_RAD - NEAR_RAD), lanes)
    near = where_less(splat(lanes, p[EARLY]), load(lanes, s, (TRUST, 0)), near, one)
    found = walks * known * near
    store(lanes, works, (0, 0), found)
    return found


@compiled(**EXACT_VIEWS)
def _level(x: Any, tick: Any, lanes: Any) -> Any:
    """Horizontal specific force, forward and left, and its derivatives by the two tilt angles."""
    sin_s, cos_s = sine_cosine(load(lanes, x, (0, 0)), None)
    sin_f, cos_f = sine_cosine(load(lanes, x, (1, 0)), None)
    ahead, left = load(lanes, tick, (3, 0)), load(lanes, tick, (4, 0))
    above = load(lanes, tick, (5, 0))
    up, zero = sin_s * ahead + cos_s * above, splat(lanes, 0.0)
    return (
        cos_s * ahead - sin_s * above,
        cos_f * left + sin_f * up,
        zero - up,
        cos_f * up - sin_f * left,
    )


@compiled(**EXACT_VIEWS)
def _predict(
    tick: Any, state: Any, p: Any, works: Any, turn: Any, cos_f: Any, square: Any, room: Any,
    lanes: Any,
) -> None:  # fmt: skip
    """Propagate posture, velocity, and the covariance."""
    x, covariance, s, _, _, _ = state
    work, moved, _, _ = room
    n, dt = len(x), p[INTERVAL]
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    # with a known start the estimated posture does not decay to zero, and the heading never does
    known = load(lanes, s, (KNOWN, 0))
    decay = where_less(zero, known, one, splat(lanes, p[CENTRE_DECAY]))
    noise = where_less(zero, known, zero, splat(lanes, p[CENTRE_NOISE]))
    for axis in range(2):
        store(lanes, x, (CENTRE + axis, 0), load(lanes, x, (CENTRE + axis, 0)) * decay)
    leak, mean_turn = p[LEAK] * dt * works, load(lanes, s, (TURN, 0))
    # over a stride the leg's own rotation has no mean, so that what remains is a turn
    turning = load(lanes, s, (TURNING, 0))
    turning = turning + p[TURNING_GAIN] * (turn - turning)
    store(lanes, s, (TURNING, 0), turning)
    size, least = magnitude(turning), splat(lanes, p[TURN_LEAST])
    store(lanes, work, (CHANGE, 0, 0), leak)
    store(lanes, work, (CHANGE, 1, 0), where_less(least, size, dt * mean_turn, zero))
    store(lanes, work, (CHANGE, 2, 0), splat(lanes, dt))
    store(lanes, work, (CHANGE, 3, 0), leak * mean_turn)
    # the mean heading turns with the person; a threshold would amplify rounding errors
    share = _limited(size / p[TURN_LEAST] - 1.0, lanes)
    _add(lanes, x, CENTRE + 2, dt * mean_turn * share)
    if n == AIDED_STATES:
        forward, left, by_sagittal, by_frontal = _level(x, tick, lanes)
        ahead, aside = load(lanes, x, (VELOCITY, 0)), load(lanes, x, (VELOCITY + 1, 0))
        store(lanes, x, (VELOCITY, 0), ahead + dt * (forward + turn * aside))
        store(lanes, x, (VELOCITY + 1, 0), aside + dt * (left - turn * ahead))
        store(lanes, work, (CHANGE, 4, 0), dt * by_sagittal)
        store(lanes, work, (CHANGE, 5, 0), dt * by_frontal)
        store(lanes, work, (CHANGE, 6, 0), dt * turn)
    propagate(covariance, decay, work, moved, lanes)
    angle_noise = p[ANGLE_NOISE] + p[RATE_NOISE] * square / (cos_f * cos_f)
    for axis in range(3):
        _grow(lanes, covariance, axis, angle_noise)
        _grow(lanes, covariance, BIAS + axis, splat(lanes, p[BIAS_NOISE]))
    for axis in range(2):
        _grow(lanes, covariance, CENTRE + axis, noise)
    for i in range(VELOCITY, n):
        _grow(lanes, covariance, i, splat(lanes, p[VELOCITY_NOISE]))


@compiled(**EXACT_VIEWS)
def _measure_rest(state: Any, p: Any, work: Any, lanes: Any) -> None:
    """At rest the mean rate is that of the bias."""
    x, covariance, s, _, _, _ = state
    zero, one, mean_square = splat(lanes, 0.0), splat(lanes, 1.0), splat(lanes, 0.0)
    for axis in range(3):
        mean = load(lanes, s, (MEAN_RATE + axis, 0))
        mean_square = mean_square + mean * mean
    rests = where_less(mean_square, splat(lanes, MOST_BIAS_RAD_S**2), one, zero)
    still = splat(lanes, p[REST_LEAST])
    rests = where_less(load(lanes, s, (SCATTER, 0)), still, rests, zero)
    store(lanes, work, (EVENTS, RESTS, 0), rests)
    if _any(work[EVENTS, RESTS]):
        for axis in range(3):
            at = BIAS + axis
            residual = load(lanes, s, (MEAN_RATE + axis, 0)) - load(lanes, x, (at, 0))
            measure_state(x, covariance, at, work, p[REST_VARIANCE], residual, rests, lanes)


@compiled(**EXACT_VIEWS)
def _measure_velocity(x: Any, covariance: Any, p: Any, work: Any, lanes: Any) -> None:
    """On average the velocity is that of walking."""
    for i in range(VELOCITY, len(x)):
        usual = p[SPEED] if i == VELOCITY else 0.0
        variance = p[VELOCITY_VARIANCE + i - VELOCITY]
        residual = usual - load(lanes, x, (i, 0))
        measure_state(x, covariance, i, work, variance, residual, splat(lanes, 1.0), lanes)


@compiled(**EXACT_VIEWS)
def _swing(s: Any, p: Any, work: Any, lanes: Any) -> None:
    """Track the swing of the leg: work[EVENTS] is 1 where a forward swing has just reversed."""
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    moved = p[INTERVAL] * load(lanes, work, (OWN, 0, 0))
    swing = (load(lanes, s, (SWING, 0)) + moved) / p[SWING_DECAY]
    high, low = load(lanes, s, (HIGH, 0)), load(lanes, s, (LOW, 0))
    high, low = where_less(high, swing, swing, high), where_less(swing, low, swing, low)
    span = p[SPAN_DECAY] * load(lanes, s, (SPAN, 0))
    least, smallest = p[SPAN_SHARE] * span, splat(lanes, p[SWING_LEAST])
    least = where_less(least, smallest, smallest, least)
    rising = load(lanes, s, (RISING, 0))
    begins = where_less(least, swing - low, one - rising, zero)
    rising, high = rising + begins, where_less(zero, begins, swing, high)
    ends = where_less(least, high - swing, rising, zero)
    largest = where_less(span, high - low, high - low, span)
    store(lanes, s, (SWING, 0), swing)
    store(lanes, s, (HIGH, 0), high)
    store(lanes, s, (LOW, 0), where_less(zero, ends, swing, low))
    store(lanes, s, (SPAN, 0), where_less(zero, ends, largest, span))
    store(lanes, s, (RISING, 0), rising - ends)
    store(lanes, work, (EVENTS, SWUNG, 0), ends)


@compiled(**EXACT_VIEWS)
def step(tick: Any, state: Any, p: Any, weights: Any, room: Any, lanes: Any) -> None:
    """Advance sensors side by side by a valid sample of each.

    tick (C, W): gyroscope about the clinical axes, and the accelerometer if aided. state, changed
    in place: x (n, W), covariance (n, n, W), scalars (SCALARS, W), rates and past (3, lags, W), and
    works (1, W), filled with the network's share in the propagation of the angles. The arrays of
    `room` are overwritten.
    """
    x, covariance, s, _, past, working = state
    work, width, dt = room[0], len(lanes), p[INTERVAL]
    for lane in range(width):
        if s[MISSING, lane] > 0.0:
            end_gap(tick, state, p, work, lane)
    square = _remember_rates(tick, state, p, work, lanes)
    works = _works(state, p, work, lanes)
    turn, cos_f = advance(state, p, weights, works, _any(working[0]), room, lanes)
    within_a_turn(state, work, lanes)
    _predict(tick, state, p, works, turn, cos_f, square, room, lanes)
    _measure_rest(state, p, work, lanes)
    _add(lanes, s, SINCE, dt)
    _add(lanes, s, IDLE, dt)
    _add(lanes, s, SAMPLES, 1.0)
    _add(lanes, s, SUM_TURN, turn)
    for axis in range(3):
        _add(lanes, s, SUM_ANGLES + axis, load(lanes, work, (CARRIED, axis, 0)))
    _measure_velocity(x, covariance, p, work, lanes)
    _swing(s, p, work, lanes)
    for lane in range(width):
        if work[EVENTS, SWUNG, lane] != 0.0:
            end_swing(state, p, work, lane)
    for axis in range(3):
        # a correction is not a movement: past angles are shifted by the same amount
        angle = load(lanes, x, (axis, 0))
        correction = angle - load(lanes, work, (CARRIED, axis, 0))
        if axis < 2:
            add_correction(s, axis, works * correction, lanes)
        for i in range(past.shape[1] - 1, 0, -1):
            before = load(lanes, past, (axis, i - 1, 0))
            store(lanes, past, (axis, i, 0), before + correction)
        store(lanes, past, (axis, 0, 0), angle)


@compiled(**EXACT_VIEWS)
def _track(
    axis_rates: Any, force: Any, x: Any, covariance: Any, s: Any, p: Any, weights: Any,
    rates: Any, past: Any, angles: Any, variances: Any, growths: Any, corrected: Any, works: Any,
    space: Any, tick: Any, working: Any,
) -> None:  # fmt: skip
    n = len(x)
    aided = n == AIDED_STATES
    state = (
        x.reshape(n, 1),
        covariance.reshape(n, n, 1),
        s.reshape(len(s), 1),
        rates.reshape(3, rates.shape[1], 1),
        past.reshape(3, past.shape[1], 1),
        working,
    )
    for k in range(len(axis_rates)):
        there = True
        for axis in range(3):
            tick[axis, 0], tick[3 + axis, 0] = axis_rates[k, axis], force[k, axis]
            there &= math.isfinite(axis_rates[k, axis])
            if aided:
                there &= math.isfinite(force[k, axis])
        if not there:
            s[MISSING] += p[INTERVAL]
            angles[k] = math.nan
            variances[k] = math.nan
            growths[k] = math.nan
            corrected[k] = math.nan
            works[k] = False
            continue
        step(tick, state, p, weights, space, SCALAR)
        works[k] = working[0, 0] != 0.0
        for axis in range(3):
            angles[k, axis] = x[axis]
            variances[k, axis] = covariance[axis, axis] + (p[DELAY_S] * rates[axis, 0]) ** 2
            corrected[k, axis] = corrected_rad(state[2], p, axis, 0)
        growths[k] = std_growth(s[SQUARE], s[CUBE])


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
    corrected: Any,
    works: Any,
) -> None:
    """Advance one sensor over samples (N, 3), NaN where missing.

    Fills angles and their variances (N, 3), growths of the standard deviation (N,), what the recent
    corrections add to it (N, 3) and works (N,).

    x (n,), covariance (n, n), s (SCALARS,), rates and past (3, lags) are the state, changed in
    place; p (PARAMETERS,) is from `narx.inference.tracker`.
    """
    _track(
        axis_rates, force, x, covariance, s, p, weights, rates, past,
        angles, variances, growths, corrected, works,
        room(len(x), len(weights), n_hidden, 1), np.empty((6, 1)), np.zeros((1, 1)),
    )  # fmt: skip
