"""Strides from foot contacts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from narx.gait.strides import normalised_strides


@given(st.floats(20.0, 500.0), st.lists(st.floats(0.8, 1.4), min_size=2, max_size=20))
def test_every_stride_of_a_periodic_motion_is_one_period(rate_hz, durations_s):
    contacts = 0.5 + np.concatenate([[0.0], np.cumsum(durations_s)])
    time = np.arange(0.0, contacts[-1] + 0.5, 1.0 / rate_hz)
    # phase advances by one from contact to contact; linear, so interpolation is exact
    phase = np.interp(time, contacts, np.arange(len(contacts)))
    strides = normalised_strides(time, phase[:, None], contacts, 11)
    usual = np.array(durations_s) <= 1.5 * np.median(durations_s)
    inner = strides[usual][:, 1:-1, 0] - np.arange(len(durations_s))[usual, None]
    # a kink at a contact is rounded within one sample
    tolerance = 2.0 / (rate_hz * min(durations_s))
    np.testing.assert_allclose(inner, np.tile(np.linspace(0, 1, 11)[1:-1], (len(inner), 1)),
                               atol=tolerance)  # fmt: skip


def test_a_missing_sample_invalidates_only_its_stride():
    time = np.arange(0.0, 10.0, 0.01)
    values = np.stack([np.sin(time), np.cos(time)], axis=1)
    values[250, 1] = np.nan
    strides = normalised_strides(time, values, np.arange(0.0, 10.0))
    assert np.isnan(strides).all(axis=(1, 2)).tolist() == [False] * 2 + [True] + [False] * 6


def test_pauses_and_what_reaches_beyond_the_signal_are_left_out():
    time = np.arange(0.0, 10.0, 0.01)
    contacts = np.array([-0.5, 0.5, 1.5, 2.5, 5.5, 6.5, 7.5, 10.5])
    strides = normalised_strides(time, time[:, None], contacts)
    there = np.isfinite(strides).all(axis=(1, 2))
    assert there.tolist() == [False, True, True, False, True, True, False]
    np.testing.assert_allclose(strides[1, [0, 50, 100], 0], [0.5, 1.0, 1.5], atol=1e-12)


@pytest.mark.parametrize(("pause_s", "is_a_stride"), [(1.4, True), (1.6, False)])
def test_a_pause_is_longer_than_one_and_a_half_strides(pause_s, is_a_stride):
    time = np.arange(0.0, 10.0, 0.01)
    contacts = np.array([0.5, 1.5, 2.5, 2.5 + pause_s, 3.5 + pause_s, 4.5 + pause_s])
    strides = normalised_strides(time, time[:, None], contacts)
    assert np.isfinite(strides[2]).all() == is_a_stride


@pytest.mark.parametrize("contacts", [[], [1.0]])
def test_no_stride(contacts):
    assert normalised_strides(np.arange(5.0), np.zeros((5, 3)), np.array(contacts)).shape == (
        0,
        101,
        3,
    )


def test_a_stride_that_ends_after_the_signal_is_left_out():
    time = np.arange(0.0, 10.0, 0.01)
    strides = normalised_strides(time, time[:, None], np.array([7.5, 8.5, 9.5, 10.5]))
    assert np.isfinite(strides).all(axis=(1, 2)).tolist() == [True, True, False]
