"""Walking over a whole trial: segment motion from pattern and timing."""

import dataclasses

import numpy as np
from scipy.ndimage import uniform_filter1d

from narx.simulation.body import Body
from narx.simulation.calculus import integral
from narx.simulation.gait_timing import OFFSET_SD_DEG, SIZE_CV, GaitTiming
from narx.simulation.random_numbers import smooth_noise
from narx.simulation.running import bounce_m
from narx.simulation.skeleton import SIDES, SkeletonMotion, forward_velocity, move
from narx.simulation.walker import JOINTS, WalkingPattern
from narx.types import FloatArray

# channels of stride-to-stride variation: size and mean of each joint's three angles
VARIATION_CHANNELS = 2 * 3 * len(JOINTS)

# postural sway, standard deviation in deg and bandwidth (ankle strategy: quiet standing sways by
# a few tenths of a degree below 1 Hz, Winter et al., J Neurophysiol 80:1211, 1998)
SWAY_SD_DEG = 0.25
SWAY_BANDWIDTH_HZ = 0.5
# margin of the clock before and after a trial, so that its ends are as accurate as its middle
MARGIN_S = 1.0

# upward acceleration of the shank just after heel strike in walking at 1.3 m/s (skin-mounted
# sensors: 1-3 g; Lafortune, J Biomech 24:877, 1991), its duration, and the share that reaches the
# thigh
IMPACT_M_S2_PER_M_S = 10.0
IMPACT_TIME_S = 0.010
IMPACT_SHARE = {"shank": 1.0, "thigh": 0.4, "pelvis": 0.2}


def postural_sway(rng: np.random.Generator, time_s: FloatArray) -> dict[str, FloatArray]:
    """Sway of a person standing still.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    time_s : ndarray, shape (N,)
        Clock.

    Returns
    -------
    dict of str to ndarray, shape (N, 3)
        Joint angles in rad.
    """
    # bounds in whole seconds, so that the sway is the same at every sampling rate
    begin, end = np.floor(time_s[0]) - 1.0, np.ceil(time_s[-1]) + 1.0
    sway = smooth_noise(rng, begin, end, SWAY_BANDWIDTH_HZ, 3 * len(JOINTS))(time_s)
    sway *= np.radians(SWAY_SD_DEG)
    return {joint: sway[:, 3 * k : 3 * k + 3] for k, joint in enumerate(JOINTS)}


def walk(
    pattern: WalkingPattern,
    timing: GaitTiming,
    body: Body,
    time_s: FloatArray,
    rate_hz: float,
    rng: np.random.Generator,
    travels: bool,
) -> SkeletonMotion:
    """Move a walker through a trial.

    Parameters
    ----------
    pattern : WalkingPattern
        Gait of the walker.
    timing : GaitTiming
        Gait timing.
    body : Body
        Size.
    time_s : ndarray, shape (N,)
        Clock; its first and last `MARGIN_S` are not to be used.
    rate_hz : float
        Its rate.
    rng : numpy.random.Generator
        Source of randomness for the sway.
    travels : bool
        Over ground; otherwise on a treadmill, where the walker stays in place.

    Returns
    -------
    SkeletonMotion
        In standing all angles are zero except for sway.
    """
    phase = timing.phase_of_time(time_s)
    size = timing.size(time_s)
    joint_angles = pattern.joint_angles(phase)
    sway = postural_sway(rng, time_s)
    for k, joint in enumerate(JOINTS):
        angles = joint_angles[joint]
        variation = timing.variation(pattern.leg_phase(joint, phase), slice(6 * k, 6 * k + 6))
        mean = pattern.curves[joint][:, 0].real
        angles -= mean
        angles *= 1.0 + SIZE_CV * variation[:, :3]
        angles += mean + np.radians(OFFSET_SD_DEG) * variation[:, 3:]
        angles *= size[:, None]
        angles += sway[joint]
    for joint in ("hip_right", "knee_right", "hip_left", "knee_left"):
        joint_angles[joint][:, 0] += timing.pauses.seat_rad(time_s)

    motion = move(time_s, rate_hz, joint_angles, body)
    impacts = _impacts(timing, pattern, time_s, size)
    if pattern.runs:
        path = size[:, None] * bounce_m(phase, pattern.toe_off)
        if travels:
            path[:, 0] = integral(pattern.speed_m_s * size, rate_hz)
        return dataclasses.replace(motion, pelvis_m=motion.pelvis_m + path, impact_m=impacts)
    velocity = forward_velocity(
        joint_angles, phase, pattern.toe_off, pattern.left_lag, body, rate_hz
    )
    path = integral(velocity, rate_hz)
    # a treadmill walker stays in place, without vertical or lateral drift: the residual
    # displacement per stride is removed (the curves of leg and pelvis come from different studies)
    stride = round(pattern.stride_s * rate_hz) | 1
    drift = uniform_filter1d(path, stride, axis=0, mode="nearest")
    if travels:
        drift[:, 0] = 0.0
    return dataclasses.replace(
        motion,
        pelvis_m=motion.pelvis_m + path - drift,
        impact_m=impacts,
    )


def _impacts(
    timing: GaitTiming, pattern: WalkingPattern, time_s: FloatArray, size: FloatArray
) -> dict[str, FloatArray]:
    """Shock wave of each heel strike: ``x^4 exp(-x)`` decays without a lasting displacement."""
    # the second derivative of x^4 exp(-x) peaks at 1.85
    peak = IMPACT_M_S2_PER_M_S * pattern.speed_m_s * IMPACT_TIME_S**2 / 1.85
    impacts = {"pelvis": np.zeros((len(time_s), 3))}
    for side in SIDES:
        strikes = np.concatenate([[-np.inf], timing.events[f"heel_strike_{side}"]])
        since = time_s - strikes[np.searchsorted(strikes, time_s, side="right") - 1]
        x = np.minimum(since / IMPACT_TIME_S, 60.0)
        wave = np.zeros((len(time_s), 3))
        wave[:, 2] = peak * size * x**4 * np.exp(-x)
        for segment in ("shank", "thigh"):
            impacts[f"{segment}_{side}"] = IMPACT_SHARE[segment] * wave
        impacts["pelvis"] += IMPACT_SHARE["pelvis"] * wave
    return impacts
