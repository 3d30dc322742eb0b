"""Conversion to a network's rate and back preserves the integral of the gyroscope."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_trapezoid

from narx.inference.clocks import RateConversion

RATES_HZ = st.sampled_from([50.0, 94.3, 100.0, 199.0, 500.0])


@settings(deadline=None, max_examples=30)
@given(recording=RATES_HZ, network=RATES_HZ, seed=st.integers(0, 50))
def test_nothing_that_turned_is_lost(recording, network, seed):
    rates = np.random.default_rng(seed).normal(size=(200, 3))
    conversion = RateConversion(rates, recording, network)
    ticks = conversion.network_rates_rad_s
    integral = cumulative_trapezoid(rates, dx=1 / recording, axis=0, initial=0.0)
    # for any noise, an integrator on the network's clock differs by at most this bound
    joined = cumulative_trapezoid(ticks, dx=1 / network, axis=0, initial=0.0)
    back = conversion.to_recording(joined)
    bound = np.abs(rates).max() * (1 / network + 1 / recording)
    assert np.abs(back - integral).max() < bound


@settings(deadline=None, max_examples=30)
@given(recording=RATES_HZ, network=RATES_HZ, phase=st.floats(0, 6.3))
def test_an_integrator_comes_back_without_delay(recording, network, phase):
    """A 40 degree swing at stride frequency; half a sample of delay would cost 1.3 degrees."""
    time = np.arange(round(5 * recording)) / recording
    angle = 0.35 * np.sin(2 * np.pi * 0.9 * time + phase)
    rates = 0.35 * 2 * np.pi * 0.9 * np.cos(2 * np.pi * 0.9 * time + phase)
    conversion = RateConversion(rates[:, None], recording, network)
    ticks = conversion.network_rates_rad_s
    back = conversion.to_recording(
        angle[0] + cumulative_trapezoid(ticks, dx=1 / network, axis=0, initial=0.0)
    )
    np.testing.assert_allclose(np.rad2deg(back[:, 0] - angle), 0.0, atol=0.2)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 500.0])
def test_same_rate_keeps_samples_but_for_the_noise_above_half_of_it(rate_hz):
    rates = np.cumsum(np.random.default_rng(0).normal(size=(50, 2)), axis=0)
    ticks = RateConversion(rates, rate_hz, rate_hz).network_rates_rad_s
    means = (rates[1:] + rates[:-1]) / 2
    np.testing.assert_allclose(ticks[1:-1], (means[1:] + means[:-1]) / 2, atol=1e-12)
    straight = np.linspace(1, 2, 50)[:, None]
    ticks = RateConversion(straight, rate_hz, rate_hz).network_rates_rad_s
    np.testing.assert_allclose(ticks[1:-1], straight[1:-1], atol=1e-12)


def test_a_constant_rate_is_constant_up_to_both_ends():
    """Before the first sample and after the last, the rate is that of the nearest one."""
    ticks = RateConversion(np.full((60, 1), 2.0), 60.0, 25.0).network_rates_rad_s
    np.testing.assert_allclose(ticks, 2.0, rtol=1e-12)
    ramp = np.arange(60.0)[:, None]
    ticks = RateConversion(ramp, 60.0, 60.0).network_rates_rad_s
    # half of an end's tick has the rate of the end, the other half its mean with the neighbour
    np.testing.assert_allclose(ticks[[0, -1], 0], [0.25, 58.75])


@pytest.mark.parametrize("rate_hz", [29.7, 94.3, 148.0])
def test_the_last_sample_has_a_tick_whatever_the_rounding(rate_hz):
    for n in range(1, 200):
        assert len(RateConversion(np.ones((n, 1)), rate_hz, rate_hz).network_rates_rad_s) == n


@pytest.mark.parametrize("n", [0, 1, 2])
def test_very_short_recordings(n):
    conversion = RateConversion(np.ones((n, 3)), 100.0, 500.0)
    assert conversion.to_recording(np.zeros_like(conversion.network_rates_rad_s)).shape == (n, 3)
