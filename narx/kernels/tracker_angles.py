"""The angles of the tracker over one sample, by the network or by their rates."""

import math
from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled
from narx.kernels.functions import load, splat, store, where_less
from narx.kernels.network_step import three_outputs
from narx.kernels.sample_steps import turned
from narx.kernels.tracker_layout import (
    ABOUT,
    ANGLE_SCALE,
    CARRIED,
    CENTRE,
    CORRECTED,
    CORRECTED_KEPT,
    INTERVAL,
    LEAN,
    NOW,
    OUTPUT,
    OWN,
    PER_CORRECTED,
    RATE_SCALE,
    TURN,
    TURN_GAIN,
)


@compiled(**EXACT_VIEWS)
def add_correction(s: Any, axis: int, correction: Any, lanes: Any) -> None:
    """Add a correction of a tilt angle to those of the last seconds."""
    before = load(lanes, s, (CORRECTED + axis, 0))
    store(lanes, s, (CORRECTED + axis, 0), before + correction)


@compiled(**EXACT_VIEWS)
def corrected_rad(s: Any, p: Any, axis: int, lane: int) -> float:
    """What the recent corrections add to the standard deviation of an angle."""
    return float(s[CORRECTED + axis, lane] ** 2 * p[PER_CORRECTED] if axis < 2 else 0.0)


@compiled(**EXACT_VIEWS)
def advance(
    state: Any, p: Any, weights: Any, works: Any, by_network: bool, room: Any, lanes: Any
) -> Any:
    """Propagate the angles over one sample; return turn rate and cosine of the frontal angle.

    work[OWN]: gyroscope without bias; rates and past (3, lags, W): past rates of the angles and
    past angles, newest first. `works` is the network's share, 0 everywhere unless `by_network`; the
    trapezoidal rule has the rest.
    """
    x, _, s, rates, past, _ = state
    work, _, features, arguments = room
    n_out, n_rates = past.shape[1], rates.shape[1]
    zero, one = splat(lanes, 0.0), splat(lanes, 1.0)
    n_past = features.shape[1] - 1 - n_out
    # extrapolated to the time of the sample: a lag would act like a bias
    sagittal, frontal = load(lanes, past, (0, 0, 0)), load(lanes, past, (1, 0, 0))
    if n_out > 1:
        sagittal = 2.0 * sagittal - load(lanes, past, (0, 1, 0))
        frontal = 2.0 * frontal - load(lanes, past, (1, 1, 0))
    now_s, now_f, turn, cos_f = turned(
        load(lanes, work, (OWN, 0, 0)),
        load(lanes, work, (OWN, 1, 0)),
        load(lanes, work, (OWN, 2, 0)),
        sagittal,
        frontal,
    )
    store(lanes, work, (NOW, 0, 0), now_s)
    store(lanes, work, (NOW, 1, 0), now_f)
    store(lanes, work, (NOW, 2, 0), turn)
    mean_turn = load(lanes, s, (TURN, 0))
    mean_turn = mean_turn + p[TURN_GAIN] * (turn - mean_turn)
    store(lanes, s, (TURN, 0), mean_turn)
    for axis in range(2):
        recent = p[CORRECTED_KEPT] * load(lanes, s, (CORRECTED + axis, 0))
        store(lanes, s, (CORRECTED + axis, 0), recent)
    if by_network:
        lean = load(lanes, x, (LEAN, 0)) * mean_turn
        for axis in range(3):
            about = load(lanes, x, (CENTRE + axis, 0))
            if axis == 1:
                about = about + lean
            store(lanes, work, (ABOUT, axis, 0), about)
            now = load(lanes, work, (NOW, axis, 0))
            store(lanes, features, (axis, 0, 0), now / p[RATE_SCALE])
            for i in range(n_past):
                before = load(lanes, rates, (axis, i, 0))
                store(lanes, features, (axis, 1 + i, 0), before / p[RATE_SCALE])
            for i in range(n_out):
                away = load(lanes, past, (axis, i, 0)) - about
                store(lanes, features, (axis, 1 + n_past + i, 0), away / p[ANGLE_SCALE])
        three_outputs(weights, features, arguments, work, lanes)
    for axis in range(3):
        now, before = load(lanes, work, (NOW, axis, 0)), load(lanes, rates, (axis, 0, 0))
        angle = load(lanes, past, (axis, 0, 0)) + 0.5 * p[INTERVAL] * (now + before)
        if by_network:
            away = load(lanes, work, (OUTPUT, axis, 0)) * p[ANGLE_SCALE]
            found = load(lanes, work, (ABOUT, axis, 0)) + away
            partly = where_less(zero, works, angle + works * (found - angle), angle)
            by_rate = angle
            angle = where_less(works, one, partly, found)
            if axis < 2:
                add_correction(s, axis, angle - by_rate, lanes)
        store(lanes, x, (axis, 0), angle)
        for i in range(n_rates - 1, 0, -1):
            store(lanes, rates, (axis, i, 0), load(lanes, rates, (axis, i - 1, 0)))
        store(lanes, rates, (axis, 0, 0), now)
    return turn, cos_f


@compiled(**EXACT_VIEWS)
def within_a_turn(state: Any, work: Any, lanes: Any) -> None:
    """Keep the sagittal angle within half a turn; fill work[CARRIED]."""
    x, _, _, _, past, _ = state
    zero, half, turn = splat(lanes, 0.0), splat(lanes, math.pi), splat(lanes, 2.0 * math.pi)
    sagittal = load(lanes, x, (0, 0))
    whole = where_less(half, sagittal, turn, where_less(sagittal, zero - half, zero - turn, zero))
    store(lanes, x, (0, 0), sagittal - whole)
    for i in range(past.shape[1]):
        store(lanes, past, (0, i, 0), load(lanes, past, (0, i, 0)) - whole)
    for axis in range(3):
        store(lanes, work, (CARRIED, axis, 0), load(lanes, x, (axis, 0)))
