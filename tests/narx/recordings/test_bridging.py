"""Gaps filled by an autoregressive model: exact for sums of sines, bounded for noise."""

import numpy as np
import pytest

from narx.recordings.bridging import bridged


def _sines(time_s):
    phase = 2 * np.pi * 0.9 * time_s
    return np.column_stack([np.sin(phase) + 0.4 * np.sin(2 * phase + 0.9), 3.0 + np.cos(phase)])


def _holed(values, *gaps):
    holed = values.copy()
    for start, stop in gaps:
        holed[start:stop] = np.nan
    return holed


@pytest.mark.parametrize("rate_hz", [25.0, 100.0, 250.0])
# with a third of the samples missing, a model of the rest with zeros in the gaps is wrong by 0.12
@pytest.mark.parametrize("begins_s", [(8.0, 15.0, 22.3), np.arange(3.0, 28.0, 2.5)])
def test_a_sum_of_sines_is_continued_over_most_of_a_period(rate_hz, begins_s):
    values = _sines(np.arange(int(30 * rate_hz)) / rate_hz)
    gaps = [(int(s * rate_hz), int((s + 0.8) * rate_hz)) for s in begins_s]
    filled = bridged(_holed(values, *gaps), rate_hz, 1.0)
    # a straight line is wrong by more than the amplitude
    assert np.abs(filled - values).max() < 0.05
    outside = np.ones(len(values), dtype=bool)
    for start, stop in gaps:
        outside[start:stop] = False
    np.testing.assert_array_equal(filled[outside], values[outside])


def test_the_estimate_minimises_the_prediction_error():
    rng = np.random.default_rng(0)
    noise = rng.standard_normal(4000)
    signal = np.zeros(4000)
    for k in range(2, 4000):
        # a resonance at an eighth of the rate; the best estimate of one sample is known
        signal[k] = 1.2 * signal[k - 1] - 0.8 * signal[k - 2] + noise[k]
    k = 2000
    a = np.array([1.0, -1.2, 0.8])
    weights = np.correlate(a, a, "full")
    expected = -(weights @ np.where(np.arange(-2, 3) == 0, 0.0, signal[k - 2 : k + 3])) / weights[2]
    filled = bridged(_holed(signal[:, None], (k, k + 1)), 10.0, 0.5)
    assert filled[k, 0] == pytest.approx(expected, abs=0.15)


def test_longer_gaps_and_the_ends_stay_missing():
    values = _sines(np.arange(3000) / 100.0)
    # a second between neighbours is filled, and no more
    holed = _holed(values, (0, 10), (1000, 1100), (2000, 2010), (2500, 2599), (2990, 3000))
    filled = bridged(holed, 100.0, 1.0)
    missing = np.isnan(filled).any(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(missing), np.r_[0:10, 1000:1100, 2990:3000])


def test_too_few_samples_for_a_model_stay_as_they_are():
    holed = _holed(_sines(np.arange(200) / 100.0), (100, 120))
    np.testing.assert_array_equal(bridged(holed, 100.0, 1.0), holed)


def test_noise_and_rest_stay_within_their_own_size():
    noise = np.random.default_rng(1).standard_normal((3000, 1))
    filled = bridged(_holed(noise, (1000, 1050)), 100.0, 1.0)
    assert np.abs(filled[1000:1050]).max() < 1.0
    still = np.full((3000, 3), 0.25)
    np.testing.assert_array_equal(bridged(_holed(still, (500, 530)), 100.0, 1.0), still)
