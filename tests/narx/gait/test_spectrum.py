import numpy as np
import pytest

from narx.errors import UserError
from narx.gait.spectrum import component_powers, hidden_neurons, single_sided_amplitude_spectrum


@pytest.mark.parametrize("n", [1000, 1001])
def test_a_sinusoid_gives_its_amplitude(n):
    t = np.arange(n) / 100.0
    frequency_hz = 37 * 100.0 / n
    values = 0.7 + 2.5 * np.cos(2 * np.pi * frequency_hz * t + 0.3)
    frequencies, amplitude = single_sided_amplitude_spectrum(values, 100.0)
    assert len(frequencies) == len(amplitude) == n // 2 + 1
    assert amplitude[0] == pytest.approx(0.7)
    assert frequencies[37] == pytest.approx(frequency_hz)
    assert amplitude[37] == pytest.approx(2.5)
    assert np.delete(amplitude, [0, 37]).max() < 1e-12


def test_the_nyquist_frequency_is_not_doubled():
    values = np.tile([1.0, -1.0], 50)
    _, amplitude = single_sided_amplitude_spectrum(values, 100.0)
    assert amplitude[-1] == pytest.approx(1.0)


def test_power_is_kept():
    values = np.random.default_rng(0).normal(size=1001)
    _, amplitude = single_sided_amplitude_spectrum(values, 100.0)
    power = amplitude[0] ** 2 + 0.5 * (amplitude[1:] ** 2).sum()
    assert power == pytest.approx(np.mean(values**2))


def strides(amplitudes, stride_hz=0.93, duration_s=60.0, jitter=0.0):
    """Harmonics of a stride whose times vary by `jitter` (standard deviation, relative)."""
    rng = np.random.default_rng(1)
    steps = stride_hz * (1 + jitter * np.repeat(rng.normal(size=600), 100))[: int(duration_s * 100)]
    phase = 2 * np.pi * np.cumsum(steps) / 100.0
    return sum(a * np.cos((k + 1) * phase + k) for k, a in enumerate(amplitudes))


@pytest.mark.parametrize("jitter", [0.0, 0.03])
@pytest.mark.parametrize(
    ("amplitudes", "expected"),
    [([2.0, 0.1], 1), ([2.0, 1.0, 0.05], 2), ([2.0, 1.0, 0.6, 0.2], 3), ([1, 1, 1, 1, 1], 5)],
)
def test_components_are_counted_up_to_98_percent(amplitudes, expected, jitter):
    assert hidden_neurons(strides(amplitudes, jitter=jitter), 100.0) == expected


def test_powers_of_the_harmonics():
    fundamental_hz, power = component_powers(strides([2.0, 1.0]), 100.0)
    assert fundamental_hz == pytest.approx(0.93, rel=0.01)
    np.testing.assert_allclose(power[:3], [0.8, 0.2, 0.0], atol=0.005)


def test_the_fraction_is_a_parameter():
    rate = strides([2.0, 1.0, 0.6, 0.2])
    assert hidden_neurons(rate, 100.0, power_fraction=0.5) == 1
    assert hidden_neurons(rate, 100.0, power_fraction=0.9) == 2


def test_drift_turning_and_noise_above_walking_do_not_count():
    rng = np.random.default_rng(2)
    rate = strides([2.0, 1.0, 0.6, 0.2])
    t = np.arange(len(rate)) / 100.0
    disturbed = rate + 0.5 * np.sin(2 * np.pi * 0.05 * t) + np.sin(2 * np.pi * 9.0 * t)
    assert hidden_neurons(disturbed + rng.normal(0, 0.2, len(t)), 100.0) == 3
    assert hidden_neurons(disturbed, 100.0, highest_hz=12.0) == 4


def test_no_walking_is_refused():
    with pytest.raises(UserError, match="no walking found"):
        hidden_neurons(np.zeros(1000), 100.0)


@pytest.mark.parametrize("values", [np.zeros(0), np.array([1.0, np.nan]), np.zeros((4, 2))])
def test_what_is_no_series_is_refused(values):
    with pytest.raises(UserError, match="expected one axis"):
        single_sided_amplitude_spectrum(values, 100.0)
