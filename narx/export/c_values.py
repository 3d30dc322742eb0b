"""Values that are filled into the C templates."""

import math
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from narx.export.neurons import merged_neurons, physical_weights
from narx.export.recurrence import refuse_own_scaling, samples_in_movement
from narx.export.tracker_numbers import between_samples, exported_numbers
from narx.inference.checkpoint import Checkpoint
from narx.inference.tracking import Tracking
from narx.inference.washout import washout_gain
from narx.kernels import tracker as kernel
from narx.kernels.clock import ON_TICK
from narx.kernels.limits import COS_FRONTAL_MIN, FORCE_LIMIT_M_S2
from narx.kernels.short_gap import BRIDGED_RAD_S2, LONGEST_BRIDGED_S
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S
from narx.types import FloatArray

# a number's suffix and a function's are the same letter in C
_SUFFIX = {"double": "", "float": "f"}
# in float neurons are one that differ by less than its accuracy asks for
_SAME = {"double": 1e-8, "float": 1e-3}
# range of the short series; beyond it the library's functions
_SINE_LIMIT_RAD, _TANH_LIMIT = 1.2, 0.12

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
    "swing_decay": kernel.SWING_DECAY,
    "span_decay": kernel.SPAN_DECAY,
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
    w1, b1, w2, b2 = merged_neurons(*physical_weights(checkpoint), _SAME[precision])
    recurrence = _start_up(checkpoint) if checkpoint.tracker is None else _tracked(checkpoint)
    numbers = {
        "sampling_rate_hz": float(checkpoint.model.sampling_rate_hz),
        "interval_s": interval_s,
        "half_interval_s": 0.5 * interval_s,
        "rate_limit_rad_s": clock.limit_rad_s,
        "force_limit_m_s2": FORCE_LIMIT_M_S2,
        "max_gap_s": clock.max_gap_s,
        "longest_pause_s": clock.longest_pause_s,
        "on_tick": ON_TICK,
        "smallest_cos_frontal": COS_FRONTAL_MIN,
        "sine_limit": _SINE_LIMIT_RAD,
        "tanh_square": _TANH_LIMIT**2,
        "t1": -1 / 3,
        "t2": 2 / 15,
        **{f"s{i}": c for i, c in enumerate(_even_series(np.sinc, 1 / math.pi))},
        **{f"c{i}": c for i, c in enumerate(_even_series(np.cos, 1.0))},
        "w1": w1,
        "b1": b1,
        "w2": w2,
        "b2": b2,
        **recurrence,
    }
    counts = {
        "inputs": 6 if checkpoint.method().needs_accelerometer else 3,
        "lost_most": clock.lost_most,
        "tracked": int(checkpoint.tracker is not None),
        "short_series": int(precision == "float"),
        "hidden": len(w2),
        "biases": int(bool(b1.any() or b2)),
        "past_inputs": checkpoint.model.structure.n_input_state,
        "output_lags": checkpoint.model.structure.output_lags,
        "n_state": checkpoint.model.structure.n_state,
    }
    return {
        "real": precision,
        "f": suffix,
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
    return {
        "leak_rad_s": float(start_up.leak_rad_s),
        "settling_gain": float(start_up.settling_gain),
        "settling_s": float(start_up.settling_s),
        "averaged_from_s": float(start_up.averaged_from_s),
        "averaging_s": float(start_up.averaging_s),
        "pi_per_averaging": math.pi / start_up.averaging_s if start_up.averaging_s else 0.0,
        "movement_gain": interval_s / (MOVEMENT_TIME_CONSTANT_S + interval_s),
        "movement_square": MOVEMENT_RAD_S**2,
        "washout_gain": washout_gain(checkpoint.washout_s, interval_s),
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
        "centre_loss": 1.0 - parameters[kernel.CENTRE_DECAY],
        "longest_gap_s": kernel.LONGEST_GAP_S,
        "longest_bridged_s": between_samples(LONGEST_BRIDGED_S, interval_s, above=False),
        "bridged_rad_s2": BRIDGED_RAD_S2,
        "swing_time_s": interval_s / (parameters[kernel.SWING_DECAY] - 1.0),
        "most_doubt": kernel.MOST_DOUBT,
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


def _even_series(function: Any, unit: float) -> FloatArray:
    """Coefficients of ``function(unit x)`` in powers of x^2, for the range of the short series."""
    half = 0.5 * _SINE_LIMIT_RAD**2
    interpolate: Any = chebyshev.chebinterpolate
    series = interpolate(lambda t: function(unit * np.sqrt(half * (1.0 + t))), 3)
    in_t = chebyshev.cheb2poly(series)
    result = np.zeros(1)
    for coefficient in in_t[::-1]:
        result = polynomial.polyadd(polynomial.polymul(result, [-1.0, 1.0 / half]), [coefficient])
    return np.asarray(result)[:4]
