"""Resampling to uniform clocks keeps measured data and does not fill gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from narx.errors import RecordingError
from narx.recordings.resampling import (
    contiguous_pieces,
    resample_quaternions,
    resample_vectors,
    uniform_clock,
)


def _signal(time_s):
    """Band-limited below 6 Hz."""
    t = np.asarray(time_s)
    return np.column_stack(
        [np.sin(2 * np.pi * 1.1 * t) + 0.3 * np.cos(2 * np.pi * 5.3 * t), np.cos(2 * np.pi * t), t]
    )


def _irregular(rate_hz, duration_s, jitter, seed=0):
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration_s, 1.0 / rate_hz)
    return time + jitter / rate_hz * rng.uniform(-0.5, 0.5, len(time))


def test_clock_is_made_of_multiples_of_the_interval():
    clock = uniform_clock(0.123, 1.0, 100.0)
    assert clock[0] == 0.13
    assert clock[-1] == 1.0
    assert np.allclose(np.diff(clock), 0.01)
    with pytest.raises(RecordingError, match="no common time"):
        uniform_clock(1.0, 0.5, 100.0)


@pytest.mark.parametrize(("native_hz", "new_hz"), [(199.0, 100.0), (94.0, 100.0), (500.0, 60.0)])
def test_band_limited_signal_is_reproduced(native_hz, new_hz):
    time = _irregular(native_hz, 10.0, jitter=0.4)
    clock = uniform_clock(time[0], time[-1], new_hz)
    resampled = resample_vectors(time, _signal(time), clock, max_gap_s=0.05)
    inner = slice(20, -20)
    assert np.abs(resampled - _signal(clock))[inner].max() < 2e-3
    assert np.isfinite(resampled).all()


def test_the_same_clock_changes_nothing():
    time = np.arange(500) / 100.0
    values = np.random.default_rng(1).normal(size=(500, 3))
    assert np.allclose(resample_vectors(time, values, time, max_gap_s=0.02), values, atol=1e-12)


def test_frequencies_above_the_new_nyquist_are_filtered_out():
    time = np.arange(0, 20.0, 1 / 500.0)
    clock = uniform_clock(0.0, time[-1], 100.0)
    above = np.sin(2 * np.pi * 90.0 * time)[:, None]  # would alias to 10 Hz
    assert np.abs(resample_vectors(time, above, clock, max_gap_s=0.01))[30:-30].max() < 2e-3
    inside = np.sin(2 * np.pi * 35.0 * time)[:, None]
    kept = resample_vectors(time, inside, clock, max_gap_s=0.01)[:, 0]
    assert np.abs(kept - np.sin(2 * np.pi * 35.0 * clock))[30:-30].max() < 5e-3


def test_level_and_slope_are_kept_up_to_the_ends():
    time = np.arange(0, 2.0, 1 / 400.0)
    clock = uniform_clock(0.0, time[-1], 50.0)
    line = np.column_stack([np.full_like(time, 3.0), 5.0 - 2.0 * time])
    expected = np.column_stack([np.full_like(clock, 3.0), 5.0 - 2.0 * clock])
    assert np.allclose(resample_vectors(time, line, clock, max_gap_s=0.01), expected, atol=1e-3)


@settings(max_examples=25, deadline=None)
@given(begin=st.floats(1.0, 4.0), length=st.floats(0.1, 1.0), as_nan=st.booleans())
def test_gaps_stay_gaps(begin, length, as_nan):
    time = _irregular(200.0, 6.0, jitter=0.3)
    values = _signal(time)
    lost = (time > begin) & (time < begin + length)
    if as_nan:
        values[lost] = np.nan
    else:
        time, values = time[~lost], values[~lost]
    clock = uniform_clock(0.01, 5.9, 100.0)
    resampled = resample_vectors(time, values, clock, max_gap_s=0.05)
    there = np.isfinite(resampled).all(axis=1)
    inside = (clock > begin + 0.02) & (clock < begin + length - 0.02)
    outside = (clock < begin - 0.02) | (clock > begin + length + 0.02)
    assert not there[inside].any()
    assert there[outside].all()
    # the filter does not leak across the gap
    assert np.abs(resampled - _signal(clock))[there].max() < 0.05


def test_outside_the_recording_is_missing():
    time = np.arange(1.0, 2.0, 0.01)
    clock = np.arange(0.0, 3.0, 0.02)
    resampled = resample_vectors(time, _signal(time), clock, max_gap_s=0.05)
    assert np.isnan(resampled[(clock < 0.99) | (clock > 2.0)]).all()
    assert np.isfinite(resampled[(clock >= 1.0) & (clock <= 1.99)]).all()


def test_nothing_to_resample():
    clock = np.arange(10) / 10.0
    assert np.isnan(resample_vectors([0.0, 1.0], np.full((2, 3), np.nan), clock, max_gap_s=2)).all()


def test_pieces_split_at_missing_samples_and_long_intervals():
    time = [0.0, 0.1, 0.2, 0.3, 0.4, 1.0, 1.1]
    there = [True, True, False, True, True, True, True]
    pieces = contiguous_pieces(time, there, max_gap_s=0.15)
    assert [piece.tolist() for piece in pieces] == [[0, 1], [3, 4], [5, 6]]


def test_slerp_follows_a_constant_turn_and_leaves_gaps():
    time = np.arange(0, 4.0, 1 / 60.0)
    turn = np.array([0.3, -1.2, 0.7])
    quaternion = Rotation.from_rotvec(time[:, None] * turn).as_quat(scalar_first=True)
    quaternion[::7] *= -1.0  # the same orientations
    quaternion[60:70] = np.nan
    clock = uniform_clock(0.0, time[-1], 100.0)
    resampled = resample_quaternions(time, quaternion, clock, max_gap_s=0.025)
    there = np.isfinite(resampled).all(axis=1)
    in_gap = (clock > time[59]) & (clock < time[70])
    assert (there == ~in_gap).all()
    expected = Rotation.from_rotvec(clock[there, None] * turn)
    error = (Rotation.from_quat(resampled[there], scalar_first=True).inv() * expected).magnitude()
    assert error.max() < 1e-9


@pytest.mark.parametrize("begin_s", [0.0, 1e5, 1.7e9])
def test_no_sample_is_lost_by_the_rounding_of_large_stamps(begin_s):
    time_s = np.round(begin_s + 0.01 * np.arange(3000), 4)
    clock_s = np.linspace(time_s[0], time_s[-1], 3000)
    values = np.sin(0.06 * np.arange(3000))[:, None]
    resampled = resample_vectors(time_s, values, clock_s, max_gap_s=0.05)
    np.testing.assert_allclose(resampled, values, atol=1e-6 if begin_s < 1e9 else 1e-4)


def test_lost_samples_do_not_switch_the_filter_off():
    """One interval is five times as long; what is above the new Nyquist frequency stays out."""
    time = np.arange(0, 20.0, 1 / 500.0)
    time = np.delete(time, [5000, 5001, 5002, 5003])
    clock = uniform_clock(0.0, time[-1], 100.0)
    above = np.sin(2 * np.pi * 90.0 * time)[:, None]
    found = resample_vectors(time, above, clock, max_gap_s=0.02)[:, 0]
    far = np.abs(clock - 10.0) > 1.0
    assert np.abs(found[far])[30:-30].max() < 2e-3
