"""Findings noted about a recording, and those for which it is refused."""

import numpy as np
import pytest

from narx import SimulatedGait
from narx.errors import RecordingError
from narx.inference.findings import (
    check_consistency,
    doubtful_note,
    exchanged_note,
    gap_notes,
    start_up_note,
)
from narx.inference.pretrained import pretrained
from narx.inference.stream import Quality
from narx.recordings.trial import ImuRecording


def _check(gyroscope, accelerometer, is_leg=True):
    return check_consistency(gyroscope, accelerometer, 100.0, is_leg=is_leg, where="walk.csv")


@pytest.fixture(scope="module")
def fast_walk():
    """Return 30 s of a fast walk, without standing: the accelerations of a shank are large."""
    source = SimulatedGait(
        subjects=("S3",), conditions=("fast",), treadmill_duration_s=40.0, sampling_rate_hz=100.0
    )
    shank = next(iter(source)).imus["shank_right"]
    return shank.gyroscope_rad_s[600:3600], shank.accelerometer_m_s2[600:3600]


def test_a_good_walk_that_looks_reversed_is_noted_not_refused(fast_walk):
    (note,) = _check(*fast_walk)
    assert "turns the other way" in note
    assert "translated more than it is rotated" in note


def test_another_unit_is_refused_even_there(fast_walk):
    gyroscope, accelerometer = fast_walk
    with pytest.raises(RecordingError, match=r"walk.csv: .* times as fast"):
        _check(np.degrees(gyroscope), accelerometer)


def test_a_reversed_axis_of_a_sensor_that_only_turns_is_refused():
    time_s = np.arange(0.0, 40.0, 0.01)
    angle = 0.5 * np.sin(2 * np.pi * 0.8 * time_s)
    rate = np.random.default_rng(0).normal(0.0, 0.02, (len(time_s), 3))
    rate[:, 1] += 0.5 * 2 * np.pi * 0.8 * np.cos(2 * np.pi * 0.8 * time_s)
    force = 9.81 * np.column_stack([-np.sin(angle), 0 * angle, np.cos(angle)])
    assert _check(rate, force) == []
    with pytest.raises(RecordingError, match="turns the other way"):
        _check(-rate, force)
    # another segment may be translated without rotation
    (note,) = _check(-rate, force, is_leg=False)
    assert "turns the other way" in note


@pytest.mark.parametrize(("doubtful", "noted"), [(50, False), (51, True)])
def test_motion_unlike_a_leg_is_noted_if_it_is_most_of_the_recording(doubtful, noted):
    # the start-up does not count
    quality = np.repeat(
        [Quality.STARTING, Quality.DOUBTFUL, Quality.GOOD], [200, doubtful, 100 - doubtful]
    )
    notes = doubtful_note(quality.astype(np.int8))
    assert bool(notes) == noted
    assert not notes or notes[0].startswith("in 51 % of the samples the motion does not resemble")


@pytest.mark.parametrize(
    ("good", "doubtful", "said"),
    [
        (0, 0, "all angles are the start-up's"),
        (290, 0, "ran for 2.9 s; the angles have not settled"),
        (150, 149, "ran for 3 s; the angles have not settled"),
        (150, 150, None),
    ],
)
def test_three_seconds_of_the_network_are_enough(good, doubtful, said):
    quality = np.repeat(
        [Quality.STARTING, Quality.GOOD, Quality.DOUBTFUL, Quality.MISSING],
        [400, good, doubtful, 500],
    )
    notes = start_up_note(pretrained().method(), quality.astype(np.int8), 100.0)
    assert len(notes) == (said is not None)
    assert said is None or notes[0].endswith(said)


def test_a_recording_without_any_sample_has_no_start_up():
    missing = np.full(500, Quality.MISSING, dtype=np.int8)
    assert start_up_note(pretrained().method(), missing, 100.0) == []


def _knee(least_deg, most_deg):
    """A knee of which 90 % is at zero, with its first and its last percentiles."""
    angle = np.zeros(1000)
    angle[:50], angle[-50:] = least_deg, most_deg
    return np.radians(angle)


@pytest.mark.parametrize(
    ("ratio", "least_deg", "most_deg", "noted"),
    [
        (1.12, -26.0, 10.0, True),
        (1.08, -26.0, 10.0, False),  # the thigh is hardly faster
        (1.12, -24.0, 10.0, False),  # no further backwards than a knee may be measured
        (1.12, -40.0, 26.0, True),
        (1.12, -40.0, 28.0, False),  # nearly as far forwards
    ],
)
def test_a_thigh_faster_than_its_shank_and_a_knee_that_bends_backwards(
    ratio, least_deg, most_deg, noted
):
    shank = np.sin(np.arange(1000) / 10.0) + 0.5
    notes = exchanged_note(ratio * shank, shank, _knee(least_deg, most_deg))
    assert bool(notes) == noted
    if noted:
        assert "the thigh turns 1.1 times as fast as the shank" in notes[0]
        assert f"the knee bends {-least_deg:.0f} degrees backwards" in notes[0]


def test_without_a_knee_angle_nothing_is_exchanged():
    rate = np.ones(9)
    assert exchanged_note(2.0 * rate, rate, np.full(9, np.nan)) == []


def test_gaps_are_told_by_what_becomes_of_them():
    time_s = np.arange(0.0, 60.0, 0.01)
    rates = np.cos(2.0 * np.pi * time_s[:, None]) * np.ones(3)
    for begin, end in ((10.0, 10.05), (20.0, 20.5), (30.0, 30.4), (40.0, 42.0), (50.0, 53.0)):
        rates[(time_s > begin + 1e-6) & (time_s < end - 1e-6)] = np.nan
    one = ImuRecording("leg_right", time_s, rates, np.full_like(rates, np.nan))
    interpolated, filled, left = gap_notes(one, 1.1)
    assert interpolated == "1 gap of up to 0.05 s interpolated"
    assert filled == "2 gaps of up to 0.5 s filled from the rhythm of the recording"
    assert left.startswith("2 gaps longer than 1.1 s (together 5 s, the longest 3 s)")


def test_a_gap_that_cannot_be_filled_is_told_from_one_that_is_too_long():
    time_s = np.arange(0.0, 3.0, 0.01)
    rates = np.cos(2.0 * np.pi * time_s[:, None]) * np.ones(3)
    rates[100:150] = np.nan
    one = ImuRecording("leg_right", time_s, rates, np.full_like(rates, np.nan))
    (note,) = gap_notes(one, 1.1)
    assert note.startswith("1 gap in a recording too short to fill them")


def test_a_few_samples_do_not_hide_that_thigh_and_shank_are_exchanged():
    shank = np.sin(np.arange(1000) / 10.0) + 0.5
    thigh, knee = 1.2 * shank, _knee(-26.0, 10.0)
    shank[500], knee[500:505] = 3.0, np.radians(120.0)
    assert exchanged_note(thigh, shank, knee)


def test_the_longest_of_the_interpolated_gaps_is_told():
    time_s = np.arange(0.0, 60.0, 0.01)
    rates = np.cos(2.0 * np.pi * time_s[:, None]) * np.ones(3)
    rates[1000:1003] = rates[2000:2006] = rates[3000] = np.nan
    one = ImuRecording("leg_right", time_s, rates, np.full_like(rates, np.nan))
    assert gap_notes(one, 1.1) == ["3 gaps of up to 0.07 s interpolated"]
