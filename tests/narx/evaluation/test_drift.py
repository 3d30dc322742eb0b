import numpy as np
import pytest
from scipy import signal, stats

from narx.errors import MethodNotApplicableError
from narx.evaluation.drift import block_errors, drift_test

TIME_S = np.arange(0, 1800, 0.1)


def walk_error(generator, memory_s=0.0):
    """Error of a steady walk in rad: a part every stride, noise, and a bias that wanders."""
    error = 0.05 * np.sin(2 * np.pi * TIME_S / 1.1)
    error += generator.normal(0, 0.02, len(TIME_S))
    if memory_s:
        memory = np.exp(-0.1 / memory_s)
        noise = generator.normal(0, 0.03 * np.sqrt(1 - memory**2), len(TIME_S))
        error += signal.lfilter([1.0], [1.0, -memory], noise)
    return error


def test_blocks_by_hand():
    time_s = np.arange(25.0)
    error = np.deg2rad(np.repeat([3.0, -4.0, 5.0], [10, 10, 5]))
    error[12] = np.nan
    middle, rmse = block_errors(time_s, error, 10.0)
    np.testing.assert_allclose(middle, [5.0, 15.0])
    np.testing.assert_allclose(rmse, [3.0, 4.0])
    np.testing.assert_allclose(block_errors(time_s, error, 10.0, "bias")[1], [3.0, -4.0])
    error[:6] = np.nan
    np.testing.assert_allclose(block_errors(time_s, error, 10.0)[0], [15.0])


def test_growth_is_found_and_measured():
    generator = np.random.default_rng(0)
    error = walk_error(generator) + np.deg2rad(2.0) * TIME_S / TIME_S[-1]
    shift = drift_test(TIME_S, error, quantity="bias")
    assert shift.grows
    np.testing.assert_allclose(shift.change_deg, 2.0 * 25 / 30, atol=0.1)
    np.testing.assert_allclose(shift.slope_deg_per_h, 4.0, atol=0.2)
    assert shift.low_deg < 2.0 * 25 / 30 < shift.high_deg
    assert drift_test(TIME_S, error).grows
    back = drift_test(TIME_S, error[::-1])
    assert back.p_value < 0.05
    assert not back.grows


def test_error_of_the_windows_is_the_plain_rmse():
    error = walk_error(np.random.default_rng(1))
    found = drift_test(TIME_S, error)
    first = np.rad2deg(np.sqrt(np.mean(error[TIME_S < 300] ** 2)))
    last = np.rad2deg(np.sqrt(np.mean(error[TIME_S >= 1500] ** 2)))
    np.testing.assert_allclose([found.first_deg, found.last_deg], [first, last], rtol=1e-3)


SHORT = TIME_S < 1200  # four windows


@pytest.mark.parametrize("memory_s", [0.0, 20.0])
def test_a_steady_error_of_a_short_walk_is_rarely_called_drift(memory_s):
    # a bias that wanders with a memory of two blocks: taken as independent, blocks would cry
    # drift in a third of such walks
    generator = np.random.default_rng(2)
    found = [
        drift_test(TIME_S[SHORT], walk_error(generator, memory_s)[SHORT], quantity="bias")
        for _ in range(150)
    ]
    assert np.mean([test.p_value < 0.05 for test in found]) < 0.11
    assert {test.n_windows for test in found} == {2}
    if memory_s:
        assert np.median([test.freedom for test in found]) < 40


def fractional_noise(generator, n_samples, exponent):
    """Fractional Gaussian noise of variance 1, exact (Davies and Harte 1987)."""
    lag = np.arange(n_samples + 1.0)
    power = 2.0 * exponent
    correlation = 0.5 * ((lag + 1) ** power - 2 * lag**power + np.abs(lag - 1) ** power)
    eigenvalues = np.fft.fft(np.concatenate([correlation, correlation[-2:0:-1]])).real
    noise = generator.normal(size=(2, len(eigenvalues)))
    spectrum = np.sqrt(np.maximum(eigenvalues, 0.0) / len(eigenvalues))
    return np.fft.fft(spectrum * (noise[0] + 1j * noise[1])).real[:n_samples]


def by_blocks(kind, generator, n_blocks):
    """One value a block, of a steady walk; degrees."""
    white = generator.normal(size=n_blocks)
    if kind == "white":
        return white
    if kind.startswith("memory"):
        memory = np.exp(-10.0 / float(kind.split()[1]))
        return signal.lfilter([np.sqrt(1 - memory**2)], [1.0, -memory], white)
    return fractional_noise(generator, n_blocks, float(kind.split()[1]))


BLOCKS_S = np.arange(0.0, 3600.0, 10.0)


def hour_test(value_deg):
    return drift_test(BLOCKS_S, np.deg2rad(value_deg), quantity="bias")


@pytest.mark.parametrize(
    ("kind", "most"),
    [
        ("white", 0.08),
        ("memory 20 s", 0.08),
        ("memory 60 s", 0.08),
        ("exponent 0.75", 0.10),
        ("exponent 0.9", 0.14),
    ],
)
def test_a_steady_hour_is_called_drift_as_often_as_said(kind, most):
    generator = np.random.default_rng(5)
    found = [hour_test(by_blocks(kind, generator, len(BLOCKS_S))) for _ in range(300)]
    assert 0.015 < np.mean([test.p_value < 0.05 for test in found]) < most
    assert {(test.n_windows, test.freedom) for test in found} == {(12, 10.0)}
    # the interval holds no change as often as the test finds none
    inside = np.mean([test.low_deg < 0.0 < test.high_deg for test in found])
    assert inside == np.mean([test.p_value > 0.05 for test in found])


def test_blocks_within_windows_do_not_see_what_is_slower():
    """Why windows are the yardstick: blocks alone cry drift in many a steady hour."""
    generator = np.random.default_rng(6)
    ends = (BLOCKS_S < 300) | (BLOCKS_S >= 3300)
    called = []
    for _ in range(200):
        value = np.deg2rad(by_blocks("exponent 0.9", generator, len(BLOCKS_S)))
        joined = np.arange(ends.sum()) * 10.0
        called.append(drift_test(joined, value[ends], quantity="bias").p_value < 0.05)
    assert np.mean(called) > 0.25


@pytest.mark.parametrize("kind", ["white", "exponent 0.75", "exponent 0.9"])
def test_growth_of_six_scatters_is_found_in_an_hour(kind):
    generator = np.random.default_rng(7)
    found = []
    for _ in range(100):
        steady = by_blocks(kind, generator, len(BLOCKS_S))
        scatter = steady.reshape(12, 30).mean(axis=1).std(ddof=1)
        found.append(hour_test(steady + 10.0 + 6.0 * scatter * BLOCKS_S / 3600.0))
    assert np.mean([test.grows for test in found]) > 0.8


def test_yardstick_of_windows_by_hand():
    """Six windows that alternate about a rising line."""
    time_s = np.arange(0.0, 1800.0, 10.0)
    means = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]) + 3.0 * np.arange(6.0)
    found = drift_test(time_s, np.deg2rad(np.repeat(means, 30)), quantity="bias")
    _, rest, *_ = np.polyfit(np.arange(6.0), means, 1, full=True)
    error = np.sqrt(2.0 * rest[0] / 4.0)
    np.testing.assert_allclose(found.change_deg, 13.0)
    np.testing.assert_allclose(found.p_value, 2.0 * stats.t.sf(13.0 / error, 4), rtol=1e-6)
    assert (found.n_windows, found.freedom) == (6, 4.0)


def test_a_window_that_is_missing_is_left_out():
    generator = np.random.default_rng(8)
    value = generator.normal(size=len(BLOCKS_S))
    value[31:62] = np.nan
    found = hour_test(value)
    assert (found.n_windows, found.freedom) == (11, 9.0)


def test_gaps_do_not_matter():
    error = walk_error(np.random.default_rng(3))
    error[(TIME_S > 100) & (TIME_S < 150)] = np.nan
    assert drift_test(TIME_S, error).p_value > 0.01


def test_no_error_at_all():
    found = drift_test(TIME_S, np.zeros_like(TIME_S))
    assert (found.p_value, found.change_deg, found.grows) == (1.0, 0.0, False)


def test_too_short_is_refused():
    with pytest.raises(MethodNotApplicableError, match="expected two windows of 300 s"):
        drift_test(TIME_S[:3000], np.zeros(3000))
    with pytest.raises(MethodNotApplicableError, match="recording has 0 s"):
        drift_test([], [])
    with pytest.raises(MethodNotApplicableError, match="expected three"):
        drift_test(TIME_S, np.full_like(TIME_S, np.nan))
