"""Thresholds below which a quiet part counts as rest."""

import numpy as np
import pytest

from narx.errors import RecordingError, UserError
from narx.inference.bias import check_known_start, remove_static_bias
from narx.recordings.trial import ImuRecording


def recording(mean_deg_s, scatter_deg_s, seconds=30.0):
    """A rate that oscillates at 2 Hz about its mean, with a given root mean square."""
    time_s = np.arange(0.0, seconds, 0.01)
    rate = np.zeros((len(time_s), 3))
    rate[:, 1] = mean_deg_s + np.sqrt(2.0) * scatter_deg_s * np.sin(2 * np.pi * 2.0 * time_s)
    return ImuRecording("imu", time_s, np.radians(rate), np.full_like(rate, np.nan))


@pytest.mark.parametrize(
    ("mean_deg_s", "scatter_deg_s", "removed"),
    [(1.0, 1.9, True), (1.0, 2.1, False), (9.9, 0.1, True), (10.1, 0.1, False)],
)
def test_sway_below_2_and_a_bias_below_10_deg_s_are_rest(mean_deg_s, scatter_deg_s, removed):
    bias, note = remove_static_bias(recording(mean_deg_s, scatter_deg_s), True, None, "x")
    if removed:
        assert np.degrees(bias) == pytest.approx([0.0, mean_deg_s, 0.0], abs=1e-6)
        assert "from the quietest 5 s removed" in note
    else:
        assert bias is None
        assert "not removed" in note


@pytest.mark.parametrize(
    ("mean_deg_s", "scatter_deg_s", "refused"),
    [(1.0, 4.9, False), (1.0, 5.1, True), (9.9, 0.1, False), (10.1, 0.1, True)],
)
def test_a_part_declared_still_may_sway_by_5_deg_s(mean_deg_s, scatter_deg_s, refused):
    one = recording(mean_deg_s, scatter_deg_s)
    if refused:
        with pytest.raises(RecordingError, match="is not at rest"):
            remove_static_bias(one, True, (2.0, 11.99), "x")
    else:
        bias, _ = remove_static_bias(one, True, (2.0, 11.99), "x")
        assert np.degrees(bias) == pytest.approx([0.0, mean_deg_s, 0.0], abs=0.05)


@pytest.mark.parametrize(("seconds", "window"), [(3.0, "2 s"), (1.0, "1 s"), (0.9, None)])
def test_a_window_is_not_longer_than_the_recording(seconds, window):
    bias, note = remove_static_bias(recording(1.0, 0.0, seconds), True, None, "x")
    if window is None:
        assert bias is None
        assert "no 1 s at rest" in note
    else:
        assert f"from the quietest {window} removed" in note


def test_a_window_as_long_as_the_recording_is_searched():
    time_s = np.arange(64) / 64.0
    one = ImuRecording("imu", time_s, np.zeros((64, 3)), np.full((64, 3), np.nan))
    assert one.n_samples / one.sampling_rate_hz == 1.0
    assert "from the quietest 1 s removed" in remove_static_bias(one, True, None, "x")[1]


@pytest.mark.parametrize(("mean_deg_s", "missing", "message"), [
    (19.0, 9, None), (21.0, 0, "turns by 21 deg/s in the first 0.2 s"),
    (0.0, 12, r"the gyroscope's first 0\.12 s are missing"),
])  # fmt: skip
def test_a_known_start_is_there_and_slower_than_20_deg_s(mean_deg_s, missing, message):
    one = recording(mean_deg_s, 0.0)
    rate = one.gyroscope_rad_s.copy()
    rate[:missing] = np.nan
    if message is None:
        check_known_start(one.time_s, rate, "x")
        return
    with pytest.raises(RecordingError, match=f"^x: start_pose=known, but .*{message}"):
        check_known_start(one.time_s, rate, "x")


def test_sway_about_all_three_axes_counts():
    one = recording(0.0, 4.0)
    one.gyroscope_rad_s[:, 0] = one.gyroscope_rad_s[:, 1]
    with pytest.raises(RecordingError, match=r"varies by 5\.7 deg/s"):
        remove_static_bias(one, True, (2.0, 11.99), "x")


def test_the_bias_is_the_mean_from_the_first_to_the_last_sample_of_the_part():
    one = recording(0.0, 0.0)
    one.gyroscope_rad_s[[200, 201, 202, 203], 2] = np.radians([1.0, 1.0, 4.0, 9.0])
    bias, _ = remove_static_bias(one, True, (one.time_s[200], one.time_s[202]), "x")
    assert np.degrees(bias) == pytest.approx([0.0, 0.0, 2.0])


def test_a_slow_recording_may_miss_its_first_sample():
    time_s = np.arange(0.0, 10.0, 0.125)
    rate = np.zeros((len(time_s), 3))
    rate[0] = np.nan
    check_known_start(time_s, rate, "x")
    rate[1] = np.nan
    with pytest.raises(RecordingError, match=r"first 0\.25 s are missing"):
        check_known_start(time_s, rate, "x")


def test_a_known_start_rests_from_its_first_sample_on():
    """The sensor turns from 0.21 s on, 0.12 s after the first sample that is there."""
    one = recording(0.0, 0.0)
    rate = one.gyroscope_rad_s.copy()
    rate[21:, 1] = np.radians(60.0)
    check_known_start(one.time_s, rate, "x")
    rate[:9] = np.nan
    with pytest.raises(RecordingError, match="turns by"):
        check_known_start(one.time_s, rate, "x")


def test_a_known_start_may_tremble_but_not_turn_about_any_axis():
    one = recording(0.0, 0.0)
    rate = one.gyroscope_rad_s.copy()
    rate[:, 0] = np.radians(40.0) * np.where(np.arange(len(rate)) % 2, 1.0, -1.0)
    rate[:22] -= rate[:22].mean(axis=0)
    check_known_start(one.time_s, rate, "x")
    # together 26 deg/s
    with pytest.raises(RecordingError, match="turns by 26 deg/s"):
        check_known_start(one.time_s, np.full_like(rate, np.radians(15.0)), "x")


def test_the_begin_of_a_known_start_is_missing_whatever_is_missing_later():
    """A pause of 600 s makes the mean interval 0.2 s; and one axis is as bad as all."""
    one = recording(0.0, 0.0)
    time_s = one.time_s + np.where(np.arange(len(one.time_s)) > 1500, 600.0, 0.0)
    rate = one.gyroscope_rad_s.copy()
    rate[:12, 1] = np.nan
    with pytest.raises(RecordingError, match=r"first 0\.12 s are missing"):
        check_known_start(time_s, rate, "x")


def test_a_given_bias_is_limited_as_a_vector():
    given = np.radians([7.0, 0.0, 7.0])
    bias, note = remove_static_bias(recording(0.0, 0.0), True, None, "x", given)
    np.testing.assert_array_equal(bias, given)
    assert note == "static bias [7.0, 0.0, 7.0] deg/s from bias_rad_s removed"
    with pytest.raises(UserError, match="together below"):
        remove_static_bias(recording(0.0, 0.0), True, None, "x", np.radians([8.0, 0.0, 8.0]))


def test_missing_samples_of_a_part_declared_still_do_not_count():
    one = recording(2.0, 0.0)
    one.gyroscope_rad_s[300:350] = np.nan
    bias, _ = remove_static_bias(one, True, (2.0, 5.0), "x")
    assert np.degrees(bias) == pytest.approx([0.0, 2.0, 0.0], abs=1e-9)
