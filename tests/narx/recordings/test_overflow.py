"""Rates beyond 16 bits wrap around, and are continued."""

import re

import numpy as np
import pytest

from narx.errors import RecordingError
from narx.recordings.overflow import without_overflow


def _wrapped(rate_rad_s, range_deg_s):
    digit = np.radians(range_deg_s) / 2**15
    counts = np.round(rate_rad_s / digit).astype(int)
    return ((counts + 2**15) % 2**16 - 2**15) * digit, counts * digit


@pytest.mark.parametrize("rate_hz", [25.6, 50.0, 100.0, 200.0])
@pytest.mark.parametrize(("scale", "range_deg_s"), [(1.0, 125.0), (2.0, 250.0), (6.0, 1000.0)])
def test_rates_that_wrap_around_are_continued(device_walk, rate_hz, scale, range_deg_s):
    walk = device_walk(rate_hz, 30.0)
    peak = np.degrees(np.abs(walk.gyroscope_rad_s).max())
    wrapped, true = _wrapped(walk.gyroscope_rad_s * 1.2 * range_deg_s / peak, range_deg_s)
    beyond = (wrapped != true).any(axis=1)
    assert beyond.any()
    rate, (note,) = without_overflow(wrapped, 1.0 / rate_hz, "w")
    np.testing.assert_array_equal((rate != wrapped).any(axis=1), beyond)
    np.testing.assert_allclose(rate, true, atol=0.04 * np.radians(range_deg_s))
    said = re.fullmatch(r"(\d+) samples beyond the gyroscope's range of (\d+) deg/s, .*", note)
    assert int(said[1]) == beyond.sum()
    assert float(said[2]) == pytest.approx(range_deg_s, rel=0.05)


def test_rates_that_wrap_around_too_often_are_refused(device_walk):
    walk = device_walk(100.0, 30.0)
    peak = np.degrees(np.abs(walk.gyroscope_rad_s).max())
    wrapped, _ = _wrapped(walk.gyroscope_rad_s * 1000.0 / peak, 250.0)
    with pytest.raises(RecordingError, match="its 16-bit numbers overflowed; expected a larger"):
        without_overflow(wrapped, 0.01, "w")


def test_a_wrap_that_does_not_come_back_is_refused(device_walk):
    walk = device_walk(100.0, 30.0)
    peak = np.degrees(np.abs(walk.gyroscope_rad_s).max())
    wrapped, _ = _wrapped(walk.gyroscope_rad_s * 300.0 / peak, 250.0)
    jumps = np.flatnonzero(np.abs(np.diff(wrapped[:, 1])) > np.radians(250.0))
    # the recording ends beyond the range
    with pytest.raises(RecordingError, match="for too long to be continued"):
        without_overflow(wrapped[: jumps[-1]], 0.01, "w")


def test_other_signals_are_left(device_walk):
    walk = device_walk(50.0, 30.0)
    noise = np.random.default_rng(0).normal(0.0, 5.0, (3000, 3))
    spikes = walk.gyroscope_rad_s.copy()
    spikes[[700, 701, 900], 1] = [30.0, -30.0, -20.0]
    for rate in (walk.gyroscope_rad_s, np.clip(walk.gyroscope_rad_s, -1.5, 1.5), noise, spikes):
        assert without_overflow(rate, 0.02, "w")[1] == ()
    assert without_overflow(np.full((50, 3), np.nan), 0.02, "w")[1] == ()


@pytest.mark.parametrize(("period_s", "refused"), [(2.4, False), (3.2, True)])
def test_rates_are_beyond_the_range_for_half_a_second_at_most(period_s, refused):
    """A sine of 1.2 times the range is beyond it for 0.186 of its period at a time."""
    time_s = np.arange(0.0, 60.0, 0.01)
    swing = np.where(time_s < 2 * period_s, np.sin(2 * np.pi * time_s / period_s), 0.0)
    rates = np.radians(300.0) * swing[:, None] * [0.0, 1.0, 0.1]
    wrapped, true = _wrapped(rates, 250.0)
    if refused:
        with pytest.raises(RecordingError, match="for too long to be continued"):
            without_overflow(wrapped, 0.01, "w")
        return
    np.testing.assert_allclose(without_overflow(wrapped, 0.01, "w")[0], true, atol=0.1)


@pytest.mark.parametrize(("size", "refused"), [(1.05, False), (1.2, True)])
def test_a_quarter_of_the_samples_is_too_many(size, refused):
    """Beyond the range are 20 and 37 % of a sine of 1.05 and 1.2 times the range."""
    time_s = np.arange(0.0, 30.0, 0.005)
    rates = size * np.radians(250.0) * np.outer(np.sin(2 * np.pi * time_s), [0.0, 1.0, 0.1])
    wrapped, true = _wrapped(rates, 250.0)
    if refused:
        with pytest.raises(RecordingError, match="for too long to be continued"):
            without_overflow(wrapped, 0.005, "w")
        return
    np.testing.assert_allclose(without_overflow(wrapped, 0.005, "w")[0], true, atol=0.1)
