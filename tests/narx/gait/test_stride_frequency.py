import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.gait.stride_frequency import (
    StrideFrequencyTracker,
    _autocorrelation,
    stride_frequency_hz,
)


def thigh_rate(stride_hz, rate_hz, duration_s, seed=0, noise=0.05):
    """A swing lobe and stance, with harmonics as of a thigh, rad/s."""
    t = np.arange(int(duration_s * rate_hz)) / rate_hz
    p = 2 * np.pi * stride_hz * t
    clean = 1.5 * np.cos(p) + 0.7 * np.cos(2 * p + 1.2) + 0.25 * np.cos(3 * p + 2.0)
    return clean + np.random.default_rng(seed).normal(0, noise, len(t))


@settings(max_examples=25, deadline=None)
@given(
    stride_hz=st.floats(0.5, 1.5),
    rate_hz=st.sampled_from([50.0, 100.0, 500.0]),
    duration_s=st.floats(12.0, 60.0),
)
def test_the_stride_frequency_is_found(stride_hz, rate_hz, duration_s):
    rate = thigh_rate(stride_hz, rate_hz, duration_s)
    assert stride_frequency_hz(rate, rate_hz) == pytest.approx(stride_hz, rel=0.01)


def test_standing_before_and_after_does_not_matter():
    walk = thigh_rate(0.9, 100.0, 12.0)
    rest = np.random.default_rng(1).normal(0, 0.01, 500)
    rate = np.concatenate([rest, walk, rest, rest])
    assert stride_frequency_hz(rate, 100.0) == pytest.approx(0.9, rel=0.02)


def test_gaps_do_not_shift_it():
    rate = thigh_rate(0.9, 100.0, 30.0)
    rate[400:470] = np.nan
    rate[1500:1733] = np.nan
    assert stride_frequency_hz(rate, 100.0) == pytest.approx(0.9, rel=0.01)


@pytest.mark.parametrize(
    "rate",
    [
        np.zeros(2000),
        np.full(2000, 0.3),
        np.full(2000, np.nan),
        np.random.default_rng(2).normal(0, 1.0, 2000),
        0.05 * thigh_rate(0.9, 100.0, 20.0),
        np.zeros(0),
        np.ones(3),
    ],
    ids=["nothing", "bias", "missing", "noise", "too small", "empty", "short"],
)
def test_no_walking_is_nan(rate):
    assert np.isnan(stride_frequency_hz(rate, 100.0))


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 500.0])
@pytest.mark.parametrize("stride_hz", [0.6, 0.9, 1.3])
def test_the_tracker_finds_it_within_a_few_strides(stride_hz, rate_hz):
    rate = thigh_rate(stride_hz, rate_hz, 30.0)
    followed = StrideFrequencyTracker(start_frequency_hz=1.0).follow(rate, rate_hz)
    assert followed[0] == pytest.approx(1.0)
    late = slice(int(6 * rate_hz / stride_hz), None)
    np.testing.assert_allclose(followed[late], stride_hz, rtol=0.03)


def test_the_tracker_follows_a_change_of_speed():
    t = np.arange(6000) / 100.0
    stride_hz = np.where(t < 30, 0.8, 1.1)
    p = 2 * np.pi * np.cumsum(stride_hz) / 100.0
    rate = 1.5 * np.cos(p) + 0.7 * np.cos(2 * p + 1.2)
    followed = StrideFrequencyTracker().follow(rate, 100.0)
    assert followed[2900] == pytest.approx(0.8, rel=0.02)
    assert followed[-1] == pytest.approx(1.1, rel=0.02)


def test_the_tracker_is_causal_and_the_same_sample_by_sample():
    rate = thigh_rate(0.9, 100.0, 15.0)
    tracker = StrideFrequencyTracker()
    at_once = tracker.follow(rate, 100.0)
    step = tracker.start(100.0)
    np.testing.assert_array_equal([step(value) for value in rate], at_once)
    np.testing.assert_array_equal(tracker.follow(rate[:800], 100.0), at_once[:800])


def test_the_tracker_keeps_its_answer_while_standing():
    rate = np.concatenate([thigh_rate(0.9, 100.0, 20.0, noise=0.0), np.zeros(2000)])
    followed = StrideFrequencyTracker().follow(rate, 100.0)
    assert followed[-1] == pytest.approx(followed[2000], rel=0.05)


def test_the_first_peak_within_15_percent_of_the_highest_is_the_stride():
    """Every second stride a little larger: two strides agree better than one with the next."""
    time_s = np.arange(6000) / 100.0
    for other, expected in ((0.2, 1.2), (0.5, 0.6)):
        # the correlation after one stride is (1 - other^2) / (1 + other^2): 0.92 and 0.6
        rate = np.cos(2 * np.pi * 1.2 * time_s) + other * np.cos(2 * np.pi * 0.6 * time_s)
        assert stride_frequency_hz(rate, 100.0) == pytest.approx(expected, rel=0.005)


def test_it_lies_between_lags():
    """At 20 samples per second a lag is 5 % of a stride; the parabola finds a thousandth."""
    time_s = np.arange(4000) / 20.0
    for stride_hz in (0.87, 0.93, 1.04):
        rate = np.cos(2 * np.pi * stride_hz * time_s)
        assert stride_frequency_hz(rate, 20.0) == pytest.approx(stride_hz, rel=2e-3)


def test_strides_beyond_the_range_are_none():
    time_s = np.arange(6000) / 100.0
    assert np.isnan(stride_frequency_hz(np.cos(2 * np.pi * 0.3 * time_s), 100.0))


@pytest.mark.parametrize("rate_hz", [20.0, 50.0])
def test_the_tracker_places_crossings_between_samples(rate_hz):
    """A stride of 1.07 s at 20 Hz is 21.4 samples: whole samples would be 2 % off."""
    stride_hz = 0.935
    rate = 2.0 * np.cos(2 * np.pi * stride_hz * np.arange(round(60 * rate_hz)) / rate_hz)
    followed = StrideFrequencyTracker().follow(rate, rate_hz)
    late = followed[round(20 * rate_hz) :]
    np.testing.assert_allclose(late, stride_hz, rtol=4e-3)


def test_the_first_stride_counts_wholly_and_each_later_one_by_its_weight():
    """Strides of 1 s, then of 1.25 s: an exponential average of stride times, by hand."""
    durations_s = np.repeat([1.0, 1.25], 12)
    ends_s = np.cumsum(durations_s)
    time_s = np.arange(0.0, ends_s[-1], 0.002)
    phase = np.interp(time_s, np.r_[0.0, ends_s], np.arange(len(ends_s) + 1.0))
    followed = StrideFrequencyTracker(start_frequency_hz=0.5).follow(
        2.0 * np.cos(2 * np.pi * phase), 500.0
    )
    values = 1.0 / followed[np.flatnonzero(np.diff(followed)) + 1]
    assert values[0] == pytest.approx(1.0, abs=0.02)  # the initial 2 s period is replaced at once
    steps = np.flatnonzero(np.abs(np.diff(values)) > 0.01)
    # 0.3 of the difference, then 0.3 of what remains
    changed = (values[steps[0] :][:6] - 1.0) / 0.25
    later = changed[2:5] / changed[1:4]
    left = (1 - changed[2:5]) / (1 - changed[1:4])
    assert (later > 1).all()
    np.testing.assert_allclose(left, 0.7, atol=0.03)


def test_half_of_the_samples_missing_at_random_do_not_matter():
    """The correlation is averaged over pairs of valid samples; a quarter of the pairs is left."""
    rate = thigh_rate(0.9, 100.0, 40.0)
    rate[np.random.default_rng(3).random(len(rate)) < 0.5] = np.nan
    assert stride_frequency_hz(rate, 100.0) == pytest.approx(0.9, rel=0.06)


def test_a_frequency_above_the_range_is_that_of_two_strides():
    rate = np.cos(2 * np.pi * 2.5 * np.arange(4000) / 100.0)
    assert stride_frequency_hz(rate, 100.0) == pytest.approx(1.25, rel=0.01)


def test_one_bump_at_either_end_is_no_stride():
    """Too few pairs of samples cover the lag between the bumps."""
    rate = np.zeros(260)
    bump = 3.0 * np.sin(np.pi * np.arange(20) / 20)
    rate[:20], rate[-20:] = bump, bump
    assert np.isnan(stride_frequency_hz(rate, 100.0))


@pytest.mark.parametrize("stride_hz", [3.0, 0.25])
def test_the_tracker_leaves_out_what_is_no_stride(stride_hz):
    rate = 2.0 * np.cos(2 * np.pi * stride_hz * np.arange(6000) / 100.0)
    np.testing.assert_allclose(StrideFrequencyTracker().follow(rate, 100.0), 0.9)


def test_the_low_pass_of_the_tracker_lets_strides_pass():
    """The 3 Hz filter passes 0.96 of a 0.9 Hz stride: 0.2 rad/s RMS, above the threshold."""
    rate = 0.3 * np.cos(2 * np.pi * 0.9 * np.arange(6000) / 100.0)
    followed = StrideFrequencyTracker(start_frequency_hz=1.3).follow(rate, 100.0)
    assert followed[-1] == pytest.approx(0.9, rel=0.01)


@pytest.mark.parametrize("stride_hz", [0.43, 1.72])
def test_very_slow_and_very_fast_strides_are_strides(stride_hz):
    rate = thigh_rate(stride_hz, 100.0, 60.0)
    assert stride_frequency_hz(rate, 100.0) == pytest.approx(stride_hz, rel=0.01)
    followed = StrideFrequencyTracker().follow(rate, 100.0)
    assert followed[-1] == pytest.approx(stride_hz, rel=0.03)


@pytest.mark.parametrize(("share", "is_walking"), [(0.3, False), (0.5, True)])
def test_two_fifths_of_the_power_has_to_repeat(share, is_walking):
    """With white noise the correlation after a stride is the share of the periodic power."""
    noise = np.random.default_rng(4).normal(0.0, np.sqrt(0.5 * (1 / share - 1)), 12000)
    rate = np.cos(2 * np.pi * 0.9 * np.arange(12000) / 100.0) + noise
    assert np.isfinite(stride_frequency_hz(rate, 100.0)) == is_walking


def test_the_mean_does_not_count_as_repeating():
    rate = 5.0 + np.random.default_rng(5).normal(0.0, 0.5, 6000)
    assert np.isnan(stride_frequency_hz(rate, 100.0))


def test_the_running_mean_square_has_a_time_constant_of_3_s():
    """Strides a fifth as large are seen when half the running RMS has fallen below their peak.

    The mean square m of the large ones falls to that of the small ones as exp(-t / 3 s).
    """
    time_s = np.arange(6000) / 100.0
    phase = np.cumsum(np.where(time_s < 30.0, 0.9, 1.2)) / 100.0
    rate = np.where(time_s < 30.0, 3.0, 0.6) * np.cos(2 * np.pi * phase)
    followed = StrideFrequencyTracker(low_pass_hz=30.0).follow(rate, 100.0)
    large, small = 3.0**2 / 2, 0.6**2 / 2
    seen_s = 3.0 * np.log((large - small) / (4 * 0.6**2 - small))
    changed_s = time_s[np.flatnonzero(followed > followed[3000] + 0.01)[0]] - 30.0
    # and a stride is measured from one crossing to the next
    assert seen_s + 1 / 1.2 - 0.1 < changed_s < seen_s + 2 / 1.2 + 0.1


def test_the_end_of_a_signal_is_not_multiplied_by_its_beginning():
    values = np.random.default_rng(6).normal(size=64)
    expected = [values[lag:] @ values[: 64 - lag] for lag in range(40)]
    np.testing.assert_allclose(_autocorrelation(values, 40), expected, atol=1e-12)
