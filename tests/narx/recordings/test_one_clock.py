"""Accelerometer and gyroscope with rows of their own."""

import numpy as np
import pytest

from narx.recordings.one_clock import at_gyroscope_times, union_of_rows
from narx.recordings.trial import ImuRecording


def test_usual_intervals_decide_although_the_recording_pauses():
    """Gyroscope at 100 Hz, accelerometer at 50 Hz, which lacks seven samples; a pause of 130 s."""
    turned_s = np.r_[np.arange(0.0, 10.0, 0.01), np.arange(140.0, 150.0, 0.01)]
    pulled_s = np.r_[np.arange(0.002, 10.0, 0.02), np.arange(140.002, 150.0, 0.02)]
    pulled_s = pulled_s[(pulled_s < 5.0) | (pulled_s > 5.16)]
    rates = np.ones((len(turned_s), 3))
    turned = ImuRecording("leg", turned_s, rates, np.full_like(rates, np.nan))
    force = np.column_stack([pulled_s, 2.0 * pulled_s, np.full_like(pulled_s, 9.81)])
    found = at_gyroscope_times(union_of_rows(turned, pulled_s, force))
    np.testing.assert_array_equal(found.time_s, turned_s)
    (note,) = found.notes
    assert note.startswith("gyroscope at 100 Hz and accelerometer at 50 Hz on one time axis")
    there = np.isfinite(found.accelerometer_m_s2).all(axis=1)
    np.testing.assert_allclose(found.accelerometer_m_s2[there, 0], turned_s[there], atol=1e-9)
    assert not there[(turned_s > 5.0) & (turned_s < 5.16)].any()
    assert there[(turned_s > 0.01) & (turned_s < 4.9)].all()


@pytest.mark.parametrize(("without_force", "slower"), [(169, False), (171, True)])
def test_a_slower_accelerometer_is_missing_in_a_fifth_of_the_rows_of_the_gyroscope(
    without_force, slower
):
    """Of 850 rows of the gyroscope; 150 of the accelerometer alone are too few for its own."""
    rates, force = np.ones((1000, 3)), np.full((1000, 3), 9.81)
    rates[::20] = rates[7::20] = rates[13::20] = np.nan
    force[np.flatnonzero(np.isfinite(rates[:, 0]))[:without_force]] = np.nan
    recording = ImuRecording("leg", np.arange(1000) / 100.0, rates, force)
    assert (at_gyroscope_times(recording) is not recording) == slower


def test_a_sample_without_one_axis_is_interpolated_and_two_in_a_row_are_a_gap():
    """Gyroscope at 100 Hz from 0 to 2 s, accelerometer at 50 Hz at every other of its samples."""
    time_s = np.arange(201) / 100.0
    force = np.full((201, 3), np.nan)
    force[::2] = np.column_stack([time_s, 2.0 * time_s, 9.81 + 0.0 * time_s])[::2]
    force[50, 2] = np.nan
    force[100] = force[102] = np.nan
    found = at_gyroscope_times(ImuRecording("leg", time_s, np.ones((201, 3)), force))
    there = np.isfinite(found.accelerometer_m_s2).all(axis=1)
    # from its first sample to its last one, but for the three between 0.98 and 1.04 s
    np.testing.assert_array_equal(np.flatnonzero(~there), np.arange(99, 104))
    np.testing.assert_allclose(found.accelerometer_m_s2[there, 1], 2.0 * time_s[there], atol=1e-12)
