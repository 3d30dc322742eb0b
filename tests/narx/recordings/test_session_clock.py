"""Sensors whose clocks are shifted by known times."""

from dataclasses import replace

import numpy as np
import pytest

from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import RecordingError, UserError
from narx.recordings.session_clock import clock_offsets_s
from narx.recordings.trial import ImuRecording


@pytest.fixture(scope="module")
def leg():
    source = SimulatedGait(subjects=["S1"], conditions=["normal"], treadmill_duration_s=40)
    trial = next(iter(source))
    return {segment: trial.imus[segment] for segment in ("thigh_right", "shank_right")}


def _shifted(leg, shift_s):
    shank = leg["shank_right"]
    return leg | {"shank_right": replace(shank, time_s=shank.time_s + shift_s)}


@pytest.mark.parametrize("shift_s", [0.0, 3.37, -2.0, 500.0])
def test_the_shift_is_found_in_the_movement(leg, shift_s):
    offsets, notes = clock_offsets_s(_shifted(leg, shift_s), "correlation", "s")
    assert offsets["thigh_right"] == 0.0
    assert offsets["shank_right"] == pytest.approx(-shift_s, abs=0.005)
    assert "the shocks of foot contacts" in notes[0]


@pytest.mark.parametrize("late_s", [0.004, 0.006])
def test_the_shift_is_found_between_the_samples_of_the_grid(leg, late_s):
    """Each sensor has a grid of 10 ms from its own beginning."""
    shank = leg["shank_right"]
    own = slice(round(late_s * shank.sampling_rate_hz), None)
    assert own.start > 0
    late = ImuRecording(
        "shank_right", shank.time_s[own], shank.gyroscope_rad_s[own], shank.accelerometer_m_s2[own]
    )
    offsets, _ = clock_offsets_s(leg | {"shank_right": late}, "correlation", "s")
    assert offsets["shank_right"] == pytest.approx(0.0, abs=0.004)


def test_overlapping_stamps_are_used_and_disagreement_is_reported(leg):
    offsets, notes = clock_offsets_s(leg, "auto", "s")
    assert set(offsets.values()) == {0.0}
    assert notes == ["sensors aligned by their time stamps"]
    shifted = _shifted(leg, 3.37)
    with pytest.raises(RecordingError, match=r"3\.37 s apart, but not by their time stamps"):
        clock_offsets_s(shifted, "auto", "s")
    offsets, notes = clock_offsets_s(shifted, "stamps", "s")
    assert set(offsets.values()) == {0.0}
    assert "3.37 s apart (align=correlation to use this)" in notes[1]


def test_a_steady_walk_some_strides_apart_is_not_certain(leg):
    rate_hz = leg["thigh_right"].sampling_rate_hz
    walking = {
        segment: replace(
            imu,
            time_s=imu.time_s[round(8 * rate_hz) :],
            gyroscope_rad_s=imu.gyroscope_rad_s[round(8 * rate_hz) :],
            accelerometer_m_s2=imu.accelerometer_m_s2[round(8 * rate_hz) :],
        )
        for segment, imu in leg.items()
    }
    offsets, _ = clock_offsets_s(_shifted(walking, 2.2), "auto", "s")
    assert set(offsets.values()) == {0.0}


def test_stamps_without_overlap_are_not_used(leg):
    offsets, _ = clock_offsets_s(_shifted(leg, 1e5), "auto", "s")
    assert offsets["shank_right"] == pytest.approx(-1e5, abs=0.005)


def test_an_event_in_all_sensors_aligns_them(leg):
    shifted = _shifted(leg, 3.37)
    event = {"thigh_right": 5.0, "shank_right": 8.37}
    offsets, notes = clock_offsets_s(shifted, event, "s")
    assert offsets == pytest.approx({"thigh_right": 0.0, "shank_right": -3.37})
    assert notes == ["sensors aligned by the given event: 'shank_right' moved by -3.370 s"]
    _, notes = clock_offsets_s(shifted, event | {"shank_right": 5.0}, "s")
    assert "3.37 s apart" in notes[1]


@pytest.mark.parametrize(
    ("event", "says"),
    [
        (
            {"thigh_right": 5.0},
            "for thigh_right, expected one for each of shank_right, thigh_right",
        ),
        (
            {"thigh_right": 5.0, "shank_right": 1e4},
            "s: align.shank_right is 10000, expected a",
        ),
        ({"thigh_right": float("nan"), "shank_right": 1.0}, "align.thigh_right is nan"),
    ],
)
def test_an_event_outside_a_recording_is_refused(leg, event, says):
    with pytest.raises(UserError, match=says):
        clock_offsets_s(leg, event, "s")


def test_what_cannot_be_aligned_is_refused(leg):
    rng = np.random.default_rng(0)
    noise = ImuRecording("shank_right", leg["thigh_right"].time_s,
                         rng.normal(0, 1e-3, (len(leg["thigh_right"].time_s), 3)),
                         np.full((len(leg["thigh_right"].time_s), 3), np.nan))  # fmt: skip
    with pytest.raises(RecordingError, match=r"^s: 'thigh_right' and 'shank_right' do not move"):
        clock_offsets_s(leg | {"shank_right": noise}, "correlation", "s")
    with pytest.raises(UserError, match="align is 'magic', expected one of auto, stamps"):
        clock_offsets_s(leg, "magic", "s")


@pytest.mark.parametrize(
    ("begin_s", "end_s", "by_stamps"),
    [
        (10.0, 25.0, True),  # within the other one
        (12.0, 52.0, True),  # 28 of 40 s together
        (25.0, 65.0, False),  # 15 of 40 s
    ],
)
def test_stamps_are_used_where_half_of_the_shorter_recording_overlaps(begin_s, end_s, by_stamps):
    """Sensors at rest cannot be aligned in any other way."""
    recordings = {}
    for name, times in (("thigh", (0.0, 40.0)), ("shank", (begin_s, end_s))):
        time_s = np.arange(*times, 0.01)
        still = np.zeros((len(time_s), 3))
        recordings[name] = ImuRecording(name, time_s, still, still)
    if by_stamps:
        offsets, notes = clock_offsets_s(recordings, "auto", "s")
        assert offsets == {"thigh": 0.0, "shank": 0.0}
        assert notes == ["sensors aligned by their time stamps"]
        return
    with pytest.raises(RecordingError, match="do not move together"):
        clock_offsets_s(recordings, "auto", "s")


def test_shocks_of_opposite_sign_are_of_the_same_step():
    """One sensor is pushed down where the other is pulled up, 3.2 s later on its own clock."""
    rng = np.random.default_rng(1)
    time_s = np.arange(0.0, 40.0, 0.005)
    steps_s = np.arange(5.0, 35.0, 0.55) + rng.normal(0.0, 0.03, 55)
    shocks = sum(np.exp(-(((time_s - at) / 0.01) ** 2)) for at in steps_s)
    speed = np.where((time_s > 5) & (time_s < 35), 2.0 + np.sin(0.7 * time_s), 0.0)
    recordings = {}
    for name, sign, shift_s in (("thigh", 1.0, 0.0), ("shank", -1.0, 3.2)):
        force = 9.81 + 6.0 * sign * shocks
        rates, forces = np.outer(speed, [0.0, 1.0, 0.0]), np.outer(force, [0.0, 0.0, 1.0])
        recordings[name] = ImuRecording(name, time_s + shift_s, rates, forces)
    offsets, notes = clock_offsets_s(recordings, "correlation", "s")
    assert offsets["shank"] == pytest.approx(-3.2, abs=0.005)
    assert "the shocks of foot contacts" in notes[0]
