"""Strides of a comparison: segmentation and measures."""

from dataclasses import replace

import numpy as np
import pytest

from narx.evaluation.comparison import Evaluated
from narx.evaluation.strides import cut_strides, mean_waveforms, stride_table

RATE_HZ = 100.0


def walk(subject="S1", duration_s=20.0, missing=()):
    """One stride a second: amplitude 20 degrees; the estimate has 15 about a mean of 3 degrees."""
    time = np.arange(0.0, duration_s, 1.0 / RATE_HZ)
    swing = np.cos(2.0 * np.pi * time)
    reference = np.radians(np.stack([20.0 * swing, np.full_like(time, np.nan), 5.0 * swing], 1))
    estimate = np.radians(np.stack([3.0 + 15.0 * swing, swing, np.full_like(time, np.nan)], 1))
    reference[list(missing)] = np.nan
    return Evaluated(
        "d", subject, "normal", "1", "knee_right", RATE_HZ, time, reference,
        {"narx": estimate + 2.0 * np.pi}, time >= 2.0,
    )  # fmt: skip


def test_errors_of_range_and_peaks():
    strides = cut_strides(walk(), np.arange(0.0, 20.0))
    assert strides.reference_deg.shape == (17, 101, 3)  # of 19, two are not scored
    table = stride_table([strides])
    assert set(table["axis"]) == {"sagittal"}  # the only one with reference and estimate
    assert stride_table([strides, strides]).index.tolist() == list(range(2 * len(table)))
    row = table.iloc[0]
    assert row["range_reference"] == pytest.approx(40.0, abs=1e-3)
    assert row["range_estimate"] == pytest.approx(30.0, abs=1e-3)
    assert row["maximum_reference"] - row["maximum_estimate"] == pytest.approx(2.0, abs=1e-3)
    assert row["minimum_reference"] - row["minimum_estimate"] == pytest.approx(-8.0, abs=1e-3)
    # error = -3 + 5 cos over a whole stride, both of whose ends are among the points
    points = -3.0 + 5.0 * np.cos(np.linspace(0.0, 2.0 * np.pi, 101))
    assert row["rmse"] == pytest.approx(np.sqrt(np.mean(points**2)), abs=1e-3)


def test_a_stride_with_a_missing_sample_is_left_out():
    assert len(cut_strides(walk(missing=[1050]), np.arange(0.0, 20.0)).reference_deg) == 16


def test_a_stride_of_an_estimate_with_a_missing_sample_keeps_the_others_numbers():
    walked = walk()
    walked.estimates_rad["narx"][650, 0] = np.nan
    found = stride_table([cut_strides(walked, np.arange(0.0, 20.0))])
    # the first stride that is scored begins at 2 s
    assert found["stride"].tolist() == [k for k in range(17) if k != 4]


def test_waveforms_are_averaged_by_subject():
    walks = (("A", 20.0), ("A", 8.0), ("B", 9.0))
    sets = [cut_strides(walk(s, t), np.arange(0.0, t)) for s, t in walks]
    reference, estimate = mean_waveforms(sets, "narx", 0)
    assert reference.shape == estimate.shape == (2, 101)
    np.testing.assert_allclose(reference[0], 20 * np.cos(np.linspace(0, 2 * np.pi, 101)), atol=1e-3)
    assert mean_waveforms(sets, "narx", 2)[0].shape == (0, 101)
    assert mean_waveforms(sets, "unknown", 0)[0].shape == (0, 101)


def test_every_stride_of_a_subject_counts_alike():
    """Two trials of 17 strides and 5: not the mean of the trials' means."""
    long, short = (cut_strides(walk("A", t), np.arange(0.0, t)) for t in (20.0, 8.0))
    short = replace(short, reference_deg=2.0 * short.reference_deg)
    n_long, n_short = len(long.reference_deg), len(short.reference_deg)
    assert n_long != n_short
    reference, _ = mean_waveforms([long, short], "narx", 0)
    expected = 20.0 * (n_long + 2.0 * n_short) / (n_long + n_short)
    np.testing.assert_allclose(reference[0, 0], expected, atol=1e-3)
