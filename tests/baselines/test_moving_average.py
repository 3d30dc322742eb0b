import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.baselines.moving_average import centred_moving_average


def test_an_even_window_gives_its_ends_half_a_weight():
    rng = np.random.default_rng(0)
    values = rng.normal(size=40)
    weights = np.array([0.5, *[1.0] * 9, 0.5]) / 10
    np.testing.assert_allclose(
        centred_moving_average(values, 0.1, 100.0)[5:-5],
        np.convolve(values, weights, mode="valid"),
        atol=1e-14,
    )


@pytest.mark.parametrize("window_s", [0.07, 0.0234, 0.1876])
def test_the_samples_are_joined_by_straight_lines(window_s):
    """Also where the window ends between two samples: the mean of a thousand points between."""
    values = np.random.default_rng(3).normal(size=60)
    half = 50.0 * window_s
    expected = [
        np.interp(
            k + half * (np.arange(20_000) + 0.5) / 10_000 - half, np.arange(60), values
        ).mean()
        for k in range(10, 50)
    ]
    found = centred_moving_average(values, window_s, 100.0)[10:50]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_a_sinusoid_over_whole_periods_vanishes_and_one_over_part_is_a_sinc():
    t = np.arange(4001) / 1000.0
    sine = np.sin(2 * np.pi * 2.0 * t)
    inside = (t > 1) & (t < 3)
    assert np.abs(centred_moving_average(sine, 0.5, 1000.0)[inside]).max() < 1e-12
    part = centred_moving_average(sine, 0.3, 1000.0)[inside]
    np.testing.assert_allclose(part, np.sinc(2.0 * 0.3) * sine[inside], atol=1e-5)


@settings(max_examples=30, deadline=None)
@given(
    slope=st.floats(-5, 5),
    level=st.floats(-1e3, 1e3),
    window_s=st.floats(0.011, 0.35),
)
def test_a_straight_line_stays_where_the_window_fits(slope, level, window_s):
    t = np.arange(100) / 100.0
    line = level + slope * t
    half = int(np.ceil(50 * window_s))
    inside = slice(half, 100 - half)
    averaged = centred_moving_average(line, window_s, 100.0)
    np.testing.assert_allclose(averaged[inside], line[inside], atol=1e-9)


def test_columns_are_averaged_one_by_one_and_a_constant_stays():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(50, 3))
    values[:, 2] = 4.2
    together = centred_moving_average(values, 0.07, 100.0)
    for column in range(3):
        alone = centred_moving_average(values[:, column], 0.07, 100.0)
        np.testing.assert_allclose(together[:, column], alone, atol=1e-12)
    np.testing.assert_allclose(together[:, 2], 4.2, atol=1e-12)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_short_signals(n):
    np.testing.assert_allclose(centred_moving_average(np.ones(n), 1.0, 100.0), np.ones(n))


def test_at_the_ends_the_window_is_truncated():
    """A line of slope 1 and windows of half a width of two samples: the middle of what is left."""
    found = centred_moving_average(np.arange(10.0), 0.04, 100.0)
    np.testing.assert_allclose(found, [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 7.5, 8.0])
