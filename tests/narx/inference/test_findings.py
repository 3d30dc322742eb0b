"""Findings noted about a recording, and those for which it is refused."""

import numpy as np
import pytest

from narx import SimulatedGait
from narx.errors import RecordingError
from narx.inference.findings import check_consistency, doubtful_note
from narx.inference.stream import Quality


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
