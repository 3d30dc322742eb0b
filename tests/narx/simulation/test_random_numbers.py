"""Named random streams, and noise with long memory."""

import numpy as np
import pytest

from narx.simulation.random_numbers import persistent_noise, smooth_noise, stream


def test_streams_depend_only_on_their_names():
    first = stream(1, "S1", "slow").standard_normal(5)
    stream(1, "S2", "slow").standard_normal(100)
    np.testing.assert_array_equal(first, stream(1, "S1", "slow").standard_normal(5))
    for other in (stream(2, "S1", "slow"), stream(1, "S1", "fast"), stream(1, "slow", "S1")):
        assert np.abs(first - other.standard_normal(5)).max() > 0.01


@pytest.mark.parametrize("exponent", [0.5, 0.75, 0.9])
def test_persistent_noise_scales_as_asked(exponent):
    noise = persistent_noise(np.random.default_rng(0), 512, 200, exponent)
    assert noise.shape == (512, 200)
    assert np.std(noise) == pytest.approx(1.0, abs=0.08)
    # the spectral slope is 1 - 2 exponent
    power = np.mean(np.abs(np.fft.rfft(noise * np.hanning(512)[:, None], axis=0)) ** 2, axis=1)
    frequency = np.fft.rfftfreq(512)
    slope = np.polyfit(np.log(frequency[4:200]), np.log(power[4:200]), 1)[0]
    assert slope == pytest.approx(1.0 - 2.0 * exponent, abs=0.1)


def test_smooth_noise_is_a_function_of_time():
    noise = smooth_noise(np.random.default_rng(3), 0.0, 400.0, 0.5, 4)
    slow, fast = np.arange(0.0, 400.0, 0.01), np.arange(0.0, 400.0, 0.002)
    np.testing.assert_allclose(noise(slow), noise(fast)[::5], atol=1e-9)
    assert np.std(noise(fast)) == pytest.approx(1.0, abs=0.15)
    power = np.abs(np.fft.rfft(noise(slow)[:, 0])) ** 2
    frequency = np.fft.rfftfreq(len(slow), 0.01)
    assert power[frequency > 1.0].sum() < 0.02 * power[1:].sum()
    # flat up to its bandwidth: the lower half of the band holds half of the power
    lower = (frequency > 0.0) & (frequency < 0.25)
    assert power[lower].sum() / power[1:].sum() == pytest.approx(0.5, abs=0.15)
