import numpy as np
import pytest

from narx.errors import RecordingError
from narx.inference.clocks import ClockConversion


def wave(time_s):
    return np.stack([np.sin(2 * np.pi * time_s), np.cos(4 * np.pi * time_s)], axis=1)


def test_a_regular_recording_passes_as_it_is():
    time = 3.7 + np.arange(500) / 128.0
    conversion = ClockConversion(time, 0.05, "x")
    assert conversion.sampling_rate_hz == pytest.approx(128.0, rel=1e-12)
    values = np.random.default_rng(0).normal(size=(500, 2))
    on_clock = conversion.to_clock(values)
    np.testing.assert_allclose(on_clock, values, atol=1e-10)
    back = conversion.to_samples(on_clock, np.ones(500, dtype=bool))
    np.testing.assert_allclose(back, values, atol=1e-10)


def test_irregular_there_and_back():
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.006, 0.014, size=1000))
    conversion = ClockConversion(time, 0.05, "x")
    on_clock = conversion.to_clock(wave(time))
    np.testing.assert_allclose(on_clock, wave(conversion.clock_s), atol=1e-4)
    back = conversion.to_samples(on_clock, np.ones(1000, dtype=bool))
    np.testing.assert_allclose(back, wave(time), atol=3e-4)


def test_short_gaps_are_bridged_and_long_ones_stay():
    time = np.delete(np.arange(1000) / 100.0, np.r_[200:203, 500:560])
    there = np.ones(len(time), dtype=bool)
    there[100] = False
    values = wave(time)
    values[100] = np.nan
    conversion = ClockConversion(time, 0.05, "x")
    on_clock = conversion.to_clock(values)
    gap = (conversion.clock_s > 4.995) & (conversion.clock_s < 5.595)
    np.testing.assert_array_equal(np.isnan(on_clock).any(axis=1), gap)
    back = conversion.to_samples(on_clock, there)
    assert np.isnan(back[100]).all()
    np.testing.assert_allclose(back[there], wave(time)[there], atol=1e-4)


def test_a_slow_recording_has_no_gaps():
    time = np.arange(50) / 10.0
    conversion = ClockConversion(time, 0.05, "x")
    assert np.isfinite(conversion.to_clock(wave(time))).all()
    uneven = time + np.random.default_rng(2).uniform(-0.01, 0.01, size=50)
    assert np.isfinite(ClockConversion(uneven, 0.05, "x").to_clock(wave(uneven))).all()


def test_the_tick_of_a_sample_is_the_nearest():
    uneven = 3.7 + np.arange(300) / 50.0 + np.random.default_rng(3).uniform(-0.009, 0.009, 300)
    conversion = ClockConversion(uneven, 0.05, "x")
    away = np.abs(uneven[:, None] - conversion.clock_s)
    np.testing.assert_array_equal(conversion.nearest_ticks(), away.argmin(axis=1))
    assert (np.diff(conversion.nearest_ticks()) != 1).any()


def test_values_before_and_after_a_missing_tick_do_not_affect_each_other():
    """A jump in a pause, such as that of a quality, does not ring in the samples beside it."""
    time = np.arange(100) / 100.0 + np.random.default_rng(4).uniform(-0.002, 0.002, 100)
    conversion = ClockConversion(time, 0.05, "x")
    step = np.where(np.arange(100) < 50, 0.0, 1.0)[:, None]
    step[50] = np.nan
    found = conversion.to_samples(step, np.ones(100, dtype=bool))[:, 0]
    np.testing.assert_allclose(found, found.round(), atol=1e-12)


@pytest.mark.parametrize("n", [0, 1])
def test_too_short(n):
    with pytest.raises(RecordingError, match=f"^walk: {n} samples, expected at least 2$"):
        ClockConversion(np.arange(n) * 0.01, 0.05, "walk")


def test_an_unobserved_column_does_not_affect_the_others():
    time = np.arange(200) * 0.01
    conversion = ClockConversion(time, 0.05, "x")
    values = np.tile([0.5, np.nan], (len(conversion.clock_s), 1))
    back = conversion.to_samples(values, np.ones(200, dtype=bool))
    np.testing.assert_allclose(back[:, 0], 0.5)
    assert np.isnan(back[:, 1]).all()
    unknown = np.full_like(values, np.nan)
    assert np.isnan(conversion.to_samples(unknown, np.ones(200, dtype=bool))).all()


@pytest.mark.parametrize(("n_ticks", "order"), [(1, None), (2, 1), (3, 1), (4, 3), (5, 3)])
def test_a_few_ticks_between_gaps_are_joined_by_a_line_or_a_cubic(n_ticks, order):
    time = np.arange(100) / 100.0
    time[51] += 0.003
    conversion = ClockConversion(time, 0.05, "x")
    values = np.full((100, 1), np.nan)
    values[50 : 50 + n_ticks, 0] = (conversion.clock_s[50 : 50 + n_ticks] - 0.45) ** (order or 1)
    found = conversion.to_samples(values, np.ones(100, dtype=bool))[51, 0]
    expected = np.nan if order is None else (time[51] - 0.45) ** order
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_sample_further_than_a_tick_from_the_known_ones_is_missing():
    time = np.arange(100) / 100.0
    time[[51, 52, 53]] = 0.513, 0.515, 0.524
    conversion = ClockConversion(time, 0.05, "x")
    values = np.arange(100.0)[:, None]
    values[50:53] = np.nan
    found = conversion.to_samples(values, np.ones(100, dtype=bool))[:, 0]
    np.testing.assert_allclose(found[51:54], [np.nan, np.nan, 52.4], rtol=1e-9)
