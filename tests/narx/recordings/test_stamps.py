"""Stamps become sampling times: the samples and their true times are known, the stamps are not."""

import numpy as np
import pytest

from narx.errors import RecordingError, UserError
from narx.recordings.arrival import regular_clock
from narx.recordings.stamps import checked_rate_hz, sampling_times


def _at_arrival(time, size, delay_s=0.006):
    """A packet arrives with its last sample, and its samples are then read out 0.3 ms apart."""
    last = np.minimum(np.arange(len(time)) // size * size + size - 1, len(time) - 1)
    return time[last] + delay_s + 0.0003 * (np.arange(len(time)) % size)


def _queued(time, size, mean_delay_s, apart_s):
    """Packets wait for an exponential time, and none overtakes another."""
    last = np.minimum(np.arange(len(time)) // size * size + size - 1, len(time) - 1)
    arrival = np.maximum.accumulate(time[last] + np.repeat(
        np.random.default_rng(size).exponential(mean_delay_s, len(time) // size), size
    ))  # fmt: skip
    # at once, or read out one after the other
    return arrival + apart_s * (np.arange(len(time)) % size)


RNG = np.random.default_rng(0)
STAMPS = {
    "exponential delays, equal stamps": (100.0, lambda t: _queued(t, 2, 0.02, 0.0), 0.01),
    "exponential delays of single samples": (50.0, lambda t: _queued(t, 1, 0.03, 0.0), 0.012),
    "exponential delays of large packets": (100.0, lambda t: _queued(t, 20, 0.02, 0.0003), 0.01),
    "packets of 6": (60.0, lambda t: _at_arrival(t, 6), 0.008),
    "packets of 10 with one stamp": (100.0, lambda t: t[np.arange(len(t)) // 10 * 10 + 9], 0.002),
    "packets whose radio waits": (
        50.0,
        lambda t: _at_arrival(t, 5) + np.repeat(RNG.uniform(0, 0.02, len(t) // 5), 5),
        0.01,
    ),
    "jitter": (50.0, lambda t: t + RNG.normal(0.0, 0.006, len(t)), 0.002),
    "equal stamps in steps of 10 ms": (128.0, lambda t: np.floor(t * 100.0) / 100.0, 0.006),
    "whole seconds": (50.0, lambda t: np.floor(t), 0.03),
}


@pytest.mark.parametrize("kind", STAMPS)
def test_a_regular_clock_takes_the_place_of_stamps_at_arrival(device_walk, kind):
    rate_hz, stamp, tolerance_s = STAMPS[kind]
    walk = device_walk(rate_hz, 30.0)
    stamps = stamp(walk.time_s)
    found = sampling_times(stamps, walk.gyroscope_rad_s, "w")
    np.testing.assert_allclose(found.time_s, walk.time_s, atol=tolerance_s)
    np.testing.assert_allclose(np.diff(found.time_s) * rate_hz, 1.0, atol=2e-3)
    assert "a regular clock of" in found.notes[-1]


def test_lost_packets_stay_lost(device_walk):
    walk = device_walk(60.0, 30.0)
    stamps = _at_arrival(walk.time_s, 6)
    kept = np.repeat(RNG.random(len(stamps) // 6) > 0.1, 6)
    found = sampling_times(stamps[kept], walk.gyroscope_rad_s[kept], "w")
    np.testing.assert_allclose(found.time_s, walk.time_s[kept], atol=0.01)


def test_irregular_sampling_is_kept(device_walk):
    time = np.cumsum(np.random.default_rng(1).uniform(0.004, 0.02, 2500))
    walk = device_walk(time_s=time)
    found = sampling_times(time, walk.gyroscope_rad_s, "w")
    np.testing.assert_array_equal(found.time_s, time)
    assert not found.notes


def test_lost_samples_and_a_pause_do_not_matter(device_walk):
    walk = device_walk(50.0, 30.0)
    keep = (np.random.default_rng(2).random(1500) > 0.1) & ~(
        (walk.time_s > 12) & (walk.time_s < 15)
    )
    time = walk.time_s[keep]
    found = sampling_times(time, walk.gyroscope_rad_s[keep], "w")
    np.testing.assert_array_equal(found.time_s, time)


def test_repeated_and_exchanged_rows(device_walk):
    walk = device_walk(50.0, 30.0)
    rows = np.arange(1500)
    twice = np.sort(np.r_[rows, 700, 700, 900])
    found = sampling_times(walk.time_s[twice], walk.gyroscope_rad_s[twice], "w")
    np.testing.assert_array_equal(found.time_s, walk.time_s)
    assert found.notes[0].startswith("3 rows that repeat their predecessor left out, the first")
    rows[[300, 301]] = [301, 300]
    found = sampling_times(walk.time_s[rows], walk.gyroscope_rad_s[rows], "w")
    np.testing.assert_array_equal(walk.time_s[rows][found.rows], walk.time_s)
    assert found.notes == ("2 rows were out of order and are put in the order of their times",)


@pytest.mark.parametrize(
    ("stamps", "message"),
    [
        (lambda t: t * 1e3, r"time_s steps by 20 s \(0.05 Hz\); milliseconds\? Expected s"),
        (lambda t: t * 1e6, r"time_s steps by 20000 s .*; microseconds\?"),
        (lambda t: t * 1e9 + 1e15, r"time_s steps by 2e\+07 s .*; nanoseconds\?"),
        (lambda t: t / 86400, "Hz or less"),
        (lambda t: np.where(t > 15, t - 14.0, t), "does not increase at data row 752"),
        (lambda t: t[::-1], "never increases"),
        (lambda t: 0 * t + 3.0, "never increases"),
        (lambda t: np.where(t == 1.0, np.nan, t), "the time is missing at data row 51"),
    ],
)
def test_times_that_are_not_seconds_are_refused(device_walk, stamps, message):
    walk = device_walk(50.0, 30.0)
    with pytest.raises(RecordingError, match=f"^w: .*{message}"):
        sampling_times(stamps(walk.time_s), walk.gyroscope_rad_s, "w")


@pytest.mark.parametrize("value", [0, -50, np.nan, np.inf, None, "", "fast", True, 1e9, 0.02])
def test_impossible_rates_are_refused(value):
    with pytest.raises(UserError, match=r"^rate is "):
        checked_rate_hz(value, "rate")
    assert checked_rate_hz("50", "rate") == 50.0


def test_an_interval_given_as_rate_is_pointed_out():
    with pytest.raises(UserError, match=r"50 Hz, if it is the interval in s$"):
        checked_rate_hz(0.02, "rate")


@pytest.mark.parametrize(
    "period_s", [86400.0, 3600.0, 65.536, *(2.0**bits * unit for bits in (24, 32)
                                            for unit in (1e-3, 1e-6))],
)  # fmt: skip
def test_a_time_of_day_and_a_counter_go_on_where_they_begin_again(device_walk, period_s):
    walk = device_walk(50.0, 30.0)
    stamps = (walk.time_s + period_s - 12.0) % period_s
    found = sampling_times(stamps, walk.gyroscope_rad_s, "w")
    np.testing.assert_allclose(found.time_s, walk.time_s + period_s - 12.0, atol=1e-6)
    assert found.notes == (f"time begins again after {period_s:.10g} s, continued from there",)


def test_halves_in_the_wrong_order_are_not_sorted(device_walk):
    walk = device_walk(50.0, 30.0)
    stamps = (walk.time_s + 40.0) % 60.0
    with pytest.raises(RecordingError, match=r"does not increase at data row 1001 \(59.98 s, then"):
        sampling_times(stamps, walk.gyroscope_rad_s, "w")


def test_arrival_without_a_regular_clock_is_refused(device_walk):
    walk = device_walk(50.0, 30.0)
    delay = np.repeat(np.random.default_rng(0).uniform(0.0, 3.0, 15).cumsum(), 100)
    stamps = _at_arrival(walk.time_s, 4) + delay
    with pytest.raises(RecordingError, match="as if taken at arrival, and no regular clock"):
        sampling_times(stamps, walk.gyroscope_rad_s, "w")


@pytest.mark.parametrize("rows", [
    lambda n: np.sort(np.r_[np.arange(n), RNG.choice(n, n // 10)]),
    lambda n: np.r_[np.arange(700), np.arange(650, n)],
])  # fmt: skip
def test_rows_that_occur_twice_are_left_out(device_walk, rows):
    walk = device_walk(50.0, 30.0)
    chosen = rows(len(walk.time_s))
    found = sampling_times(walk.time_s[chosen], walk.gyroscope_rad_s[chosen], "w")
    np.testing.assert_array_equal(found.time_s, walk.time_s)
    np.testing.assert_array_equal(walk.gyroscope_rad_s[chosen][found.rows], walk.gyroscope_rad_s)
    assert "rows that occur twice left out" in found.notes[-1]


@pytest.mark.parametrize("late", [0, 1])
def test_packets_of_a_clock_that_starts_at_zero_are_stamped_at_their_end(late):
    """All seven samples have the time of the last of them, or of the interval after it."""
    time = np.arange(700) / 50.0
    stamps = time[np.arange(700) // 7 * 7 + 6] + late / 50.0
    rates = np.sin(2.0 * np.pi * time)[:, None] * np.ones(3)
    found = sampling_times(stamps, rates, "walk")
    np.testing.assert_allclose(found.time_s, time + late / 50.0, atol=1e-6)
    assert "of packets of 7 samples" in found.notes[-1]


@pytest.mark.parametrize(("rate_hz", "message"), [
    (4.9, r"4\.9 Hz.*at 5 Hz or more"), (5.1, None), (1.9e4, None),
    (2.1e4, r"2\.1e\+04 Hz.*at 20000 Hz or less"),
])  # fmt: skip
def test_stamps_have_the_rate_of_an_inertial_sensor(rate_hz, message):
    stamps, rates = np.arange(300) / rate_hz, np.zeros((300, 3))
    if message is None:
        np.testing.assert_array_equal(sampling_times(stamps, rates, "w").time_s, stamps)
        return
    with pytest.raises(RecordingError, match=message):
        sampling_times(stamps, rates, "w")


def test_sampling_that_is_itself_irregular_about_a_line_is_kept(device_walk):
    """The deviations have no structure, but the signal is smooth on the stamps."""
    time = np.arange(1500) / 50.0 + np.random.default_rng(5).uniform(-0.008, 0.008, 1500)
    found = sampling_times(time, device_walk(time_s=time).gyroscope_rad_s, "w")
    np.testing.assert_array_equal(found.time_s, time)
    assert not found.notes


def test_delays_that_grow_do_not_change_the_rate():
    """The line is below the stamps: the fastest packets have no delay, early or late."""
    time, rng = np.arange(3000) / 50.0, np.random.default_rng(6)
    delay_s = rng.exponential(np.linspace(0.01, 0.05, 1500)).repeat(2)
    stamps = np.maximum.accumulate(time[np.arange(3000) // 2 * 2 + 1] + delay_s)
    clock_s, how = regular_clock(stamps)
    assert how.startswith("stamps at arrival")
    np.testing.assert_allclose(np.diff(clock_s) * 50.0, 1.0, atol=1e-4)


def test_a_line_on_which_the_signal_is_not_clearly_smoother_is_not_used(device_walk):
    """Noise hides whether the stamps or the line are the times of the samples."""
    time = np.arange(1500) / 50.0 + np.random.default_rng(5).uniform(-0.008, 0.008, 1500)
    rates = device_walk(time_s=time).gyroscope_rad_s
    rates = rates + np.random.default_rng(6).normal(0.0, 0.3, rates.shape)
    found = sampling_times(time, rates, "w")
    np.testing.assert_array_equal(found.time_s, time)
    assert not found.notes


def test_a_tenth_of_late_stamps_is_not_regular(device_walk):
    walk = device_walk(50.0, 30.0)
    late = 0.008 * (np.random.default_rng(7).random(1500) < 0.1)
    found = sampling_times(walk.time_s + late, walk.gyroscope_rad_s, "w")
    np.testing.assert_allclose(np.diff(found.time_s) * 50.0, 1.0, atol=2e-3)


def test_rounded_jitter_is_symmetric_and_no_arrival(device_walk):
    """Equal stamps are frequent, but the line goes through the middle of them, not below."""
    walk = device_walk(128.0, 30.0)
    jitter = np.random.default_rng(8).normal(0.0, 0.006, len(walk.time_s))
    stamps = np.sort(np.round(walk.time_s + jitter, 2))
    assert (np.diff(stamps) == 0).mean() > 0.25
    clock_s, how = regular_clock(stamps)
    assert how.startswith("jitter of the stamps")
    np.testing.assert_allclose(clock_s, walk.time_s, atol=2e-3)


@pytest.mark.parametrize("jitter_s", [0.0, 0.002, 0.003, 0.006])
@pytest.mark.parametrize(("rate_hz", "unit_s"), [
    (128, 0.01), (100, 0.01), (200, 0.005), (200, 0.01), (200, 0.02),
])  # fmt: skip
def test_stamps_of_few_digits_cost_at_most_half_of_the_last_one(rate_hz, unit_s, jitter_s):
    time_s = np.arange(60 * rate_hz) / rate_hz
    jittered = time_s + jitter_s * np.random.default_rng(0).standard_normal(len(time_s))
    for digits in (np.round, np.floor):
        clock_s, _ = regular_clock(np.sort(digits(jittered / unit_s + 1e-9) * unit_s))
        np.testing.assert_allclose(clock_s, time_s, atol=0.55 * unit_s)


def test_jitter_does_not_shift_stamps_in_steps_from_their_end():
    time_s = np.arange(12000) / 200.0
    jittered = time_s + 0.006 * np.random.default_rng(0).standard_normal(len(time_s))
    clock_s, note = regular_clock(np.sort(np.floor(jittered / 0.02) * 0.02))
    assert "in steps of 0.02 s" in note
    np.testing.assert_allclose(clock_s, time_s, atol=0.0005)


def test_the_note_tells_jitter_rate_and_size_of_packets():
    time_s = np.arange(3000) / 50.0
    jittered = time_s + np.random.default_rng(0).normal(0.0, 0.006, 3000)
    assert regular_clock(jittered)[1].startswith(
        "jitter of the stamps 6.0 ms: a regular clock of 50"
    )
    sixes = np.arange(3000) / 60.0
    arrived = _at_arrival(sixes, 6)
    # now and then two packets arrive together
    for packet in (50, 200, 333):
        arrived[6 * packet : 6 * packet + 6] = arrived[6 * packet + 6] - 1e-4 * np.arange(6, 0, -1)
    clock_s, note = regular_clock(arrived)
    assert (
        note == "stamps at arrival of packets of 6 samples: a regular clock of 60 Hz in its place"
    )
    # the fastest packet has no delay, and its samples came with its first one
    np.testing.assert_allclose(clock_s, sixes + 0.006, atol=1e-3)


@pytest.mark.parametrize("begin_s", [0.0, 1.7e9])
def test_stamps_in_steps_are_recognised_in_the_digits_of_a_date(begin_s):
    """Where numbers of double precision are a quarter of a microsecond apart."""
    time_s = begin_s + np.arange(6000) / 200.0
    clock_s, note = regular_clock(np.floor((time_s - begin_s) / 0.02 + 1e-6) * 0.02 + begin_s)
    assert note.startswith("stamps in steps of 0.02 s: a regular clock of 200 Hz")
    np.testing.assert_allclose(clock_s - begin_s, time_s - begin_s, atol=5e-5)


def test_jitter_of_half_an_interval_averages_out_over_a_second():
    for seed in range(3):
        time_s = np.arange(1500) / 50.0
        clock_s, _ = regular_clock(time_s + np.random.default_rng(seed).normal(0.0, 0.012, 1500))
        np.testing.assert_allclose(clock_s, time_s, atol=0.003)


def _delayed(mean_s, slow_s=0.0, seed=0):
    """Pairs with exponential delays at 50 Hz, which are longer by some time in the middle."""
    time_s = np.arange(3000) / 50.0
    delay_s = np.random.default_rng(seed).exponential(mean_s, 1500).repeat(2)
    delay_s += slow_s * np.exp(-(((time_s - 30.0) / 10.0) ** 2))
    return time_s, np.maximum.accumulate(time_s[np.arange(3000) // 2 * 2 + 1] + delay_s)


def test_long_delays_may_wander_by_half_of_themselves():
    """Their least values over two seconds differ by 30 to 50 ms, the clock is right to 4 ms."""
    for seed in range(4):
        time_s, stamps = _delayed(0.08, seed=seed)
        clock_s, note = regular_clock(stamps)
        assert note.startswith("stamps at arrival")
        np.testing.assert_allclose(clock_s, time_s, atol=0.004)


@pytest.mark.parametrize(
    ("mean_s", "slow_s"), [(0.12, 0.0), (0.01, 0.03)], ids=["by 75 ms", "more than the delays"]
)
def test_delays_that_wander_too_far_are_not_explained(mean_s, slow_s):
    for seed in range(3):
        assert regular_clock(_delayed(mean_s, slow_s, seed)[1]) == (None, "")


def test_jitter_of_a_whole_step_is_not_truncation():
    """Rounded to 20 ms and sorted, at 100 Hz: the line goes through the middle."""
    time_s = np.arange(6000) / 100.0
    jittered = time_s + np.random.default_rng(1).normal(0.0, 0.02, 6000)
    clock_s, note = regular_clock(np.sort(np.round(jittered / 0.02) * 0.02))
    assert note.startswith("jitter")
    np.testing.assert_allclose(clock_s, time_s, atol=0.002)
