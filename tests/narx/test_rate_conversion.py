"""Bringing a recording to a network's clock and back keeps what the gyroscope integrated."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_trapezoid

from narx.rate_conversion import RateConversion


@settings(deadline=None, max_examples=30)
@given(
    recording=st.sampled_from([50.0, 94.3, 100.0, 199.0, 500.0]),
    network=st.sampled_from([50.0, 100.0, 123.4, 500.0]),
    seed=st.integers(0, 50),
)
def test_an_integrator_is_brought_back_exactly(recording, network, seed):
    rng = np.random.default_rng(seed)
    rates = rng.normal(size=(200, 3))
    conversion = RateConversion(rates, recording, network)
    ticks = conversion.network_rates_rad_s
    integral = np.cumsum(ticks, axis=0) / network - ticks[:1] / network
    expected = cumulative_trapezoid(rates, dx=1 / recording, axis=0, initial=0.0)
    np.testing.assert_allclose(conversion.to_recording(integral), expected, atol=1e-9)


def test_same_rate_changes_nothing_but_the_half_sample():
    rates = np.cumsum(np.random.default_rng(0).normal(size=(50, 2)), axis=0)
    conversion = RateConversion(rates, 100.0, 100.0)
    np.testing.assert_allclose(
        conversion.network_rates_rad_s[1:], (rates[1:] + rates[:-1]) / 2, atol=1e-12
    )


@pytest.mark.parametrize("n", [0, 1, 2])
def test_very_short_recordings(n):
    conversion = RateConversion(np.ones((n, 3)), 100.0, 500.0)
    assert conversion.to_recording(np.zeros_like(conversion.network_rates_rad_s)).shape == (n, 3)
