"""The uncertainty that filled gaps add: none without gaps, growth, decay, sums of variances."""

import numpy as np
import pytest

from narx.inference.filled_gaps import filled_gap_std_rad
from narx.inference.predict import predict
from narx.inference.pretrained import pretrained
from narx.recordings.trial import ImuRecording

TIME_S = np.arange(0.0, 60.0, 0.01)


def _with_gaps(*gaps_s):
    time_s = TIME_S
    rates = np.ones((len(time_s), 3))
    for start, stop in gaps_s:
        rates[(time_s > start + 1e-6) & (time_s < stop - 1e-6)] = np.nan
    return np.degrees(filled_gap_std_rad(time_s, rates, time_s, 1.1))


def test_it_is_zero_without_gaps_after_short_ones_and_before_the_first():
    assert not _with_gaps().any()
    assert not _with_gaps((20.0, 20.1), (30.0, 32.0)).any()
    assert not _with_gaps((20.0, 20.4))[: 2000 + 1].any()


def test_it_grows_with_the_gap_up_to_a_limit_and_halves_in_five_seconds():
    one = _with_gaps((20.0, 20.4))
    assert one[2020, 0] == pytest.approx(12.0 * 0.2)
    assert one[2040] == pytest.approx([4.8, 3.2, 36.0])
    assert one[2040 + 485] == pytest.approx(0.5 * one[2040], rel=1e-3)
    assert one[2040:].max(axis=0) == pytest.approx(one[2040])
    assert _with_gaps((20.0, 21.0))[2100] == pytest.approx([7.0, 5.0, 90.0])


def test_variances_of_several_gaps_add_up():
    both = _with_gaps((20.0, 20.3), (22.0, 22.2))
    one, other = _with_gaps((20.0, 20.3)), _with_gaps((22.0, 22.2))
    np.testing.assert_allclose(both, np.hypot(one, other), atol=1e-12)


def test_a_prediction_is_less_certain_after_a_filled_gap():
    time_s = TIME_S
    phase = 2.0 * np.pi * 0.9 * time_s[:, None] + [0.0, 1.0, 2.0]
    rates = np.cos(phase) * [0.4, 2.0, 0.3]
    whole = ImuRecording("leg_right", time_s, rates, np.full_like(rates, np.nan))
    holed = rates.copy()
    holed[4001:4040] = np.nan
    cut = ImuRecording("leg_right", time_s, holed, np.full_like(rates, np.nan))
    method = pretrained().method()
    certain, doubtful = (predict(one, method, remove_bias=False).std_rad for one in (whole, cut))
    added_deg = np.degrees(np.sqrt(doubtful[4041] ** 2 - certain[4041] ** 2))
    assert (added_deg >= np.array([4.5, 3.0, 30.0])).all()
    np.testing.assert_allclose(doubtful[:3900], certain[:3900], rtol=1e-2)


def test_it_is_that_of_the_time_since_the_gap_began_on_any_clock():
    rates = np.ones((len(TIME_S), 3))
    rates[(TIME_S > 20.0 + 1e-6) & (TIME_S < 20.4 - 1e-6)] = np.nan
    clock_s = np.array([20.13, 20.33, 20.4 + 7.0, 20.4 + 35.0])
    found = np.degrees(filled_gap_std_rad(TIME_S, rates, clock_s, 1.1))[:, 0]
    expected = 12.0 * np.array([0.13, 0.33, 0.4 * np.exp(-1.0), 0.4 * np.exp(-5.0)])
    np.testing.assert_allclose(found, expected)
