"""Starts are leaky integrators: corrected eq. (6) of Tham et al. against its transfer function."""

import numpy as np
import pytest
import torch
from scipy import signal

from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.structure import NarxStructure
from narx.training.initial_weights import (
    leaky_integrator,
    leaky_integrator_weights,
    random_weights,
    typical_sizes,
)


def model(hidden=3, lags=2, odd=True, rate_hz=500.0):
    return Narx(
        rate_hz, Normalisation(2.0, 0.5), NarxStructure(hidden, 1, lags, lags), odd, coupled=False
    )


def test_corrected_equation_6_is_stable_and_is_the_leaky_integrator():
    interval_s, corner = 1 / 500.0, 0.7
    e = interval_s * corner
    # as printed: a root outside the unit circle
    assert np.abs(np.roots([1.0, -(2.0 + e), 1.0])).max() > 1.0
    numerator = np.array([interval_s, -interval_s, 0.0])
    denominator = np.array([1.0 + e, -(2.0 + e), 1.0])
    np.testing.assert_allclose(np.sort(np.roots(denominator)), [1 / (1 + e), 1.0], atol=1e-12)
    # the pole at 1 meets the zero at 1; what remains is 1/(s + corner)
    frequency = 2 * np.pi * np.array([0.3, 1.0, 3.0])
    _, response = signal.freqz(numerator, denominator, worN=frequency * interval_s)
    np.testing.assert_allclose(response, 1 / (1j * frequency + corner), rtol=0.02)


@pytest.mark.parametrize("lags", [1, 2, 3])
def test_coefficients_have_the_response_of_a_leaky_integrator(lags):
    network, corner = model(lags=lags), 0.4
    c = leaky_integrator(network, corner)
    scale = network.normalisation.angle_scale_rad / network.normalisation.rate_scale_rad_s
    numerator, feedback = c[:lags] * scale, c[lags:]
    frequency = 2 * np.pi * np.array([0.2, 1.0, 5.0])
    _, response = signal.freqz(
        numerator, np.concatenate([[1.0], -feedback]), worN=frequency / 500.0
    )
    np.testing.assert_allclose(response, 1 / (1j * frequency + corner), rtol=0.05)


@pytest.mark.parametrize("odd", [True, False])
def test_small_signals_pass_as_through_a_leaky_integrator(odd):
    network = model(odd=odd)
    rng = np.random.default_rng(0)
    rates = np.zeros((2000, 3))
    rates[:, 0] = 0.02 * np.sin(2 * np.pi * np.arange(2000) / 500.0)
    linear = leaky_integrator_weights(network)
    for weights in (linear, random_weights(network, rng, leak_rad_s=(0.15, 0.1501))):
        with torch.no_grad():
            network.weights.copy_(torch.from_numpy(weights))
            angles, _ = network(torch.from_numpy(rates))
        b, a = signal.bilinear([1.0], [1.0, 0.15], fs=500.0)
        expected = signal.lfilter(b, a, rates[:, 0])
        np.testing.assert_allclose(angles[:, 0], expected, atol=2e-4)


def test_odd_networks_start_without_biases():
    network = model()
    weights = random_weights(network, np.random.default_rng(1))
    assert not weights[~network.trainable.numpy()].any()


def test_at_rest_random_weights_with_biases_have_the_linear_response():
    """The derivative of w2 tanh(w1 z + b1) at z = 0, with biases where tanh is far from linear."""
    network = model(odd=False)
    weights = random_weights(network, np.random.default_rng(2), leak_rad_s=(0.15, 0.15), slope=1.0)
    s = network.structure
    w1 = weights[s.w1].reshape(s.hidden, -1)
    slopes = weights[s.w2] / np.cosh(weights[s.b1]) ** 2
    np.testing.assert_allclose(slopes @ w1, leaky_integrator(network, 0.15), atol=1e-12)


def test_leaks_are_drawn_over_decades():
    """Their median is the geometric mean of the range, 0.158 rad/s; the arithmetic one is 0.275."""
    network, rng = model(rate_hz=50.0), np.random.default_rng(3)
    s, leaks = network.structure, []
    for _ in range(300):
        weights = random_weights(network, rng, leak_rad_s=(0.05, 0.5))
        feedback = weights[s.w2] @ weights[s.w1].reshape(s.hidden, -1)[:, s.n_input_features]
        leaks.append((1.0 / feedback - 1.0) * 50.0)
    assert np.median(leaks) == pytest.approx(np.sqrt(0.05 * 0.5), rel=0.15)
    assert 0.05 < min(leaks) < 0.06
    assert 0.4 < max(leaks) < 0.5


def test_typical_sizes_by_hand():
    network = model(hidden=2, odd=False)
    sizes = typical_sizes(network, slope=0.02)
    assert sizes.tolist() == pytest.approx([0.02] * 8 + [0.02] * 2 + [25.0] * 2 + [1.0])
