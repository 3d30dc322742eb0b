"""Axes taken as the segment's are compared with the axis about which the leg swings."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets.neura_sample import NeuraSample
from narx.errors import RecordingError
from narx.inference.mounting import _periodicity, mounting_note


def _note(rate, sampling_rate_hz=50.0, has_accelerometer=False, is_assumed=True):
    return mounting_note(
        rate,
        sampling_rate_hz,
        has_accelerometer=has_accelerometer,
        is_assumed=is_assumed,
        where="walk.csv",
    )


def _turned(walk, sequence, degrees):
    return Rotation.from_euler(sequence, degrees, degrees=True).apply(walk.gyroscope_rad_s)


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 30.0)


@pytest.mark.parametrize("degrees", [0.0, 20.0, -20.0])
def test_the_segments_axes_are_accepted(walk, degrees):
    assert _note(_turned(walk, "z", degrees)) == []


def test_another_axis_is_refused_if_the_frame_was_assumed(walk):
    rate = _turned(walk, "zx", [100.0, 30.0])
    with pytest.raises(RecordingError, match=r"^walk.csv: the leg swings about \(.*an acceler"):
        _note(rate)
    (note,) = _note(rate, is_assumed=False)
    axis = np.array(re.search(r"about \((.*)\), expected", note)[1].split(", "), dtype=float)
    left = Rotation.from_euler("zx", [100.0, 30.0], degrees=True).apply([0.0, 1.0, 0.0])
    # the walk's principal axis is a few degrees off
    assert axis @ left > np.cos(np.radians(15.0))
    (note,) = _note(rate, has_accelerometer=True, is_assumed=False)
    assert "Give frame=walking" in note


def test_a_smaller_deviation_is_noted(walk):
    (note,) = _note(_turned(walk, "z", 50.0))
    assert "is the sensor mounted otherwise" in note
    # more than 55 degrees out of the plane of y and z
    with pytest.raises(RecordingError, match="is the sensor mounted otherwise"):
        _note(_turned(walk, "z", 66.0))


@pytest.mark.parametrize(("degrees", "found"), [(60.0, "nothing"), (65.0, "a note"), (75.0, "no")])
def test_the_axis_may_turn_further_within_the_plane_of_y_and_z(walk, degrees, found):
    rate = _turned(walk, "x", degrees)
    if found == "no":
        with pytest.raises(RecordingError, match="is the sensor mounted otherwise"):
            _note(rate)
        return
    assert bool(_note(rate)) == (found == "a note")


@pytest.mark.parametrize(
    ("share", "rms_deg_s", "found"),
    [(0.55, 90.0, "nothing"), (0.65, 90.0, "a note"), (0.75, 90.0, "no"), (0.75, 29.0, "no"),
     (0.75, 21.0, "nothing")],
)  # fmt: skip
def test_only_a_dominant_axis_of_a_fast_swing_is_judged(share, rms_deg_s, found):
    """A swing about x, with harmonics of it about y and z."""
    phase = 2.0 * np.pi * 0.9 * np.arange(2000)[:, None] / 50.0
    size = np.sqrt([share, 0.5 * (1.0 - share), 0.5 * (1.0 - share)])
    rate = np.radians(rms_deg_s) * np.sqrt(2.0) * size * np.sin(phase * [1, 2, 3])
    if found == "no":
        with pytest.raises(RecordingError, match="is the sensor mounted otherwise"):
            _note(rate)
        return
    assert bool(_note(rate)) == (found == "a note")


def _swing_about_x(n_samples, share=1.0):
    """A swing mostly about x, and noise that takes the rest of its power."""
    phase = 2.0 * np.pi * 0.9 * np.arange(n_samples)[:, None] / 50.0
    swing = np.sqrt(2.0) * np.sin(phase * [1, 2, 3])
    noise = np.random.default_rng(0).normal(size=swing.shape)
    both = np.sqrt(share) * swing + np.sqrt(1.0 - share) * noise
    return np.radians(90.0) * np.sqrt([0.8, 0.1, 0.1]) * both


@pytest.mark.parametrize(("n_samples", "judged"), [(245, False), (255, True)])
def test_five_seconds_of_walking_are_judged(n_samples, judged):
    assert bool(_note(_swing_about_x(n_samples), is_assumed=False)) == judged


# a periodicity of 0.23 and of 0.39; the recorded walks begin at 0.33
@pytest.mark.parametrize(("share", "judged"), [(0.1, False), (0.2, True)])
def test_only_a_periodic_swing_is_judged(share, judged):
    assert bool(_note(_swing_about_x(2000, share), is_assumed=False)) == judged


@pytest.mark.parametrize(("period_s", "periodicity"), [(2.4, 1.0), (2.6, 0.0)])
def test_strides_last_up_to_two_and_a_half_seconds(period_s, periodicity):
    pulse = np.zeros(round(50.0 * period_s))
    pulse[:3] = [1.0, 2.0, 1.0]
    assert _periodicity(np.tile(pulse, 6), 50.0) == pytest.approx(periodicity, abs=1e-9)


def test_a_reversed_axis_is_noted(walk):
    (note,) = _note(_turned(walk, "z", 180.0))
    assert "as if y pointed to the right" in note


def test_movements_other_than_walking_are_not_judged(walk):
    generator = np.random.default_rng(0)
    assert _note(np.zeros((1500, 3))) == []
    assert _note(np.full((1500, 3), np.nan)) == []
    assert _note(generator.normal(0.0, 2.0, (1500, 3)) * [1.0, 0.2, 0.2]) == []
    assert _note(_turned(walk, "z", 90.0)[:200]) == []


def test_the_sensors_of_a_recorded_walk(data_root):
    """Thighs turn about z nearly as much as they swing: that is no other mounting."""
    (trial,) = NeuraSample(root=data_root / "neura_sample")
    for segment, found in calibrate(trial, "walking").items():
        rate = found.sensor_to_anatomical.apply(trial.imus[segment].gyroscope_rad_s)
        assert _note(rate, trial.sampling_rate_hz) == []
        (note,) = _note(rate[:, [1, 0, 2]] * [1, 1, -1], trial.sampling_rate_hz, is_assumed=False)
        assert "expected y" in note
        (note,) = _note(rate * [-1, -1, 1], trial.sampling_rate_hz)
        assert "as if y pointed to the right" in note


@pytest.mark.parametrize("n_strides", [2, 3, 7])
def test_a_periodic_rate_has_a_periodicity_of_one(n_strides):
    """Also if few strides overlap, and most of the energy is in a few samples."""
    stride = np.zeros(50)
    stride[[0, 1, 24, 49]] = [3.0, -2.0, 1.0, 5.0]
    assert _periodicity(np.tile(stride, n_strides), 50.0) == pytest.approx(1.0, abs=1e-12)


def test_a_walk_of_eight_seconds_amid_rest_is_judged():
    """At 27 deg/s: of a mean over 2 s, more than 25 deg/s over 6.5 s of it."""
    swing = _swing_about_x(400)
    swing *= np.radians(27.0) / np.sqrt((swing**2).sum(axis=1).mean())
    rest = np.zeros((500, 3))
    (note,) = _note(np.vstack([rest, swing, rest]), is_assumed=False)
    assert "the leg swings about" in note


def test_the_shortest_stride_lasts_six_tenths_of_a_second():
    pulse = np.zeros(35)
    pulse[:3] = [1.0, 2.0, 1.0]
    assert _periodicity(np.tile(pulse, 2), 50.0) == pytest.approx(1.0, abs=1e-9)
    # correlated over 0.5 s and no longer
    slow = np.convolve(np.random.default_rng(0).normal(size=4000), np.ones(25), "valid")
    assert _periodicity(slow, 50.0) < 0.2


@pytest.mark.parametrize("largest", [0, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_axis_of_unknown_direction_is_told_by_its_largest_part(largest, sign):
    axis = np.full(3, -0.2)
    axis[largest] = 1.0
    swing = np.sin(2.0 * np.pi * 0.9 * np.arange(2000) / 50.0)
    (note,) = _note(2.0 * np.outer(swing, sign * axis), is_assumed=False)
    told = [float(one) for one in re.search(r"about \((.*)\), expected", note)[1].split(", ")]
    assert told == pytest.approx(axis / np.linalg.norm(axis), abs=0.01)


def test_a_swing_that_is_as_fast_forward_as_backward_is_not_reversed():
    swing = np.sin(2.0 * np.pi * 0.9 * np.arange(2000) / 50.0)
    assert _note(2.0 * np.outer(swing, [0.0, 1.0, 0.0])) == []
