import sys

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from narx.evaluation.agreement import (
    agreement,
    correlation,
    limits_of_agreement,
    repeated_limits_of_agreement,
)

angles = arrays(
    np.float64, st.integers(3, 60), elements=st.floats(-4, 4) | st.just(np.nan), fill=st.nothing()
)


@given(angles, st.integers(0, 2**32 - 1))
@settings(max_examples=200, deadline=None)
def test_against_pandas_and_scipy(reference, seed):
    generator = np.random.default_rng(seed)
    estimate = reference + generator.normal(0.1, 0.3, len(reference))
    estimate[generator.random(len(reference)) < 0.1] = np.nan
    found = agreement(reference, estimate)
    pairs = pd.DataFrame({"reference": reference, "estimate": estimate}).dropna()
    error = np.rad2deg(pairs["reference"] - pairs["estimate"])
    assert found.n_samples == len(pairs)
    np.testing.assert_allclose(found.bias_deg, error.mean(), atol=1e-10)
    np.testing.assert_allclose(found.precision_deg, error.std(), atol=1e-10)
    rmse = np.sqrt((error**2).mean()) if len(error) else np.nan
    np.testing.assert_allclose(found.rmse_deg, rmse, atol=1e-10)
    if len(pairs) > 1 and np.ptp(pairs["reference"]) > 1e-6:
        r = stats.pearsonr(pairs["reference"], pairs["estimate"]).statistic
        np.testing.assert_allclose(found.r, r, atol=1e-9)
    np.testing.assert_allclose(
        [found.loa_lower_deg, found.loa_upper_deg],
        error.mean() + np.array([-1.96, 1.96]) * error.std(),
        atol=1e-9,
    )


def test_error_is_reference_minus_estimate():
    found = agreement(np.deg2rad([10.0, 20.0]), np.deg2rad([7.0, 15.0]))
    np.testing.assert_allclose(found.bias_deg, 4.0)
    np.testing.assert_allclose(found.precision_deg, np.sqrt(2.0))
    np.testing.assert_allclose(found.rmse_deg, np.sqrt(17.0))


@given(angles)
@settings(max_examples=50, deadline=None)
def test_rmse_combines_bias_and_precision(reference):
    found = agreement(reference, np.zeros_like(reference))
    if found.n_samples > 1:
        n = found.n_samples
        squared = found.bias_deg**2 + found.precision_deg**2 * (n - 1) / n
        np.testing.assert_allclose(found.rmse_deg**2, squared, atol=1e-8)


def test_nothing_to_compare():
    found = agreement([np.nan, 1.0], [1.0, np.nan])
    assert found.n_samples == 0
    numbers = [value for name, value in vars(found).items() if name != "n_samples"]
    assert len(numbers) == 6
    assert np.isnan(numbers).all()
    assert agreement([], []).n_samples == 0


def test_a_single_pair_has_no_spread():
    found = agreement([0.1, np.nan], [0.2, 0.3])
    assert found.n_samples == 1
    np.testing.assert_allclose(found.bias_deg, np.rad2deg(-0.1))
    np.testing.assert_allclose(found.rmse_deg, np.rad2deg(0.1))
    assert np.isnan([found.precision_deg, found.r, found.loa_lower_deg]).all()


@pytest.mark.parametrize("constant", [0.0, 0.1, -3e8])
def test_a_constant_has_no_correlation(constant):
    varying = np.linspace(0, 1, 101)
    assert np.isnan(correlation(np.full(101, constant), varying))
    assert np.isnan(agreement(varying, np.full(101, constant)).r)
    rounded = np.where(np.arange(101) % 3, constant, np.nextafter(constant, 9.0))
    assert constant == 0.0 or np.isnan(correlation(rounded, varying))


def test_rounding_takes_no_correlation_beyond_one():
    signals = np.random.default_rng(3).normal(size=(300, 7))
    assert max(correlation(signal, signal) for signal in signals) == 1.0
    assert min(correlation(signal, -3.0 * signal) for signal in signals) == -1.0


def test_the_rounding_of_a_still_joint_has_no_correlation():
    moving = np.sin(np.linspace(0, 9, 300))
    assert np.isnan(agreement(1e-16 * np.round(moving), moving).r)
    assert agreement(1e-6 * moving, -moving).r == pytest.approx(-1.0)


def test_correlation_does_not_mind_size():
    varying = np.sin(np.linspace(0, 9, 300))
    for scale in (1e-300, 1e-12, 1e150):
        np.testing.assert_allclose(correlation(varying, varying * scale), 1.0)


def test_an_estimate_that_ran_off_is_not_missing():
    found = agreement([0.0, 1.0, 2.0], [0.0, np.inf, 2.0])
    assert found.n_samples == 3
    assert found.rmse_deg == np.inf
    assert np.isnan(found.bias_deg)


def test_wrong_shapes():
    with pytest.raises(ValueError, match="expected twice"):
        agreement([1.0, 2.0], [1.0])


def test_limits_of_agreement_of_bland_and_altman_1986():
    # peak expiratory flow, their worked example: 17 people, mean -2.1, SD 38.8 l/min,
    # limits -79.7 and 75.5 with 2 SD; standard error of a limit sqrt(3 s^2 / n) = 16.3
    wright = [494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427]
    mini = [512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451]
    found = limits_of_agreement(np.subtract(wright, mini))
    assert round(found.bias, 1) == -2.1
    assert round(found.sd, 1) == 38.8
    np.testing.assert_allclose(found.upper, found.bias + 1.96 * found.sd)
    half_width = (found.upper_interval[1] - found.upper_interval[0]) / 2
    approximate = stats.t.ppf(0.975, 16) * np.sqrt(3 / 17) * found.sd
    np.testing.assert_allclose(half_width, approximate, rtol=0.1)
    np.testing.assert_allclose(
        found.bias_interval, stats.t.interval(0.95, 16, found.bias, found.sd / np.sqrt(17))
    )


def test_exact_intervals_have_nominal_coverage():
    generator = np.random.default_rng(3)
    inside = np.zeros(3)
    repeats = 1500
    for errors in generator.normal(2.0, 3.0, (repeats, 8)):
        found = limits_of_agreement(errors)
        truth = (2.0, 2.0 - 1.96 * 3.0, 2.0 + 1.96 * 3.0)
        intervals = (found.bias_interval, found.lower_interval, found.upper_interval)
        inside += [a <= x <= b for x, (a, b) in zip(truth, intervals, strict=True)]
    np.testing.assert_allclose(inside / repeats, 0.95, atol=0.02)


def test_limits_survive_many_samples():
    found = limits_of_agreement(np.random.default_rng(4).normal(size=200_000))
    assert found.upper_interval[0] < found.upper < found.upper_interval[1]
    assert found.upper_interval[1] - found.upper_interval[0] < 0.05


def test_repeated_limits_are_the_anova_ones_when_balanced():
    generator = np.random.default_rng(5)
    errors = generator.normal(0, 2, (6, 1)) + generator.normal(1, 3, (6, 40))
    found = repeated_limits_of_agreement(errors, np.repeat(np.arange(6), 40))
    mean_square_within = errors.var(axis=1, ddof=1).mean()
    mean_square_between = 40 * errors.mean(axis=1).var(ddof=1)
    variance = mean_square_within + (mean_square_between - mean_square_within) / 40
    np.testing.assert_allclose(found.sd, np.sqrt(variance))
    np.testing.assert_allclose(found.bias, errors.mean())
    assert (found.n_subjects, found.n_samples) == (6, 240)


def test_repeated_intervals_cover_where_pooled_ones_do_not():
    generator = np.random.default_rng(6)
    subjects = np.repeat(np.arange(5), 60)
    truth = 1.0 + 1.96 * np.hypot(2.0, 3.0)
    repeats, repeated, pooled = 600, 0, 0
    for _ in range(repeats):
        errors = 1.0 + generator.normal(0, 2, 5)[subjects] + generator.normal(0, 3, 300)
        low, high = repeated_limits_of_agreement(errors, subjects).upper_interval
        repeated += low <= truth <= high
        low, high = limits_of_agreement(errors).upper_interval
        pooled += low <= truth <= high
    assert 0.92 < repeated / repeats < 0.99
    assert pooled / repeats < 0.6


def test_one_error_a_subject_is_the_plain_case():
    errors = np.random.default_rng(7).normal(size=12)
    plain = limits_of_agreement(errors)
    repeated = repeated_limits_of_agreement(np.append(errors, np.nan), np.append(range(12), 3))
    np.testing.assert_allclose(
        [repeated.bias, repeated.sd, *repeated.bias_interval],
        [plain.bias, plain.sd, *plain.bias_interval],
    )
    np.testing.assert_allclose(repeated.upper_interval, plain.upper_interval, atol=0.1)


def test_an_interval_of_hardly_any_confidence_is_finite():
    """The lower bound of the variance would be negative: 1 - (1 / 0.465 - 1) < 0."""
    found = repeated_limits_of_agreement([0.0, 1.0], ["a", "b"], confidence=0.01)
    assert found.lower_interval[0] < found.lower < found.lower_interval[1]


def test_too_few_for_limits():
    with pytest.raises(ValueError, match="two errors"):
        limits_of_agreement([1.0, np.nan])
    with pytest.raises(ValueError, match="two subjects"):
        repeated_limits_of_agreement([1.0, 2.0, np.nan], ["a", "a", "b"])


@pytest.mark.parametrize(("n", "factor"), [(5, 4.203), (10, 2.911), (20, 2.396), (50, 2.065)])
def test_published_tolerance_factors(monkeypatch, n, factor):
    """One-sided factors for 95 % of a population with 95 % confidence (ISO 16269-6, table)."""
    # the package's function of the same name hides the module
    module = sys.modules["narx.evaluation.agreement"]
    monkeypatch.setattr(module, "LIMITS_SD", stats.norm.ppf(0.95))
    errors = np.random.default_rng(n).normal(3.0, 2.0, n)
    found = limits_of_agreement(errors, confidence=0.90)  # two tails of 5 %
    reach = factor * errors.std(ddof=1)
    assert found.upper_interval[1] == pytest.approx(errors.mean() + reach, abs=2e-3)
    assert found.lower_interval[0] == pytest.approx(errors.mean() - reach, abs=2e-3)
    assert found.lower_interval[0] < found.lower < found.lower_interval[1]


def test_unbalanced_subjects_by_hand():
    """Bland and Altman (2007): the within part counts 1 less the mean of 1 / count."""
    errors, subjects = [0.0, 2.0, 4.0, 6.0], ["a", "b", "b", "b"]
    found = repeated_limits_of_agreement(errors, subjects)
    # means 0 and 4: variance 8; within: 8 / 2 = 4; 1 - (1 + 1/3) / 2 = 1/3 of it
    assert found.bias == pytest.approx(2.0)
    assert found.sd == pytest.approx(np.sqrt(8.0 + 4.0 / 3.0))
    assert found.bias_interval[1] - found.bias == pytest.approx(
        stats.t.ppf(0.975, 1) * np.sqrt(8.0 / 2)
    )


def test_repeated_intervals_by_the_formula_of_zou():
    """Equations for variance components, written out for two subjects of two errors each."""
    errors, subjects = np.array([0.0, 1.0, 3.0, 6.0]), ["a", "a", "b", "b"]
    found = repeated_limits_of_agreement(errors, subjects)
    between, within, share = 8.0, (0.5 + 4.5) / 2, 0.5
    variance = between + share * within
    chi_low, chi_high = stats.chi2.ppf([0.025, 0.975], 1), stats.chi2.ppf([0.025, 0.975], 2)
    down = np.hypot(between * (1 / chi_low[1] - 1), share * within * (2 / chi_high[1] - 1))
    up = np.hypot(between * (1 / chi_low[0] - 1), share * within * (2 / chi_high[0] - 1))
    sd = np.sqrt(variance)
    sd_low, sd_high = np.sqrt(max(variance - down, 0.0)), np.sqrt(variance + up)
    mean_reach = stats.t.ppf(0.975, 1) * np.sqrt(between / 2)
    outer = np.hypot(mean_reach, 1.96 * (sd_high - sd))
    inner = np.hypot(mean_reach, 1.96 * (sd - sd_low))
    assert found.sd == pytest.approx(sd)
    assert found.upper_interval == pytest.approx((found.upper - inner, found.upper + outer))
    assert found.lower_interval == pytest.approx((found.lower - outer, found.lower + inner))
