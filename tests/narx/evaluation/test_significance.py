import numpy as np
import pytest
from scipy import stats

from narx.evaluation.significance import bootstrap_mean, paired_test


def test_same_seed_same_interval():
    values = [3.1, 2.2, 4.0, 2.9, 3.3]
    assert bootstrap_mean(values, seed=1) == bootstrap_mean(values, seed=1)
    assert bootstrap_mean(values, seed=1) == bootstrap_mean([*values, np.nan], seed=1)


def test_many_subjects_give_the_t_interval():
    values = np.random.default_rng(0).normal(5, 2, 400)
    found = bootstrap_mean(values)
    expected = stats.t.interval(0.95, 399, values.mean(), stats.sem(values))
    np.testing.assert_allclose([found.low, found.high], expected, atol=0.02)
    np.testing.assert_allclose(found.mean, values.mean())


def test_five_subjects_are_covered_better_than_by_plain_percentiles():
    generator = np.random.default_rng(1)
    repeats, expanded, plain = 300, 0, 0
    for _ in range(repeats):
        values = generator.normal(1, 1, 5)
        found = bootstrap_mean(values, n_resamples=999)
        expanded += found.low <= 1 <= found.high
        interval = stats.bootstrap(
            (values,), np.mean, n_resamples=999, method="percentile", rng=generator
        ).confidence_interval
        plain += interval.low <= 1 <= interval.high
    assert expanded / repeats > 0.86
    assert expanded > plain + 0.03 * repeats


def test_few_subjects():
    assert bootstrap_mean([]).n == 0
    assert np.isnan(bootstrap_mean([]).mean)
    for n in (1, 2, 3):
        few = bootstrap_mean(np.arange(n) + 2.0)
        assert (few.n, few.mean) == (n, 2.0 + (n - 1) / 2.0)
        assert np.isnan([few.low, few.high]).all()
    four = bootstrap_mean([2.0, 3.0, 4.0, 5.0])
    assert 2.0 <= four.low < 3.0 < 4.0 < four.high <= 5.0
    same = bootstrap_mean([2.0, 2.0, 2.0, 2.0])
    assert (same.low, same.high) == (2.0, 2.0)


def test_permutation_p_by_hand():
    # of the eight sign patterns of (1, 2, 4) only all plus and all minus are as extreme
    found = paired_test([2.0, 4.0, 9.0], [1.0, 2.0, 5.0])
    np.testing.assert_allclose(found.difference, 7 / 3)
    np.testing.assert_allclose([found.p_permutation, found.smallest_p], 0.25)
    np.testing.assert_allclose(found.p_wilcoxon, 0.25)
    two = paired_test([2.0, 4.0], [1.0, 2.0])
    np.testing.assert_allclose([two.p_permutation, two.p_wilcoxon, two.smallest_p], 0.5)
    # of (3, -1, 2): |sum| >= 4 in +++, ++-... (3+1+2, 3-1+2) and their mirror images
    np.testing.assert_allclose(paired_test([3.0, 0.0, 2.0], [0.0, 1.0, 0.0]).p_permutation, 0.5)


@pytest.mark.parametrize("n", [6, 40])
def test_against_scipy(n):
    generator = np.random.default_rng(n)
    first = generator.normal(0.5, 1, n)
    second = generator.normal(0, 1, n)
    found = paired_test(first, second, seed=3)
    np.testing.assert_allclose(found.p_wilcoxon, stats.wilcoxon(first, second).pvalue)
    # exchanging is asymptotically the paired t test
    t_test = stats.ttest_rel(first, second).pvalue
    np.testing.assert_allclose(found.p_permutation, t_test, atol=0.05)
    assert found == paired_test(first, second, seed=3)
    other = paired_test(second, first, seed=3)
    np.testing.assert_allclose(other.difference, -found.difference)


def test_p_is_uniform_where_methods_do_not_differ():
    generator = np.random.default_rng(4)
    p = [paired_test(*generator.normal(size=(2, 8)), n_resamples=99) for _ in range(200)]
    share = np.mean([test.p_permutation <= 0.1 for test in p])
    assert 0.05 < share < 0.16


def test_nothing_to_tell():
    same = paired_test([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])
    assert (same.p_permutation, same.p_wilcoxon, same.difference) == (1.0, 1.0, 0.0)
    one = paired_test([1.0, np.nan], [2.0, 2.0])
    assert one.n == 1
    assert np.isnan([one.p_permutation, one.p_wilcoxon, one.smallest_p]).all()
    assert np.isnan(paired_test([np.inf, 1.0], [1.0, 0.0]).p_permutation)
    with pytest.raises(ValueError, match="expected twice"):
        paired_test([1.0], [1.0, 2.0])


def test_the_interval_is_the_expanded_percentile_of_all_resamples():
    """Hesterberg (2015): the level whose normal quantile is t times the root of n / (n - 1)."""
    values = np.array([0.0, 1.0, 3.2, 4.1, 7.0])
    n = len(values)
    means = values[np.indices((n,) * n).reshape(n, -1)].mean(axis=0)  # all 5^5 resamples
    tail = stats.norm.cdf(-stats.t.ppf(0.975, n - 1) * np.sqrt(n / (n - 1)))
    assert tail == pytest.approx(0.00096, abs=2e-5)
    expected = np.quantile(means, [tail, 1 - tail])
    # without the expansion the tail is 0.0028, three times as much
    assert (expected - np.quantile(means, [0.0028, 0.9972]))[0] < -0.15
    found = bootstrap_mean(values, n_resamples=200_000)
    np.testing.assert_allclose([found.low, found.high], expected, atol=0.07)
    # half of all intervals: as much is left out on either side, 20.4 % of the means
    tail = stats.norm.cdf(-stats.t.ppf(0.75, n - 1) * np.sqrt(n / (n - 1)))
    assert tail == pytest.approx(0.204, abs=5e-4)
    found = bootstrap_mean(values, confidence=0.5, n_resamples=200_000)
    np.testing.assert_allclose(
        [found.low, found.high], np.quantile(means, [tail, 1 - tail]), atol=0.05
    )


def test_values_without_a_finite_spread_are_bounded_by_their_ends():
    found = bootstrap_mean([1.0, 2.0, 3.0, np.inf])
    assert (found.mean, found.low, found.high) == (np.inf, 1.0, np.inf)
    # the mean of six times 0.1 is rounded; the ends are not
    found = bootstrap_mean([0.1] * 6)
    assert (found.low, found.high) == (0.1, 0.1)
