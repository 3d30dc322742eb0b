"""A walk put together from pattern and timing: impacts, travel, variation and sway."""

from dataclasses import replace

import numpy as np
import pytest

from narx.simulation.body import TABLE_1
from narx.simulation.gait_timing import overground_timing, treadmill_timing
from narx.simulation.walker import walking_pattern
from narx.simulation.walking import VARIATION_CHANNELS, postural_sway, walk

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
        expected = [0.8 * (joint == "hip_right"), 0.0, 0.0]
        np.testing.assert_allclose(added, np.tile(expected, (len(added), 1)), atol=1e-9)


def test_without_variation_the_joints_follow_the_pattern(pattern):
    timing = _treadmill(pattern)
    still = type(timing.strides)(timing.strides.t, 0.0 * timing.strides.c, timing.strides.k)
    motion = _walk(pattern, replace(timing, strides=still), 14.0, False, 200.0)
    late = motion.time_s > 8.0
    expected = pattern.joint_angles(timing.phase_of_time(motion.time_s))
    for joint, sway in postural_sway(np.random.default_rng(1), motion.time_s).items():
        found = motion.joint_angles[joint] - sway
        np.testing.assert_allclose(found[late], expected[joint][late], atol=1e-12)


def test_the_size_of_a_movement_varies_about_its_mean(pattern):
    """A variation of one makes the movement larger by 3 % and leaves its mean."""
    timing = _treadmill(pattern)
    spline = timing.strides
    larger = 0.0 * spline.c
    plain = replace(timing, strides=type(spline)(spline.t, larger.copy(), spline.k))
    larger[:, 6] = 1.0  # size of the flexion of the right hip
    varied = replace(timing, strides=type(spline)(spline.t, larger, spline.k))
    one, other = (_walk(pattern, each, 14.0, False, 200.0) for each in (plain, varied))
    late = one.time_s > 8.0
    for joint in one.joint_angles:
        added = (other.joint_angles[joint] - one.joint_angles[joint])[late]
        expected = np.zeros_like(added)
        if joint == "hip_right":
            steady = pattern.joint_angles(timing.phase_of_time(one.time_s))[joint][late, 0]
            expected[:, 0] = 0.03 * (steady - pattern.curves[joint][0, 0].real)
        np.testing.assert_allclose(added, expected, atol=1e-12)


def test_a_leg_varies_with_its_own_strides(pattern):
    """A mean that grows with the phase: that of the left leg is behind by the legs' lag."""
    timing = _treadmill(pattern)
    spline = timing.strides
    knots, k = spline.t, spline.k
    line = np.array([knots[n + 1 : n + k + 1].mean() for n in range(len(spline.c))])
    rising = 0.0 * spline.c
    plain = replace(timing, strides=type(spline)(knots, rising.copy(), k))
    for channel in (1, 3):  # hips
        rising[:, 6 * channel + 3] = line
    both = replace(timing, strides=type(spline)(knots, rising, k))
    one, other = (_walk(pattern, each, 14.0, False, 200.0) for each in (plain, both))
    late = one.time_s > 8.0
    right, left = (
        np.degrees(other.joint_angles[f"hip_{side}"] - one.joint_angles[f"hip_{side}"])[late, 0]
        for side in ("right", "left")
    )
    np.testing.assert_allclose(right - left, 0.8 * pattern.left_lag, atol=1e-9)


def test_first_steps_hit_less_hard(pattern):
    """The belt takes four seconds to full speed, and so does the shock."""
    timing = _treadmill(pattern)
    motion = _walk(pattern, timing, 20.0, travels=False)
    for strike in timing.events["heel_strike_right"][:3]:
        after = (motion.time_s > strike) & (motion.time_s < strike + 0.2)
        height = motion.impact_m["shank_right"][after, 2]
        late = timing.events["heel_strike_right"][-2]
        steady = (motion.time_s > late) & (motion.time_s < late + 0.2)
        largest = motion.impact_m["shank_right"][steady, 2].max()
        # x^4 exp(-x) is largest at x = 4
        size = timing.size(np.array([strike + 0.04]))[0]
        assert height.max() / largest == pytest.approx(size, rel=0.05)


def test_a_runner_stands_still_then_bounces_and_travels():
    runner = walking_pattern("S2", BODY, 2.5, 0, runs=True)
    timing = _treadmill(runner)
    motion = _walk(runner, timing, 12.0, True, 500.0)
    path = motion.pelvis_m
    standing = motion.time_s < 2.0
    assert np.ptp(path[standing], axis=0).max() < 1e-12
    late = motion.time_s > 8.0
    speed = np.gradient(path[late, 0], motion.time_s[late])
    np.testing.assert_allclose(speed, 2.5, atol=1e-6)
    # a rise and fall by 8 cm, and none to the sides
    assert np.ptp(path[late, 2]) == pytest.approx(0.08, abs=0.001)
    assert np.ptp(path[:, 1]) == 0.0


def test_sway_has_its_size_and_is_slow():
    """A quarter of a degree below half a hertz."""
    rng = np.random.default_rng(2)
    sway = postural_sway(rng, np.arange(0.0, 600.0, 0.1))
    assert np.degrees([np.std(angles) for angles in sway.values()]) == pytest.approx(0.25, rel=0.15)
    power = np.abs(np.fft.rfft(sway["hip_left"], axis=0)) ** 2
    assert power[np.fft.rfftfreq(6000, 0.1) > 0.8].sum() < 0.05 * power.sum()
