"""A walk put together from pattern and timing: impacts, travel, variation and sway."""

from dataclasses import replace

import numpy as np
import pytest

from narx.simulation.body import TABLE_1
from narx.simulation.gait_timing import OFFSET_SD_DEG, overground_timing, treadmill_timing
from narx.simulation.walker import walking_pattern
from narx.simulation.walking import SWAY_SD_DEG, VARIATION_CHANNELS, postural_sway, walk

BODY, RATE_HZ = TABLE_1["S2"], 2000.0


@pytest.fixture(scope="module")
def pattern():
    return walking_pattern("S2", BODY, 0.9, 0)


def _treadmill(pattern, duration_s=20.0):
    rng = np.random.default_rng(0)
    feet = pattern.stride_s, pattern.toe_off, pattern.left_lag
    return treadmill_timing(rng, *feet, 2.0, 4.0, duration_s, VARIATION_CHANNELS)


def _walk(pattern, timing, duration_s, travels, rate_hz=RATE_HZ):
    time_s = np.arange(0.0, duration_s, 1.0 / rate_hz)
    return walk(pattern, timing, BODY, time_s, rate_hz, np.random.default_rng(1), travels)


def test_the_shank_is_hit_after_each_heel_strike_and_the_thigh_less(pattern):
    """Largest acceleration: 10 m/s^2 per m/s of speed at the shank, 0.4 of it at the thigh."""
    timing = _treadmill(pattern)
    motion = _walk(pattern, timing, 20.0, travels=False)
    strikes = timing.events["heel_strike_left"]
    strikes = strikes[strikes > 8.0][:3]
    for segment, share in (("shank_left", 1.0), ("thigh_left", 0.4)):
        height = motion.impact_m[segment][:, 2]
        acceleration = np.gradient(np.gradient(height, 1.0 / RATE_HZ), 1.0 / RATE_HZ)
        for strike in strikes:
            before = (motion.time_s > strike - 0.2) & (motion.time_s < strike)
            after = (motion.time_s > strike) & (motion.time_s < strike + 0.2)
            assert np.abs(height[before]).max() < 1e-9
            assert acceleration[after].max() == pytest.approx(share * 10.0 * 0.9, rel=0.02)
    # the pelvis is hit by both legs
    both = motion.impact_m["shank_left"] + motion.impact_m["shank_right"]
    np.testing.assert_allclose(motion.impact_m["pelvis"], 0.2 * both)


def test_over_ground_the_body_travels_and_on_a_treadmill_it_stays(pattern):
    feet = pattern.stride_s, pattern.toe_off, pattern.left_lag
    rng = np.random.default_rng(0)
    timing = overground_timing(rng, *feet, 2.0, 20, 2.0, VARIATION_CHANNELS)
    path = _walk(pattern, timing, timing.end_s + 2.0, True, 500.0).pelvis_m
    # less than speed times duration, as the first and the last step are shorter
    assert path[-1, 0] - path[0, 0] == pytest.approx(0.9 * 10.0 * pattern.stride_s, rel=0.12)
    assert np.ptp(path[:, 1]) < 0.2
    stays = _walk(pattern, _treadmill(pattern), 20.0, False, 500.0)
    strides = stays.pelvis_m[round(10.0 * 500) : round((10.0 + 4.0 * pattern.stride_s) * 500)]
    assert (np.ptp(strides, axis=0) < [0.12, 0.12, 0.08]).all()
    assert np.ptp(strides[:, 2]) > 0.01


def test_the_mean_of_a_joint_varies_from_stride_to_stride_by_its_share(pattern):
    """A variation of one adds its standard deviation to the mean, and is not of the size."""
    timing = _treadmill(pattern)
    spline = timing.strides
    constant = spline.c.copy()
    constant[:] = 0.0
    plain = replace(timing, strides=type(spline)(spline.t, constant.copy(), spline.k))
    constant[:, 6 + 3] = 1.0  # mean of the flexion of the right hip
    raised = replace(timing, strides=type(spline)(spline.t, constant, spline.k))
    one, other = (_walk(pattern, each, 14.0, False, 200.0) for each in (plain, raised))
    late = one.time_s > 8.0
    for joint in one.joint_angles:
        added = np.degrees(other.joint_angles[joint] - one.joint_angles[joint])[late]
        expected = [OFFSET_SD_DEG * (joint == "hip_right"), 0.0, 0.0]
        np.testing.assert_allclose(added, np.tile(expected, (len(added), 1)), atol=1e-9)


def test_sway_has_its_size():
    rng = np.random.default_rng(2)
    sway = postural_sway(rng, np.arange(0.0, 600.0, 0.1))
    assert np.degrees([np.std(angles) for angles in sway.values()]) == pytest.approx(
        SWAY_SD_DEG, rel=0.15
    )
