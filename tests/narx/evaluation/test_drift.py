import numpy as np
import pytest
from scipy import signal, stats

from narx.errors import MethodNotApplicableError
from narx.evaluation.drift import DriftTest, block_errors, drift_test

TIME_S = np.arange(0, 1800, 0.1)


def walk_error(generator, memory_s=0.0):
    """Error of a steady walk in rad: a stride-periodic part, noise, and a slowly varying bias."""
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


@pytest.mark.parametrize(
    ("first", "last", "p", "grows"),
    [(-1.0, -2.0, 0.049, True), (-2.0, 1.0, 0.01, False), (1.0, 2.0, 0.051, False)],
)
def test_growth_is_of_the_size_and_significant_at_5_percent(first, last, p, grows):
    assert DriftTest(first, last, last - first, 0.0, 0.0, p, 6, 4.0, 0.0).grows == grows


def test_error_of_the_windows_is_the_plain_rmse():
    error = walk_error(np.random.default_rng(1))
    found = drift_test(TIME_S, error)
    first = np.rad2deg(np.sqrt(np.mean(error[TIME_S < 300] ** 2)))
    last = np.rad2deg(np.sqrt(np.mean(error[TIME_S >= 1500] ** 2)))
    np.testing.assert_allclose([found.first_deg, found.last_deg], [first, last], rtol=1e-3)


SHORT = TIME_S < 1200  # four windows


@pytest.mark.parametrize("memory_s", [0.0, 20.0])
def test_a_steady_error_of_a_short_walk_is_rarely_called_drift(memory_s):
    # the bias is correlated over two blocks: if blocks were treated as independent, a third of such
    # walks would be reported as drifting
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
    # the interval contains zero exactly when the test is not significant
    inside = np.mean([test.low_deg < 0.0 < test.high_deg for test in found])
    assert inside == np.mean([test.p_value > 0.05 for test in found])


def test_blocks_within_windows_miss_slower_fluctuations():
    """Why windows are used: with blocks alone, many a steady hour would be reported as drifting."""
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


def test_the_line_through_windows_keeps_the_place_of_a_missing_one():
    """By hand: residuals about a regression on the windows' true begins."""
    offsets = np.array([0.0, 0.3, np.nan, 0.9, 1.0, 1.7, 1.6, 2.3])
    time_s = np.arange(0.0, 300.0 * len(offsets), 1.0)
    error = np.radians(np.repeat(offsets, 300))
    found = drift_test(time_s, error, quantity="bias")
    there = np.isfinite(offsets)
    place, mean = np.arange(8.0)[there], offsets[there]
    (_, rest, *_) = np.polyfit(place, mean, 1, full=True)
    assert found.high_deg - found.change_deg == pytest.approx(
        stats.t.ppf(0.975, 5) * np.sqrt(2.0 * rest[0] / 5), rel=1e-6
    )


def test_gaps_do_not_matter():
    error = walk_error(np.random.default_rng(3))
    error[(TIME_S > 100) & (TIME_S < 150)] = np.nan
    assert drift_test(TIME_S, error).p_value > 0.01


def test_no_error_at_all():
    found = drift_test(TIME_S, np.zeros_like(TIME_S))
    assert (found.p_value, found.change_deg, found.grows) == (1.0, 0.0, False)


def test_a_step_without_scatter_is_certain():
    found = drift_test(*_steps(np.full(30, 1.0), np.full(30, 2.0)), quantity="bias")
    assert (found.p_value, found.low_deg, found.high_deg) == pytest.approx((0.0, 1.0, 1.0))
    # of no error at all Kendall's correction is left: 30 (1 - 1/30) / (1 + 1/30) values a window
    found = drift_test(*_steps(np.zeros(30), np.zeros(30)))
    assert found.freedom == pytest.approx(2.0 * (30.0 * 29.0 / 31.0 - 1.0))


def test_too_short_is_refused():
    with pytest.raises(MethodNotApplicableError, match="expected two windows of 300 s"):
        drift_test(TIME_S[:3000], np.zeros(3000))
    with pytest.raises(MethodNotApplicableError, match="recording has 0 s"):
        drift_test([], [])
    with pytest.raises(MethodNotApplicableError, match="expected three"):
        drift_test(TIME_S, np.full_like(TIME_S, np.nan))
    for missing in (TIME_S < 300, TIME_S >= 1500):
        with pytest.raises(MethodNotApplicableError, match="0 blocks of 10 s"):
            drift_test(TIME_S, np.where(missing, np.nan, 0.1))


def _steps(first, last, block_s=10.0):
    """A recording of two windows whose blocks have given errors, degrees."""
    time_s = np.arange(0.0, block_s * (len(first) + len(last)), 0.1)
    return time_s, np.radians(np.concatenate([first, last])[(time_s // block_s).astype(int)])


def test_two_windows_of_unrelated_blocks_are_welchs_test():
    """Blocks that alternate have no positive memory, so every block counts as one value."""
    sign = np.where(np.arange(30) % 2, 1.0, -1.0)
    size = np.linspace(0.5, 1.5, 30)
    first, last = 2.0 + 0.2 * sign * size, 2.1 + 0.6 * sign * size[::-1]
    found = drift_test(*_steps(first, last), quantity="bias")
    expected = stats.ttest_ind(last, first, equal_var=False)
    assert found.n_windows == 2
    assert found.freedom == pytest.approx(expected.df)
    assert found.p_value == pytest.approx(expected.pvalue)
    interval = expected.confidence_interval(0.95)
    assert [found.low_deg, found.high_deg] == pytest.approx([interval.low, interval.high])
    assert found.change_deg == pytest.approx(last.mean() - first.mean())
    assert (found.first_deg, found.last_deg) == pytest.approx((first.mean(), last.mean()))


def test_blocks_that_remember_count_less():
    """By hand: lag-one correlation r with Kendall's correction, n (1 - r) / (1 + r) values."""
    first = 2.0 + np.repeat([0.3, -0.3, 0.1, -0.1, 0.2, -0.2], 5)
    last = first + 0.5
    found = drift_test(*_steps(first, last), quantity="bias")
    centred = first - first.mean()
    r = (centred[:-1] @ centred[1:]) / (centred @ centred)
    r += (1 + 4 * r) / 30
    n = 30 * (1 - r) / (1 + r)
    error = np.sqrt(2.0 * first.var(ddof=1) / n)
    assert found.freedom == pytest.approx(2 * (n - 1))
    assert found.p_value == pytest.approx(2 * stats.t.sf(0.5 / error, 2 * (n - 1)))


def test_many_windows_scatter_about_a_line():
    """By hand: residual variance of a regression, twice it for a difference of two windows."""
    offsets = np.array([0.0, 0.3, -0.2, 0.1, 0.25, -0.15, 0.05, 0.2])
    errors = 1.0 + np.repeat(offsets, 30)
    time_s = np.arange(0.0, 300.0 * len(offsets), 0.1)
    found = drift_test(time_s, np.radians(errors[(time_s // 10.0).astype(int)]), quantity="bias")
    line = stats.linregress(np.arange(8.0), offsets)
    rest = offsets - line.intercept - line.slope * np.arange(8.0)
    error = np.sqrt(2.0 * np.sum(rest**2) / 6)
    assert (found.n_windows, found.freedom) == (8, 6.0)
    assert found.p_value == pytest.approx(2 * stats.t.sf(0.2 / error, 6), rel=1e-6)
    reach = stats.t.ppf(0.975, 6) * error
    assert [found.low_deg, found.high_deg] == pytest.approx([0.2 - reach, 0.2 + reach], rel=1e-6)


def test_the_slope_is_per_hour_and_blocks_have_their_middle():
    time_s = np.arange(0.0, 3600.0, 0.5)
    found = drift_test(time_s, np.radians(1.0 + 2.0 * time_s / 3600.0), quantity="bias")
    assert found.slope_deg_per_h == pytest.approx(2.0, rel=1e-6)
    # the median slope of all pairs does not follow a few wrong blocks at the end
    wrong = np.where(time_s < 3400.0, 1.0 + 2.0 * time_s / 3600.0, 30.0)
    found = drift_test(time_s, np.radians(wrong), quantity="bias")
    assert found.slope_deg_per_h == pytest.approx(2.0, rel=0.2)
    middle, value = block_errors(time_s, np.radians(time_s / 3600.0), 10.0, "bias")
    assert middle[[0, 1, -1]] == pytest.approx([5.0, 15.0, 3595.0])
    assert value == pytest.approx((middle - 0.25) / 3600.0)


def test_a_block_less_than_half_full_is_left_out():
    time_s = np.arange(0.0, 40.0, 0.1)
    error = np.full_like(time_s, 0.1)
    error[100:152] = np.nan  # 48 of 100 samples left
    error[200:248] = np.nan  # 52 left
    middle, _ = block_errors(time_s, error)
    assert middle.tolist() == [5.0, 25.0, 35.0]
    # whether a block is full does not depend on stamps that are missing elsewhere
    there = (time_s < 20.0) | (time_s >= 30.0)
    assert block_errors(time_s[there], error[there])[0].tolist() == [5.0, 35.0]


@pytest.mark.parametrize(("seconds", "windows"), [(591, 2), (1791, 6), (1789, 2)])
def test_a_block_less_than_the_windows_need_is_enough(seconds, windows):
    """From six windows on all of them are compared, otherwise the first with the last."""
    time_s = np.arange(0.0, seconds, 0.1)
    assert drift_test(time_s, 0.1 * np.sin(time_s)).n_windows == windows


def test_a_block_less_and_more_is_too_short():
    time_s = np.arange(0.0, 589.0, 0.1)
    with pytest.raises(MethodNotApplicableError, match="has 589 s, expected two windows"):
        drift_test(time_s, 0.1 * np.sin(time_s))


def test_two_blocks_in_a_window_are_too_few():
    time_s = np.arange(0.0, 500.0, 0.1)
    with pytest.raises(MethodNotApplicableError, match=r"2 blocks of 100 s .* expected three"):
        drift_test(time_s, 0.1 * np.sin(time_s), window_s=250.0, block_s=100.0)


def test_the_last_window_ends_with_the_recording():
    """1,000 s hold three windows of 300 s; the error begins with the last of them, at 700 s."""
    time_s = np.arange(0.0, 1000.0, 0.1)
    found = drift_test(time_s, np.radians(np.where(time_s < 700.0, 0.0, 1.0)), quantity="bias")
    assert (found.first_deg, found.last_deg) == pytest.approx((0.0, 1.0))
