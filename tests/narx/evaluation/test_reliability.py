"""Intraclass correlation against the analysis of variance written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from narx.evaluation.reliability import reliability


def by_hand(reference, estimate):
    """ICC(2,1) and ICC(3,1) of Shrout and Fleiss (1979), two judges."""
    x = np.stack([reference, estimate], axis=1)
    n, k = x.shape
    between = k * ((x.mean(axis=1) - x.mean()) ** 2).sum() / (n - 1)
    judges = n * ((x.mean(axis=0) - x.mean()) ** 2).sum() / (k - 1)
    residual = ((x - x.mean(axis=1, keepdims=True) - x.mean(axis=0) + x.mean()) ** 2).sum()
    residual /= (n - 1) * (k - 1)
    return (
        (between - residual) / (between + (k - 1) * residual + k * (judges - residual) / n),
        (between - residual) / (between + (k - 1) * residual),
    )


@given(st.integers(0, 1000), st.integers(5, 40), st.floats(-3.0, 3.0))
@settings(max_examples=30, deadline=None)
def test_both_coefficients(seed, n, offset):
    rng = np.random.default_rng(seed)
    reference = rng.normal(40.0, 5.0, n)
    estimate = reference + offset + rng.normal(0.0, 2.0, n)
    found = reliability(reference, estimate)
    assert (found.icc_2_1, found.icc_3_1) == pytest.approx(by_hand(reference, estimate), abs=1e-9)
    assert found.icc_2_1_interval[0] - 0.01 <= found.icc_2_1 <= found.icc_2_1_interval[1] + 0.01


def test_a_constant_offset_is_consistent_but_does_not_agree():
    reference = np.linspace(30.0, 60.0, 10)
    offset = reliability(reference, reference + 10.0 + 1e-6 * np.arange(10) ** 2)
    assert offset.icc_3_1 == pytest.approx(1.0, abs=1e-6)
    assert offset.icc_2_1 < 0.75
    assert offset.sem == pytest.approx(10.0 / np.sqrt(2.0), rel=1e-4)
    assert offset.mdc == pytest.approx(1.96 * 10.0, rel=1e-4)


def test_the_interval_of_consistency_is_shrout_and_fleiss():
    """From F = between / residual, both with n - 1 degrees of freedom; two decimals are kept."""
    rng = np.random.default_rng(2)
    reference = rng.normal(40.0, 5.0, 15)
    estimate = reference + 6.0 + rng.normal(0.0, 3.0, 15)
    found = reliability(reference, estimate)
    ratio = (1 + found.icc_3_1) / (1 - found.icc_3_1)
    bounds = ratio / stats.f.ppf([0.975, 0.025], 14, 14)
    expected = (bounds - 1) / (bounds + 1)
    assert found.icc_3_1_interval == pytest.approx(expected, abs=0.006)
    assert found.icc_2_1_interval[0] < expected[0] - 0.1


def test_the_standard_error_is_the_noise_of_one_instrument():
    rng = np.random.default_rng(0)
    true = rng.normal(0.0, 20.0, 20_000)
    found = reliability(true + rng.normal(0, 3.0, true.size), true + rng.normal(0, 3.0, true.size))
    assert found.sem == pytest.approx(3.0, rel=0.03)


def test_a_target_that_one_instrument_lacks_is_left_out():
    rng = np.random.default_rng(1)
    reference = rng.normal(40.0, 5.0, 12)
    estimate = reference + rng.normal(0.0, 2.0, 12)
    whole = reliability(reference[:10], estimate[:10])
    reference[10] = estimate[11] = np.nan
    assert reliability(reference, estimate) == whole


@pytest.mark.parametrize(
    ("reference", "estimate"),
    [([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), ([1.0] * 6, [1.0] * 6), ([np.nan] * 9, [1.0] * 9)],
)
def test_too_few_targets_give_no_result(reference, estimate):
    assert reliability(reference, estimate) is None
