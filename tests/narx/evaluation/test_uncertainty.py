import numpy as np
import pytest
from scipy import stats

from narx.evaluation.uncertainty import calibration, coverage_curve


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_normal_errors_against_the_normal_distribution(factor):
    generator = np.random.default_rng(0)
    spread = generator.uniform(0.01, 0.1, 100_000)
    found = calibration(generator.normal(0, spread), factor * spread)
    expected = [2 * stats.norm.cdf(factor * stats.norm.ppf(0.5 + p / 2)) - 1 for p in (0.68, 0.95)]
    np.testing.assert_allclose([found.coverage_68, found.coverage_95], expected, atol=0.005)
    np.testing.assert_allclose(found.scale, 1 / factor, rtol=0.01)
    rms = np.rad2deg(factor * np.sqrt(np.mean(spread**2)))
    np.testing.assert_allclose(found.sharpness_deg, rms)


def test_by_hand():
    error = [0.5, -0.9, 1.5, -2.5, np.nan, 0.0]
    found = calibration(error, [1.0, 1.0, 1.0, 1.0, 1.0, np.nan])
    assert (found.n_samples, found.coverage_68, found.coverage_95) == (4, 0.5, 0.75)


def test_the_narrow_band_holds_68_percent_not_one_standard_deviation():
    found = calibration([0.99, 0.997], [1.0, 1.0])
    assert (found.coverage_68, found.coverage_95) == (0.5, 1.0)


def test_scaling_by_the_scale_calibrates_the_scale():
    generator = np.random.default_rng(1)
    error, std = generator.normal(0, 0.3, 500), generator.uniform(0.1, 0.2, 500)
    found = calibration(error, calibration(error, std).scale * std)
    np.testing.assert_allclose(found.scale, 1.0)


def test_curve_grows_from_level_to_level():
    generator = np.random.default_rng(2)
    levels = np.linspace(0.05, 0.99, 30)
    curve = coverage_curve(generator.normal(size=50_000), np.ones(50_000), levels)
    assert (np.diff(curve) >= 0).all()
    np.testing.assert_allclose(curve, levels, atol=0.01)


def test_certainty():
    found = calibration([0.0, 1.0], [0.0, 0.0])
    assert (found.coverage_68, found.coverage_95, found.scale) == (0.5, 0.5, np.inf)


def test_nothing_and_nonsense():
    assert calibration([np.nan], [1.0]).n_samples == 0
    assert np.isnan(calibration([], []).coverage_68)
    with pytest.raises(ValueError, match="negative"):
        calibration([1.0], [-1.0])
    with pytest.raises(ValueError, match="shape"):
        calibration([1.0], [1.0, 2.0])


def test_an_error_on_the_bound_is_inside():
    """A central interval is closed: an error exactly at its bound is covered."""
    bound = stats.norm.ppf(0.5 + 0.95 / 2.0)
    assert coverage_curve([bound, -bound], [1.0, 1.0], [0.95]) == 1.0
    assert coverage_curve([np.nextafter(bound, 9.0)], [1.0], [0.95]) == 0.0


def test_root_mean_squares_by_hand():
    found = calibration([3.0, 4.0], [1.0, 2.0])
    assert found.scale == pytest.approx(np.sqrt((9.0 + 4.0) / 2))
    assert found.sharpness_deg == pytest.approx(np.degrees(np.sqrt(2.5)))
