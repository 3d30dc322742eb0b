"""Clock offset and mounting, recovered from motions whose truth is known."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from narx.errors import RecordingError
from narx.recordings.clock_alignment import (
    _MeanRates,
    estimate_clock_offset,
    estimate_heading_misalignment,
    estimate_misalignment,
)

_RATE_HZ = 1000.0


def _motion(seed=0, duration_s=20.0, mean_rad_s=0.0):
    """Orientation (fine clock) and exact body rates of a smooth random motion."""
    rng = np.random.default_rng(seed)
    knots = np.arange(0.0, duration_s + 1.0, 0.15)
    rate = CubicSpline(knots, mean_rad_s + rng.normal(scale=1.5, size=(len(knots), 3)))
    time = np.arange(0.0, duration_s, 1.0 / _RATE_HZ)
    steps = Rotation.from_rotvec(rate(time + 0.5 / _RATE_HZ) / _RATE_HZ)
    orientation = [Rotation.identity()]
    for step in steps[:-1]:
        orientation.append(orientation[-1] * step)
    return time, Rotation.concatenate(orientation), rate


@pytest.fixture(scope="module")
def motion():
    return _motion()


def _optical(motion, rate_hz):
    time, orientation, _ = motion
    every = round(_RATE_HZ / rate_hz)
    return time[::every], orientation[::every].as_quat(scalar_first=True)


@pytest.mark.parametrize("offset_s", [0.0, 0.0137, -0.1234])
def test_sub_sample_clock_offset_is_recovered(motion, offset_s):
    imu_time = np.arange(0.5, 19.0, 1 / 94.0)
    gyroscope = motion[2](imu_time - offset_s)
    optical_time, quaternion = _optical(motion, 62.5)
    found, correlation = estimate_clock_offset(imu_time, gyroscope, optical_time, quaternion)
    assert found == pytest.approx(offset_s, abs=2e-4)
    assert correlation > 0.999


def test_offset_survives_mounting_noise_and_gaps(motion):
    rng = np.random.default_rng(3)
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    mounting = Rotation.random(random_state=4)
    gyroscope = mounting.apply(motion[2](imu_time - 0.021))
    gyroscope += rng.normal(scale=0.05, size=gyroscope.shape)
    gyroscope[400:460] = np.nan
    optical_time, quaternion = _optical(motion, 62.5)
    quaternion[300:420] = np.nan
    found, _ = estimate_clock_offset(imu_time, gyroscope, optical_time, quaternion)
    assert found == pytest.approx(0.021, abs=1e-3)


def test_offset_survives_a_reference_that_jumps(motion):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    optical_time, quaternion = _optical(motion, 62.5)
    flipped = np.random.default_rng(5).integers(0, len(quaternion), 40)
    turned = Rotation.from_quat(quaternion[flipped], scalar_first=True)
    turned *= Rotation.from_euler("x", 180, degrees=True)
    quaternion[flipped] = turned.as_quat(scalar_first=True)
    found, correlation = estimate_clock_offset(
        imu_time, motion[2](imu_time - 0.021), optical_time, quaternion
    )
    assert found == pytest.approx(0.021, abs=1e-3)
    assert correlation > 0.95


def test_mounting_and_bias_are_recovered_despite_tracking_faults(motion):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    mounting = Rotation.random(random_state=5)
    bias = np.array([0.05, -0.02, 0.01])
    gyroscope = mounting.apply(motion[2](imu_time - 0.0081)) + bias
    optical_time, quaternion = _optical(motion, 62.5)
    quaternion[::100] = Rotation.random(len(quaternion[::100]), random_state=6).as_quat()
    found = estimate_misalignment(imu_time, gyroscope, optical_time, quaternion, offset_s=0.0081)
    assert np.degrees((found.body_to_sensor * mounting.inv()).magnitude()) < 0.1
    assert found.rate_offset_rad_s == pytest.approx(bias, abs=2e-3)
    assert 0.9 < found.inlier_share < 0.99
    assert found.residual_rad_s < 0.05


def test_scale_and_share_explained_are_those_of_a_regression(motion):
    """A gyroscope with a scale of 0.8 and a bias, a sixth of whose power is of another motion."""
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    rates, other = motion[2](imu_time), _motion(seed=9)[2](imu_time)
    other -= rates * np.sum(rates * other) / np.sum(rates**2)
    gyroscope = 0.8 * rates + 0.36 * other + [1.0, -2.0, 0.5]
    found = estimate_misalignment(imu_time, gyroscope, *_optical(motion, 62.5))
    centred = [(values - values.mean(axis=0)).ravel() for values in (gyroscope, rates)]
    assert found.slope == pytest.approx(0.8, abs=0.03)
    assert found.explained == pytest.approx(np.corrcoef(*centred)[0, 1] ** 2, abs=0.03)
    assert 0.75 < found.explained < 0.92
    assert found.explained_mirrored < 0.7


def test_heading_misalignment_is_recovered(motion):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    turned = Rotation.from_euler("Z", 0.31).apply(motion[2](imu_time))
    optical_time, quaternion = _optical(motion, 100.0)
    angle = estimate_heading_misalignment(imu_time, turned, optical_time, quaternion)
    assert angle == pytest.approx(0.31, abs=2e-3)


def test_motions_that_do_not_belong_together_are_refused(motion):
    imu_time = np.arange(0.0, 19.0, 1 / 100.0)
    optical_time, quaternion = _optical(motion, 62.5)
    with pytest.raises(RecordingError, match="no offset within"):
        estimate_clock_offset(imu_time, np.ones((len(imu_time), 3)), optical_time, quaternion)
    with pytest.raises(RecordingError, match="too few gyroscope samples"):
        estimate_clock_offset([0.0], np.zeros((1, 3)), optical_time, quaternion)
    with pytest.raises(RecordingError, match="intervals of the reference"):
        estimate_clock_offset(
            imu_time, motion[2](imu_time), optical_time, np.full_like(quaternion, np.nan)
        )


def test_the_spline_is_not_used_across_gaps(motion):
    """Between two distant samples a spline swings; such intervals must not be compared."""
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    kept = np.ones(len(imu_time), dtype=bool)
    for begin in range(50, 1800, 100):
        kept[begin : begin + 30] = False
    gyroscope = motion[2](imu_time)
    gyroscope[~kept] = np.nan
    optical_time, quaternion = _optical(motion, 62.5)
    found, correlation = estimate_clock_offset(imu_time, gyroscope, optical_time, quaternion)
    assert found == pytest.approx(0.0, abs=2e-4)
    assert correlation > 0.9999
    fit = estimate_misalignment(imu_time, gyroscope, optical_time, quaternion)
    assert fit.residual_rad_s < 0.01
    assert fit.inlier_share > 0.97


def test_an_interval_in_which_a_frame_is_lost_does_not_count(motion):
    """Every third frame is followed by a lost one: of three intervals two are left."""
    imu_time = np.arange(0.0, 2.0, 1 / 100.0)
    optical_time, quaternion = _optical(motion, 62.5)
    rows = [4 * k + j for k in range(9) for j in range(3)]
    with pytest.raises(RecordingError, match="only 18 intervals"):
        estimate_clock_offset(imu_time, motion[2](imu_time), optical_time[rows], quaternion[rows])


def test_the_residual_is_a_root_mean_square_per_axis(motion):
    """An error of 0.1 rad/s on one axis of three is 0.1 / sqrt(3) per axis."""
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    error = 0.1 * np.sign(np.sin(np.pi * imu_time))
    optical_time, quaternion = _optical(motion, 100.0)
    fit = estimate_misalignment(
        imu_time, motion[2](imu_time) + np.outer(error, [1, 0, 0]), optical_time, quaternion
    )
    assert fit.residual_rad_s == pytest.approx(0.1 / np.sqrt(3), rel=0.05)


def test_a_part_with_another_rate_is_left_out(motion):
    """A twentieth of the samples is off by 1.5 rad/s, thirty times the noise."""
    noise = np.random.default_rng(1).normal(scale=0.05, size=(1850, 3))
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    wrong = imu_time % 2.0 < 0.1
    optical_time, quaternion = _optical(motion, 100.0)
    gyroscope = motion[2](imu_time) + noise + 1.5 * wrong[:, None]
    fit = estimate_misalignment(imu_time, gyroscope, optical_time, quaternion)
    # with them the offset is 0.075 rad/s
    assert np.abs(fit.rate_offset_rad_s).max() < 0.02
    assert fit.inlier_share == pytest.approx(0.95, abs=0.02)


def test_the_residual_is_per_axis(motion):
    noise = np.random.default_rng(0).normal(size=(1850, 3))
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    optical_time, quaternion = _optical(motion, 100.0)
    fit = estimate_misalignment(
        imu_time, motion[2](imu_time) + 0.1 * noise, optical_time, quaternion, interval_s=0.01
    )
    # spline smoothing and averaging between samples leave about two thirds of the noise
    assert 0.05 < fit.residual_rad_s < 0.1
    assert fit.inlier_share == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(("noise_rad_s", "refused"), [(1.3, False), (2.5, True)])
def test_speeds_that_correlate_by_half_belong_together(motion, noise_rad_s, refused):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    noise = np.random.default_rng(8).normal(scale=noise_rad_s, size=(len(imu_time), 3))
    gyroscope = motion[2](imu_time - 0.05) + noise
    if refused:
        with pytest.raises(RecordingError, match="no offset within"):
            estimate_clock_offset(imu_time, gyroscope, *_optical(motion, 62.5))
        return
    found, correlation = estimate_clock_offset(imu_time, gyroscope, *_optical(motion, 62.5))
    assert found == pytest.approx(0.05, abs=0.005)
    assert 0.55 < correlation < 0.85


@pytest.mark.parametrize("mirror", [np.diag([1.0, -1.0, 1.0]), np.eye(3)[[1, 0, 2]]])
def test_a_mirrored_or_exchanged_axis_is_explained_by_a_reflection(motion, mirror):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    optical_time, quaternion = _optical(motion, 100.0)
    fit = estimate_misalignment(imu_time, motion[2](imu_time) @ mirror, optical_time, quaternion)
    assert fit.explained_mirrored == pytest.approx(1.0, abs=1e-3)
    assert fit.explained < 0.5
    straight = estimate_misalignment(imu_time, motion[2](imu_time), optical_time, quaternion)
    assert straight.explained == pytest.approx(1.0, abs=1e-3)
    # a reflection of the axis with the least variance has the wrong sign there alone
    least, *more = np.linalg.eigvalsh(np.cov(motion[2](imu_time).T))
    share = (sum(more) - least) / (sum(more) + least)
    assert straight.explained_mirrored == pytest.approx(share**2, abs=0.02)


def test_an_offset_at_the_end_of_the_range_may_lie_beyond_it(motion):
    imu_time = np.arange(0.5, 19.0, 1 / 100.0)
    gyroscope = motion[2](imu_time - 0.055)
    with pytest.raises(RecordingError, match=r"within 0\.05 s .* 1\.00 at 0\.050 s"):
        estimate_clock_offset(imu_time, gyroscope, *_optical(motion, 62.5), max_offset_s=0.05)


def test_a_bias_does_not_turn_the_frame_of_a_body_that_turns_on_and_on():
    turning = _motion(duration_s=8.0, mean_rad_s=[0.7, -0.4, 0.9])
    optical = _optical(turning, 100.0)
    imu_time = np.arange(0.5, 7.5, 1 / 100.0)
    bias = [1.0, -2.0, 0.5]
    mounting = Rotation.random(random_state=6)
    found = estimate_misalignment(imu_time, mounting.apply(turning[2](imu_time)) + bias, *optical)
    assert np.degrees((found.body_to_sensor * mounting.inv()).magnitude()) < 0.1
    assert found.rate_offset_rad_s == pytest.approx(bias, abs=2e-3)
    turned = Rotation.from_euler("Z", 0.31).apply(turning[2](imu_time)) + bias
    angle = estimate_heading_misalignment(imu_time, turned, *optical)
    assert angle == pytest.approx(0.31, abs=2e-3)


def test_intervals_up_to_a_gap_count_and_those_across_it_do_not():
    """On one clock of 60 samples without ten: 19 and 29 intervals are left."""
    time_s = np.arange(60) / 10.0
    rates = np.zeros((60, 3))
    rates[20:30] = np.nan
    still = np.tile([1.0, 0.0, 0.0, 0.0], (60, 1))
    sensor, body = _MeanRates(time_s, rates, time_s, still, 0.1).at(0.0)
    assert len(sensor) == len(body) == 48
