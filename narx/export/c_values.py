"""Values that are filled into the C templates."""

import math

import numpy as np

from narx.inference.checkpoint import Checkpoint
from narx.inference.tracking import Tracking
from narx.kernels import tracker as kernel
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.types import FloatArray


def number(value: float, suffix: str) -> str:
    """Write a number so that C reads exactly the same value.

    Parameters
    ----------
    value : float
        Finite number.
    suffix : str
        Suffix of the type: empty for ``double``, ``f`` for ``float``.

    Returns
    -------
    str
        Shortest decimal form.
    """
    return f"{float(value)!r}{suffix}"


def row(values: FloatArray, suffix: str) -> str:
    """Write a list of numbers.

    Parameters
    ----------
    values : ndarray, shape (N,)
        Finite numbers.
    suffix : str
        As for `number`.

    Returns
    -------
    str
        The numbers, separated by commas.
    """
    return ", ".join(number(value, suffix) for value in values)


def network_values(checkpoint: Checkpoint, suffix: str) -> dict[str, str]:
    """Weights of the network, used by both templates.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.
    suffix : str
        As for `number`.

    Returns
    -------
    dict of str to str
        By the templates' names.
    """
    model = checkpoint.model
    structure = model.structure
    weights = model.weights.detach().numpy()
    w1 = weights[structure.w1].reshape(structure.hidden, structure.n_features)
    return {
        "sampling_rate_hz": number(model.sampling_rate_hz, suffix),
        "hidden": str(structure.hidden),
        "past_inputs": str(structure.n_input_state),
        "w1": ",\n".join(f"    {{{row(values, suffix)}}}" for values in w1),
        "b1": row(weights[structure.b1], suffix),
        "w2": row(weights[structure.w2], suffix),
        "b2": number(weights[structure.b2], suffix),
        "smallest_cos_frontal": number(COS_FRONTAL_MIN, suffix),
        "pi": number(math.pi, suffix),
        "f": suffix,
    }


# scalars of the tracker, by their names in the template
_NUMBERS = {
    "interval": kernel.INTERVAL,
    "leak": kernel.LEAK,
    "angle_noise": kernel.ANGLE_NOISE,
    "rate_noise": kernel.RATE_NOISE,
    "centre_decay": kernel.CENTRE_DECAY,
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
    "rate_scale": kernel.RATE_SCALE,
    "angle_scale": kernel.ANGLE_SCALE,
}


def tracked_values(checkpoint: Checkpoint, suffix: str) -> dict[str, str]:
    """All values of ``template_tracked`` other than names and types.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry; it has a tracker.
    suffix : str
        As for `number`.

    Returns
    -------
    dict of str to str
        Values by their names in the template.
    """
    tracker, model = checkpoint.tracker, checkpoint.model
    assert tracker is not None
    parameters = tracker.numbers(model)
    unknown, known = (Tracking(tracker, model, pose) for pose in (None, np.zeros(3)))
    cycle, velocity = kernel.CYCLE_VARIANCE, kernel.VELOCITY_VARIANCE
    return {
        **network_values(checkpoint, suffix),
        **{name: number(parameters[at], suffix) for name, at in _NUMBERS.items()},
        "cycle_variance": row(parameters[cycle : cycle + 3], suffix),
        "velocity_variance": row(parameters[velocity : velocity + 2], suffix),
        "std_scale": row(np.array(tracker.std_scale), suffix),
        "x_start": row(unknown.x, suffix),
        "unknown_variance": row(np.diag(unknown.covariance), suffix),
        "known_variance": row(np.diag(known.covariance), suffix),
        "shortest_swing_s": number(kernel.SHORTEST_SWING_S, suffix),
        "longest_swing_s": number(kernel.LONGEST_SWING_S, suffix),
        "most_bias_square": number(kernel.MOST_BIAS_RAD_S**2, suffix),
        "inputs": "6" if tracker.aided else "3",
        "states": str(len(unknown.x)),
        "past_rates": str(unknown.rates.shape[1]),
        "past_angles": str(unknown.past.shape[1]),
    }
