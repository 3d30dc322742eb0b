"""Initial weights: leaky integrators, each with a random nonlinearity."""

import numpy as np

from narx.network.model import Narx
from narx.types import FloatArray

# Size of the hidden neurons' arguments. A relative nonlinearity b of the tanh makes the angle leak
# by the fraction b at every sample: at 500 Hz a slope of 0.1 would give a leak of 2 rad/s at 30
# degrees, far too much for gait. A slope of 0.01 gives 0.02 rad/s.
SLOPE = 0.01


def leaky_integrator(model: Narx, leak_rad_s: float) -> FloatArray:
    """Coefficients of the leaky integrator 1/(s + leak) on the network's features.

    Parameters
    ----------
    model : Narx
        Gives sampling rate, scales and delays.
    leak_rad_s : float
        Corner frequency, rad/s.

    Returns
    -------
    ndarray, shape (n_features,)
        Coefficients of v_k, v_{k-1}, ..., p_{k-1}, p_{k-2}, ... in normalised units.

    Notes
    -----
    Tham et al., eqs. (4)-(6), corrected. Eq. (5), p'' + wc p' = v', gives by backward Euler
    ``(1 + e) p_k = Ts (v_k - v_{k-1}) + (2 + e) p_{k-1} - p_{k-2}`` with e = Ts wc; the printed
    form lacks the (1 + e) and is unstable. Its pole at 1 cancels the zero at 1; the remainder is
    ``(1 + e) p_k = Ts v_k + p_{k-1}``, used here with the trapezoid ``(v_k + v_{k-1}) / 2``.
    """
    structure, scaled = model.structure, model.normalisation
    interval_s = 1.0 / model.sampling_rate_hz
    damping = 1.0 + interval_s * leak_rad_s
    coefficients = np.zeros(structure.n_features)
    averaged = min(structure.input_lags, 2)
    gain = interval_s * scaled.rate_scale_rad_s / scaled.angle_scale_rad
    coefficients[:averaged] = gain / averaged / damping
    coefficients[structure.n_input_features] = 1.0 / damping
    return coefficients


def leaky_integrator_weights(
    model: Narx, leak_rad_s: float = 0.15, slope: float = SLOPE
) -> FloatArray:
    """Weights of a nearly linear network that is a leaky integrator.

    Parameters
    ----------
    model : Narx
        Gives structure, sampling rate and scales.
    leak_rad_s : float
        Corner frequency, rad/s.
    slope : float
        Size of the hidden neurons' arguments; small values keep tanh nearly linear.

    Returns
    -------
    ndarray, shape (P,)
        Flat weights; all hidden neurons are equal, without biases.
    """
    structure = model.structure
    weights = np.zeros(structure.n_weights)
    rows = np.tile(slope * leaky_integrator(model, leak_rad_s), (structure.hidden, 1))
    weights[structure.w1] = rows.ravel()
    weights[structure.w2] = 1.0 / (slope * structure.hidden)
    return weights


def typical_sizes(model: Narx, slope: float = SLOPE) -> FloatArray:
    """Return the typical size of each weight.

    Parameters
    ----------
    model : Narx
        Gives the structure.
    slope : float
        As in `leaky_integrator_weights`.

    Returns
    -------
    ndarray, shape (P,)
        The slope for weights into the hidden neurons, its inverse (divided among the neurons) for
        weights out of them, and 1 for the last bias.
    """
    structure = model.structure
    sizes = np.ones(structure.n_weights)
    sizes[structure.w1] = slope
    sizes[structure.b1] = slope
    sizes[structure.w2] = 1.0 / (slope * structure.hidden)
    return sizes


def random_weights(
    model: Narx,
    rng: np.random.Generator,
    leak_rad_s: tuple[float, float] = (0.05, 0.5),
    slope: float = SLOPE,
    spread: float = 0.05,
) -> FloatArray:
    """Draw weights whose linear part is a leaky integrator.

    Parameters
    ----------
    model : Narx
        Network to initialise; odd networks get zero biases.
    rng : numpy.random.Generator
        Random number generator.
    leak_rad_s : tuple of two floats
        Range of the corner frequency, rad/s, drawn log-uniformly.
    slope : float
        Size of the hidden neurons' arguments; small values keep tanh nearly linear.
    spread : float
        Random part of the hidden weights, relative to `slope`.

    Returns
    -------
    ndarray, shape (P,)
        Flat weights.
    """
    structure = model.structure
    leak = np.exp(rng.uniform(*np.log(leak_rad_s)))
    linear = leaky_integrator(model, leak)
    share = rng.dirichlet(np.full(structure.hidden, 3.0))
    second = rng.uniform(0.5, 1.5, structure.hidden) * share / slope
    noise = spread * slope * rng.normal(size=(structure.hidden, structure.n_features))
    bias = np.zeros(structure.hidden)
    if not model.odd:
        bias = slope * rng.normal(size=structure.hidden)
    # hidden neurons have different slopes for the same features; the second layer's sum of
    # slopes (tanh'(bias) included) restores the linear part exactly
    effective = second * (1.0 - np.tanh(bias) ** 2)
    first = (
        noise + np.outer(np.ones(structure.hidden), linear - effective @ noise) / effective.sum()
    )
    weights = np.zeros(structure.n_weights)
    weights[structure.w1] = first.ravel()
    weights[structure.b1] = bias
    weights[structure.w2] = second
    weights[structure.b2] = -float(second @ np.tanh(bias))
    return weights
