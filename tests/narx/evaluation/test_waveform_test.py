"""The test over the gait cycle detects real differences and controls false positives."""

import numpy as np
import pytest

from narx.evaluation.waveform_test import waveform_test

PERCENT = np.linspace(0.0, 100.0, 101)


def smooth_noise(rng, n):
    """Random waveforms of a few low harmonics."""
    order = np.arange(1, 6)
    phases = rng.uniform(0, 2 * np.pi, (n, 5, 1))
    sizes = rng.normal(0, 1.0, (n, 5, 1)) / order[:, None]
    return (sizes * np.sin(2 * np.pi * order[:, None] * PERCENT / 100 + phases)).sum(axis=1)


def test_a_difference_in_swing_is_found_where_it_is():
    rng = np.random.default_rng(1)
    reference = 30.0 + smooth_noise(rng, 12)
    bump = 6.0 * np.exp(-(((PERCENT - 70.0) / 6.0) ** 2))
    found = waveform_test(reference, reference + bump + 0.5 * smooth_noise(rng, 12))
    assert found.n_subjects == 12
    (cluster,) = found.clusters
    assert 55.0 < cluster[0] < 68.0 < 72.0 < cluster[1] < 85.0
    assert cluster[2] < 0.001
    assert found.share_percent == pytest.approx(cluster[1] - cluster[0])
    assert found.largest_difference_deg == pytest.approx(6.0, abs=1.0)


@pytest.mark.parametrize("size_deg", [1.0, 1e-5])
def test_a_difference_over_the_whole_cycle_is_100_percent(size_deg):
    reference = 30.0 + smooth_noise(np.random.default_rng(6), 12)
    own = np.linspace(0.9, 1.1, 12)[:, None] * (1.5 + np.sin(PERCENT / 100.0))
    found = waveform_test(reference, reference + size_deg * own)
    assert found.clusters[0][:2] == pytest.approx((0.0, 100.0))
    assert found.share_percent == pytest.approx(100.0)


def test_noise_alone_is_rarely_a_difference():
    rng = np.random.default_rng(2)
    found = [
        waveform_test(*(smooth_noise(rng, 10), smooth_noise(rng, 10))).clusters for _ in range(60)
    ]
    # 5 % of 60 are 3; more than 9 come by chance once in a thousand times
    assert sum(map(bool, found)) <= 9


def test_the_threshold_lies_between_one_point_and_all_points():
    from scipy import stats

    rng = np.random.default_rng(3)
    found = waveform_test(smooth_noise(rng, 10), smooth_noise(rng, 10))
    pointwise = stats.t.ppf(1 - 0.025, 9)
    bonferroni = stats.t.ppf(1 - 0.025 / 101, 9)
    assert pointwise < found.threshold < bonferroni


def test_three_subjects_are_the_fewest():
    rng = np.random.default_rng(5)
    reference, estimate = smooth_noise(rng, 3), smooth_noise(rng, 3)
    assert waveform_test(reference, estimate).n_subjects == 3
    assert waveform_test(reference[:2], estimate[:2]) is None


def test_not_defined():
    rng = np.random.default_rng(4)
    many = smooth_noise(rng, 8)
    assert waveform_test(many, many + 1.0) is None
    assert waveform_test(np.empty((0, 101)), np.empty((0, 101))) is None


def test_the_largest_difference_is_that_of_the_means():
    """Subjects that differ in opposite directions differ by 1 degree on average."""
    estimate = 1.0 + np.array([[-3.0], [0.0], [3.0]]) * (1.5 + np.sin(PERCENT / 100.0))
    found = waveform_test(np.zeros((3, 101)), estimate)
    assert found.largest_difference_deg == pytest.approx(1.0)
