"""Filters that correct the integrated gyroscope by gravity: `complementary_filter` and `giof`.

The steps are plain arithmetic: the streams run them on floats, and operations can be counted.
"""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled


def tilt(frontal: Any, x: Any, y: Any, z: Any) -> Any:
    """Tilt of the frontal or else the sagittal axis, rad, from the specific force.

    ``atan2(-y, sqrt(x^2 + z^2))`` or ``atan2(x, z)``, with x forward, y left and z up, in any unit;
    as `narx.kinematics.segment_angles.tilt_from_specific_force`.
    """
    return np.arctan2(-y, np.sqrt(x * x + z * z)) if frontal else np.arctan2(x, z)


def gravity_alone(x: float, y: float, z: float, low: float, high: float) -> bool:
    """Abhayasinghe et al., eq. (1), squared to save the root."""
    norm_squared = x * x + y * y + z * z
    return low < norm_squared < high


def integrate(angle: float, rate: float, rate_before: float, half_interval_s: float) -> float:
    """Integrate one sample of one axis by the trapezoidal rule."""
    return angle + half_interval_s * (rate + rate_before)


def complementary_step(
    angle: float,
    rate: float,
    rate_before: float,
    tilted: float,
    interval_s: float,
    gain: float,
    trapezoid: bool,
) -> float:
    """Advance the complementary filter of one axis by one sample."""
    if trapezoid:
        predicted = angle + (0.5 * interval_s) * (rate + rate_before)
    else:
        predicted = angle + interval_s * rate
    difference = tilted - predicted
    if abs(difference) > np.pi:
        difference = difference - 2.0 * np.pi * round(difference / (2.0 * np.pi))
    return predicted + gain * difference


_tilt = compiled(**EXACT_INNER)(tilt)
_gravity_alone = compiled(**EXACT_INNER)(gravity_alone)
_integrate = compiled(**EXACT_INNER)(integrate)
_complementary_step = compiled(**EXACT_INNER)(complementary_step)


@compiled(**EXACT)
def complementary(
    rate: Any,
    tilts: Any,
    initial: float,
    interval_s: float,
    gain: float,
    trapezoid: bool,
) -> Any:
    """Angles (N,) of one axis from its rate (N,) and the accelerometer's tilt (N,)."""
    out = np.empty(len(rate))
    angle = initial
    for k in range(len(rate)):
        if k > 0:
            angle = _complementary_step(
                angle, rate[k], rate[k - 1], tilts[k], interval_s, gain, trapezoid
            )
        out[k] = angle
    return out


@compiled(**EXACT)
def giof(
    rates: Any,
    force: Any,
    frontal: Any,
    start: Any,
    half_interval_s: float,
    low: float,
    high: float,
    rate_threshold: float,
    needed: int,
) -> Any:
    """Angles (N, A) of one or two axes from their rates (N, A) and the specific force (N, 3).

    frontal (A,) is True for the frontal axis; start (A,), rad; low and high: squared norms between
    which the force may be gravity alone; `needed` samples in a row of rest.
    """
    out = np.empty_like(rates)
    rested = 0
    for k in range(len(rates)):
        x, y, z = force[k]
        resting = _gravity_alone(x, y, z, low, high)
        for i in range(len(frontal)):
            resting = resting and abs(rates[k, i]) < rate_threshold
        rested = rested + 1 if resting else 0
        for i in range(len(frontal)):
            if rested >= needed:
                out[k, i] = _tilt(frontal[i], x, y, z)
            elif k == 0:
                out[k, i] = start[i]
            else:
                out[k, i] = _integrate(out[k - 1, i], rates[k, i], rates[k - 1, i], half_interval_s)
    return out
