import numpy as np
import pytest
from scipy import signal

from narx.drift import block_errors, drift_test
from narx.errors import MethodNotApplicableError

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


@pytest.mark.parametrize("memory_s", [0.0, 20.0])
def test_a_steady_error_is_rarely_called_drift(memory_s):
    # a bias that wanders with a memory of two blocks: taken as independent, blocks would cry
    # drift in a third of such walks
    generator = np.random.default_rng(2)
    found = [
        drift_test(TIME_S, walk_error(generator, memory_s), quantity="bias") for _ in range(150)
    ]
    assert np.mean([test.p_value < 0.05 for test in found]) < 0.11
    if memory_s:
        assert np.median([test.n_effective for test in found]) < 20


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
