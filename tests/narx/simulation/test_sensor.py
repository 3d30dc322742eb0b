"""Each error of the sensor on its own."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import welch

from narx.errors import UserError
from narx.simulation.sensor import (
    SENSORS,
    TriadErrors,
    TriadModel,
    draw_triad_errors,
    measure,
    sensor_model,
)

PERFECT = TriadModel(
    full_range=10.0, scale_sd=0.0, misalignment_sd_rad=0.0, bias_sd=0.0, instability=0.0,
    instability_time_s=100.0, random_walk=0.0, noise_density=0.0,
)  # fmt: skip
EXACT = TriadErrors(np.eye(3), np.zeros(3))


def _measure(true, model=PERFECT, errors=EXACT, rate_hz=500.0, every=1, bandwidth_hz=100.0):
    rng = np.random.default_rng(0)
    return measure(true, rate_hz, every, model, errors, bandwidth_hz, 16, rng)


def test_a_perfect_sensor_only_rounds():
    reading = _measure(np.tile([1.0, -2.0, 3.0], (100, 1)))
    assert np.abs(reading - [1.0, -2.0, 3.0]).max() <= 0.5 * 20.0 / 2**16


@settings(max_examples=20, deadline=None)
@given(size=st.floats(0.0, 1e6), seed=st.integers(0, 100))
def test_readings_are_counts_within_the_range(size, seed):
    true = size * np.random.default_rng(seed).standard_normal((50, 3))
    reading = _measure(true)
    step = 20.0 / 2**16
    counts = reading / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    assert counts.min() >= -(2**15)
    assert counts.max() <= 2**15 - 1


def test_gain_and_bias_act_as_said():
    errors = TriadErrors(np.array([[1.1, 0.2, 0], [0, 1, 0], [0, 0, 0.9]]), np.array([0, 0.5, 0]))
    reading = _measure(np.tile([1.0, 2.0, 3.0], (10, 1)), errors=errors)
    np.testing.assert_allclose(reading[0], [1.5, 2.5, 2.7], atol=2e-4)


def test_specimens_vary_as_in_the_data_sheet():
    model = SENSORS["physilog"].gyroscope
    rng = np.random.default_rng(0)
    specimens = [draw_triad_errors(rng, model) for _ in range(2000)]
    gains = np.array([s.gain for s in specimens])
    assert np.std([s.bias for s in specimens]) == pytest.approx(model.bias_sd, rel=0.05)
    assert np.std(gains[:, 0, 0]) == pytest.approx(model.scale_sd, rel=0.08)
    assert np.std(gains[:, 0, 1]) == pytest.approx(model.misalignment_sd_rad, rel=0.08)


@pytest.mark.parametrize("every", [1, 5])
def test_white_noise_has_its_density(every):
    model = replace(PERFECT, noise_density=0.02)
    noise = _measure(np.zeros((200_000, 3)), model, every=every)
    frequency, power = welch(noise, 500.0 / every, nperseg=1024, axis=0)
    low = (frequency > 1.0) & (frequency < 10.0)
    assert np.sqrt(power[low].mean()) == pytest.approx(0.02, rel=0.05)


def test_low_pass_is_down_by_three_decibels_at_its_cutoff():
    t = np.arange(5000) / 2000.0
    true = np.column_stack([np.sin(2 * np.pi * f * t) for f in (5.0, 100.0, 400.0)])
    amplitude = np.abs(_measure(true, rate_hz=2000.0)[1000:]).max(axis=0)
    assert amplitude[0] == pytest.approx(1.0, abs=0.01)
    assert amplitude[1] == pytest.approx(np.sqrt(0.5), abs=0.01)
    assert amplitude[2] < 0.08


def test_nothing_above_two_fifths_of_the_output_rate_is_let_pass():
    """Of 500 Hz every fifth is read: 40 Hz is down by 3 dB, though the filter would be wider."""
    t = np.arange(20_000) / 500.0
    true = np.column_stack([np.sin(2 * np.pi * f * t) for f in (2.0, 39.9, 160.1)])
    amplitude = np.abs(_measure(true, every=5, bandwidth_hz=100.0)[200:]).max(axis=0)
    np.testing.assert_allclose(amplitude[:2], [1.0, np.sqrt(0.5)], atol=0.01)
    assert amplitude[2] < 0.05


def test_low_pass_begins_at_rest():
    reading = _measure(np.full((100, 3), 4.0))
    assert np.abs(reading - 4.0).max() < 2e-4


@pytest.mark.parametrize("every", [1, 4])
def test_bias_random_walk_grows_with_the_root_of_time(every):
    """Of the readings: how often the true signal is computed does not matter."""
    model = replace(PERFECT, random_walk=0.01)
    true = np.zeros((5000 * every, 3))
    ends = np.concatenate(
        [
            measure(true, 100.0 * every, every, model, EXACT, 40.0, 16, rng)[[1249, 4999]].T
            for rng in map(np.random.default_rng, range(150))
        ]
    )
    spread = ends.std(axis=0)
    assert spread[1] == pytest.approx(0.01 * np.sqrt(50.0), rel=0.12)
    assert spread[0] == pytest.approx(spread[1] / 2.0, rel=0.15)


@pytest.mark.parametrize("every", [1, 4])
def test_instability_keeps_its_size(every):
    model = replace(PERFECT, instability=0.1, instability_time_s=2.0)
    true = np.zeros((100_000 * every, 3))
    drift = _measure(true, model, rate_hz=100.0 * every, every=every, bandwidth_hz=40.0)
    assert drift.std() == pytest.approx(0.1, rel=0.15)
    lagged = np.mean(drift[:-200] * drift[200:]) / np.mean(drift**2)
    assert lagged == pytest.approx(np.exp(-1.0), abs=0.12)


def test_instability_begins_as_large_as_it_stays():
    model = replace(PERFECT, instability=0.1, instability_time_s=50.0)
    first = [
        measure(np.zeros((30, 3)), 100.0, 1, model, EXACT, 40.0, 16, np.random.default_rng(k))[0]
        for k in range(400)
    ]
    assert np.std(first) == pytest.approx(0.1, rel=0.1)


def test_the_papers_sensors():
    assert np.degrees(sensor_model("physilog").gyroscope.full_range) == pytest.approx(900.0)
    assert np.degrees(sensor_model("mpu6150").gyroscope.full_range) == pytest.approx(250.0)
    for name, ranges_g, noise_deg_s, noise_ug in (
        ("physilog", 11.0, 0.05, 350.0), ("mpu6150", 2.0, 0.005, 400.0),
    ):  # fmt: skip
        model = sensor_model(name)
        assert model.accelerometer.full_range == pytest.approx(ranges_g * 9.80665)
        assert np.degrees(model.gyroscope.noise_density) == pytest.approx(noise_deg_s)
        assert model.accelerometer.noise_density == pytest.approx(noise_ug * 9.80665e-6)
    biases = [np.degrees(sensor_model(s).gyroscope.bias_sd) for s in ("physilog", "mpu6150")]
    np.testing.assert_allclose(biases, [1.0, 5.0])
    biases = [sensor_model(s).accelerometer.bias_sd for s in ("physilog", "mpu6150")]
    np.testing.assert_allclose(biases, [0.0980665, 0.2941995])
    with pytest.raises(UserError, match="no sensor 'xsens'; known are physilog, mpu6150"):
        sensor_model("xsens")
