"""Values that are filled into the C templates."""

import math
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from narx.export.neurons import merged_neurons, physical_weights
from narx.export.recurrence import refuse_own_scaling, samples_in_movement
from narx.export.tracker_numbers import between_samples, exported_numbers, upper_part
from narx.inference.checkpoint import Checkpoint
from narx.inference.tracking import Tracking
from narx.inference.washout import washout_gain
from narx.kernels import leg
from narx.kernels import tracker_layout as kernel
from narx.kernels.clock import ON_TICK
from narx.kernels.limits import COS_FRONTAL_MIN, FORCE_LIMIT_M_S2, START_LIMIT_RAD
from narx.kernels.short_gap import BRIDGED_RAD_S2, LONGEST_BRIDGED_S
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S
from narx.types import FloatArray

# a number's suffix and a function's are the same letter in C
_SUFFIX = {"double": "", "float": "f"}
# in float neurons are one that differ by less than its accuracy asks for
_SAME = {"double": 1e-8, "float": 1e-3}
# ranges of the short series, each to about the accuracy of float; beyond them a longer one or the
# library's functions
_SHORT_SINE_LIMIT_RAD, _SINE_LIMIT_RAD, _SECANT_LIMIT_RAD = 0.45, 1.2, 0.2
_CUBIC_TANH_LIMIT, _TANH_LIMIT, _EXCESS_LIMIT = 0.03, 0.12, 0.3

# single numbers of the tracker, by the template's names
_TRACKER_NUMBERS = {
    "leak": kernel.LEAK,
    "angle_noise": kernel.ANGLE_NOISE,
    "rate_noise": kernel.RATE_NOISE,
    "centre_noise": kernel.CENTRE_NOISE,
    "bias_noise": kernel.BIAS_NOISE,
    "start_variance": kernel.START_VARIANCE,
    "known_enough": kernel.KNOWN_ENOUGH,
    "turn_gain": kernel.TURN_GAIN,
    "turn_least": kernel.TURN_LEAST,
    "span_share": kernel.SPAN_SHARE,
    "swing_least": kernel.SWING_LEAST,
    "idle_most": kernel.IDLE_MOST,
    "return_variance": kernel.RETURN_VARIANCE,
    "period_share": kernel.PERIOD_SHARE,
    "outlier": kernel.OUTLIER,
    "early": kernel.EARLY,
    "rest_gain": kernel.REST_GAIN,
    "rest_least": kernel.REST_LEAST,
    "rest_variance": kernel.REST_VARIANCE,
    "velocity_noise": kernel.VELOCITY_NOISE,
    "speed": kernel.SPEED,
    "leg_gain": kernel.LEG_GAIN,
    "turning_gain": kernel.TURNING_GAIN,
    "most_net": kernel.MOST_NET,
    "reopened": kernel.REOPENED,
    "delay_s": kernel.DELAY_S,
    "alignment": kernel.ALIGNMENT,
    "corrected_kept": kernel.CORRECTED_KEPT,
    "per_corrected": kernel.PER_CORRECTED,
}


def values_of(checkpoint: Checkpoint, precision: str) -> dict[str, str]:
    """Write everything that the templates need beside the names of the files.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    precision : {"double", "float"}
        Type of all numbers.

    Returns
    -------
    dict of str to str
        By the templates' names.
    """
    refuse_own_scaling(checkpoint)
    suffix, interval_s = _SUFFIX[precision], 1.0 / checkpoint.model.sampling_rate_hz
    clock = checkpoint.method().clock_numbers(interval_s)
    merged = merged_neurons(*physical_weights(checkpoint), _SAME[precision])
    recurrence = _start_up(checkpoint) if checkpoint.tracker is None else _tracked(checkpoint)
    numbers = {
        "sampling_rate_hz": float(checkpoint.model.sampling_rate_hz),
        "interval_s": interval_s,
        "interval_upper_s": upper_part(interval_s),
        "interval_lower_s": interval_s - upper_part(interval_s),
        "half_interval_s": 0.5 * interval_s,
        "rate_limit_rad_s": clock.limit_rad_s,
        "force_limit_m_s2": FORCE_LIMIT_M_S2,
        "start_limit_rad": START_LIMIT_RAD,
        "max_gap_s": clock.max_gap_s,
        "longest_pause_s": clock.longest_pause_s,
        "on_tick": ON_TICK,
        "smallest_cos_frontal": COS_FRONTAL_MIN,
        "sine_square": _SINE_LIMIT_RAD**2,
        "tanh_square": _TANH_LIMIT**2,
        "short_sine_square": _SHORT_SINE_LIMIT_RAD**2,
        "secant_square": _SECANT_LIMIT_RAD**2,
        **recurrence,
    }
    counts = {
        "inputs": 6 if checkpoint.method().needs_accelerometer else 3,
        "lost_most": clock.lost_most,
        "tracked": int(checkpoint.tracker is not None),
        "short_series": int(precision == "float"),
        "past_inputs": checkpoint.model.structure.n_input_state,
        "output_lags": checkpoint.model.structure.output_lags,
        "n_state": checkpoint.model.structure.n_state,
    }
    return {
        "real": precision,
        "f": suffix,
        **_series(checkpoint.tracker is not None, suffix),
        "network": _network(
            merged, checkpoint.model.structure.n_input_state, suffix, checkpoint.tracker is not None
        ),
        **{name: str(count) for name, count in counts.items()},
        **{name: _text(value, suffix) for name, value in numbers.items()},
    }


def _text(value: Any, suffix: str) -> str:
    """Write numbers so that C reads the same ones; counts are Python's int."""
    if isinstance(value, int):
        return str(value)
    if np.ndim(value) == 0:
        return f"{float(value)!r}{suffix}"
    if np.ndim(value) == 1:
        return ", ".join(_text(number, suffix) for number in value)
    return ",\n".join(f"    {{{_text(row, suffix)}}}" for row in value)


def _start_up(checkpoint: Checkpoint) -> dict[str, Any]:
    start_up, interval_s = checkpoint.start_up, 1.0 / checkpoint.model.sampling_rate_hz
    scaled = checkpoint.model.normalisation
    return {
        "rate_offset_rad_s": float(scaled.rate_offset_rad_s),
        "angle_offset_rad": float(scaled.angle_offset_rad),
        "leak_rad_s": float(start_up.leak_rad_s),
        "settling_gain": float(start_up.settling_gain),
        "settling_s": float(start_up.settling_s),
        "averaged_from_s": float(start_up.averaged_from_s),
        "averaging_s": float(start_up.averaging_s),
        "pi_per_averaging": math.pi / start_up.averaging_s if start_up.averaging_s else 0.0,
        "movement_gain": interval_s / (MOVEMENT_TIME_CONSTANT_S + interval_s),
        "movement_square": MOVEMENT_RAD_S**2,
        "washout_gain": washout_gain(checkpoint.washout_s, interval_s),
        "washout_kept": 1.0 - washout_gain(checkpoint.washout_s, interval_s),
        "moving_samples": samples_in_movement(start_up, interval_s),
        "coupled": int(checkpoint.model.coupled),
    }


def _tracked(checkpoint: Checkpoint) -> dict[str, Any]:
    tracker, model = checkpoint.tracker, checkpoint.model
    assert tracker is not None
    parameters, interval_s = exported_numbers(tracker, model), 1.0 / model.sampling_rate_hz
    unknown, known = (Tracking(tracker, model, pose) for pose in (None, np.zeros(3)))
    cycle, velocity = kernel.CYCLE_VARIANCE, kernel.VELOCITY_VARIANCE
    return {
        **{name: parameters[at] for name, at in _TRACKER_NUMBERS.items()},
        "pi": math.pi,
        # what is lost in a sample: a share close to one has few digits of it
        "swing_loss": 1.0 - 1.0 / parameters[kernel.SWING_DECAY],
        "swing_gain_s": interval_s / parameters[kernel.SWING_DECAY],
        "span_loss": 1.0 - parameters[kernel.SPAN_DECAY],
        "per_turn_least": 1.0 / parameters[kernel.TURN_LEAST],
        "centre_loss": 1.0 - parameters[kernel.CENTRE_DECAY],
        "longest_gap_s": kernel.LONGEST_GAP_S,
        "longest_bridged_s": between_samples(LONGEST_BRIDGED_S, interval_s, above=False),
        "bridged_rad_s2": BRIDGED_RAD_S2,
        "swing_time_s": interval_s / (parameters[kernel.SWING_DECAY] - 1.0),
        "most_doubt": kernel.MOST_DOUBT,
        "far_rad": kernel.FAR_RAD,
        "most_corrected": kernel.MOST_CORRECTED_RAD,
        "per_doubt": 1.0 / (kernel.DOUBT_SPAN * parameters[kernel.KNOWN_ENOUGH]),
        "per_far_rad": 1.0 / (kernel.FAR_RAD - kernel.NEAR_RAD),
        "leg_skewness": leg.LEG_SKEWNESS,
        "std_growth": leg.STD_GROWTH,
        "most_growth": leg.MOST_GROWTH,
        "doubtful_growth": leg.DOUBTFUL_GROWTH,
        "start_square": leg.START_SQUARE,
        "cycle_variance": parameters[cycle : cycle + 3],
        "velocity_variance": parameters[velocity : velocity + 2],
        "std_scale": np.array(tracker.std_scale),
        "x_start": unknown.x,
        "unknown_variance": np.diag(unknown.covariance),
        "known_variance": np.diag(known.covariance),
        "shortest_swing_s": between_samples(kernel.SHORTEST_SWING_S, interval_s, above=True),
        "longest_swing_s": between_samples(kernel.LONGEST_SWING_S, interval_s, above=False),
        "most_bias_square": kernel.MOST_BIAS_RAD_S**2,
        "states": len(unknown.x),
        "past_rates": unknown.rates.shape[1],
        "past_angles": unknown.past.shape[1],
    }


def _network(
    merged: tuple[FloatArray, FloatArray, FloatArray, float],
    n_past_rates: int,
    suffix: str,
    tracked: bool,
) -> str:
    """Write the network as a function without loops; the second layer is folded into the first.

    In float with a tracker, it gives the change from the latest deviation: the weight of that is
    close to one, and its rounding, a share of the leak, would add up in the heading.
    """
    by_change = bool(suffix) and tracked and len(merged[2]) == 1
    past = [f"rates[{k}]" for k in range(n_past_rates)]
    past += [f"past[{k}]" for k in range(merged[0].shape[1] - 1 - n_past_rates)]
    lines = [
        *([_tanh_excess()] if by_change else []),
        f"#define NETWORK_BY_CHANGE {int(by_change)} /* gives the change from past[0] */",
        "/* Deviation from the posture; past rates and deviations, newest first. The scales are in",
        " * the weights, and so is the output's weight of a neuron. */",
        "static narx_real network_output(narx_real rate, const narx_real *rates,",
        "                                const narx_real *past)",
        "{",
        "    narx_real sum, change, output;" if by_change else "    narx_real sum, output;",
        *([] if n_past_rates else ["    (void)rates;"]),
    ]
    assigned = "output ="
    for w1, b1, w2 in zip(*merged[:3], strict=True):
        if w2 == 0.0:
            continue
        weights = w1 * w2
        if by_change:
            weights[1 + n_past_rates] -= 1.0
        terms = [f"{_text(w, suffix)} * {x}" for w, x in zip(weights, ["rate", *past], strict=True)]
        terms += [_text(b1 * w2, suffix)] if b1 else []
        total = "change" if by_change else "sum"
        lines += [f"    {total} = " + " +\n          ".join(terms) + ";"]
        lines += ["    sum = past[0] + change;"] if by_change else []
        scaled = f"sum * {_text(1.0 / w2, suffix)}"
        tanh = f"{_text(w2, suffix)} * hyperbolic_tangent({scaled})"
        if by_change:
            tanh = f"change + {_text(w2, suffix)} * tanh_excess({scaled})"
        elif suffix:
            square = f"{_text((_CUBIC_TANH_LIMIT * w2) ** 2, suffix)}"
            third = _text(-1.0 / (3.0 * w2**2), suffix)
            tanh = f"sum * sum < {square} ? sum + sum * (sum * sum) * {third}\n        : {tanh}"
        lines += [f"    {assigned} {tanh};"]
        assigned = "output +="
    if merged[3] or assigned == "output =":
        lines += [f"    {assigned} {_text(merged[3], suffix)};"]
    return "\n".join([*lines, "    return output;", "}", ""])


def _tanh_excess() -> str:
    """Write tanh(x) - x in float, to whose own digits it is accurate."""
    excess = np.array([-1 / 3, 2 / 15, -17 / 315, 62 / 2835])
    return "\n".join(
        [
            "/* tanh(x) - x, to its own digits: what it lacks would add up in the heading. */",
            "static narx_real tanh_excess(narx_real x)",
            "{",
            "    const narx_real u = x * x;",
            f"    if (u < {_text(_EXCESS_LIMIT**2, 'f')})",
            f"        return x * u * ({_horner(excess, 'f')});",
            "    return hyperbolic_tangent(x) - x;",
            "}",
            "",
        ]
    )


def _series(tracked: bool, suffix: str) -> dict[str, str]:
    """Short series of u = x^2 by the template's names.

    A tracker's heading adds up what is wrong with every turn. Without one, shorter series do.
    """

    def over(function: Any) -> Any:
        return lambda x: np.where(x == 0.0, 1.0, function(x) / np.where(x == 0.0, 1.0, x))

    short, long, narrow = _SHORT_SINE_LIMIT_RAD, _SINE_LIMIT_RAD, _SECANT_LIMIT_RAD
    more = int(tracked)
    series: dict[str, FloatArray] = {
        "sine": _even_series(over(np.sin), long, 3 + more),
        "cosine": _even_series(np.cos, long, 3 + more),
        "short_sine": _even_series(over(np.sin), short, 2 + more),
        "short_cosine": _even_series(np.cos, short, 2 + more),
        "secant": _even_series(lambda x: 1.0 / np.cos(x), narrow, 2 + more),
        "tangent": _even_series(over(np.tan), narrow, 1 + 2 * more),
        "tanh": np.array([1.0, -1 / 3, 2 / 15]),
    }
    return {name: _horner(numbers, suffix) for name, numbers in series.items()}


def _horner(coefficients: FloatArray, suffix: str) -> str:
    """Write a polynomial in u, its lowest power first."""
    first = _text(coefficients[0], suffix)
    if len(coefficients) == 1:
        return first
    inner = _horner(coefficients[1:], suffix)
    return f"{first} + u * {inner if len(coefficients) == 2 else f'({inner})'}"


def _even_series(function: Any, limit: float, degree: int) -> FloatArray:
    """Coefficients of ``function(x)`` in powers of x^2 for -limit < x < limit."""
    half = 0.5 * limit**2
    interpolate: Any = chebyshev.chebinterpolate
    in_t = chebyshev.cheb2poly(interpolate(lambda t: function(np.sqrt(half * (1.0 + t))), degree))
    result = np.zeros(1)
    for coefficient in in_t[::-1]:
        result = polynomial.polyadd(polynomial.polymul(result, [-1.0, 1.0 / half]), [coefficient])
    return np.asarray(result)[: degree + 1]
