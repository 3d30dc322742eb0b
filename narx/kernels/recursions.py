"""Recursions of one axis, and the loop that runs them on three axes, coupled or not.

A recursion is a plain function ``(output, memory, before, rate, extra, parameters)`` to
``(output, memory)``: its output and other memory, the rate of the previous and of the current
sample, an extra input for this sample (a tilt, a breakpoint), and three constants, the first of
which is the sampling interval. Plain arithmetic, so that it runs compiled, sample by sample, and on
numbers that count operations.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.transfer import copy_row

Recursion = Callable[[Any, Any, Any, Any, Any, Any], tuple[Any, Any]]

# columns of a state (3, 3), one row per axis
OUTPUT, MEMORY, BEFORE = range(3)


def integrate(
    output: Any, memory: Any, before: Any, rate: Any, extra: Any, parameters: Any
) -> tuple[Any, Any]:
    """Integrate; parameters: interval, 1 for the trapezoidal rule or 0 for the rectangle."""
    interval, trapezoid, _ = parameters
    turned = (0.5 * interval) * (rate + before) if trapezoid else interval * rate
    return output + turned, memory


def leak(
    output: Any, memory: Any, before: Any, rate: Any, extra: Any, parameters: Any
) -> tuple[Any, Any]:
    """Leaky integration; parameters: interval, leak, its growth per rad^2; `extra`: a factor."""
    interval, leak_rad_s, by_square = parameters
    damping = 1.0 + interval * leak_rad_s * extra * (1.0 + by_square * output * output)
    return (output + (0.5 * interval) * (rate + before)) / damping, memory


def pull(
    output: Any, memory: Any, before: Any, rate: Any, extra: Any, parameters: Any
) -> tuple[Any, Any]:
    """Integrate, then move a fraction of the way to `extra`; parameters: as before, fraction."""
    interval, trapezoid, gain = parameters
    turned = (0.5 * interval) * (rate + before) if trapezoid else interval * rate
    predicted = output + turned
    difference = extra - predicted
    if abs(difference) > np.pi:
        difference = difference - 2.0 * np.pi * round(difference / (2.0 * np.pi))
    return predicted + gain * difference, memory


def reset(
    output: Any, memory: Any, before: Any, rate: Any, extra: Any, parameters: Any
) -> tuple[Any, Any]:
    """Use `extra` where it is valid, else integrate; parameters: interval."""
    if extra == extra:
        return extra, memory
    return output + (0.5 * parameters[0]) * (rate + before), memory


def band_pass(
    output: Any, memory: Any, before: Any, rate: Any, extra: Any, parameters: Any
) -> tuple[Any, Any]:
    """Leaky integral minus its slow part (memory); `extra`: breakpoint in rad/s."""
    interval, _, _ = parameters
    integral = output + memory
    leak_half = 0.5 * interval * extra
    normaliser = 1.0 / (1.0 + leak_half)
    kept = (1.0 - leak_half) * normaliser
    following = kept * integral + (0.5 * interval) * normaliser * (rate + before)
    slow = kept * memory + leak_half * normaliser * (following + integral)
    return following - slow, slow


RECURSIONS: tuple[Recursion, ...] = (integrate, leak, pull, reset, band_pass)

_integrate, _leak, _pull, _reset, _band_pass = (compiled(**EXACT_INNER)(one) for one in RECURSIONS)


def rates_of_angles(u_sagittal: Any, u_frontal: Any, u_transverse: Any, s: Any, f: Any) -> Any:
    """Rates of the three angles from the gyroscope at the sagittal and frontal angle s and f.

    As `narx.kinematics.segment_angles.coupled_rates`, with a lower limit on the magnitude of the
    cosine of the frontal angle.
    """
    sin_s, cos_s, sin_f, cos_f = np.sin(s), np.cos(s), np.sin(f), np.cos(f)
    if abs(cos_f) < COS_FRONTAL_MIN:
        cos_f = -COS_FRONTAL_MIN if cos_f < 0 else COS_FRONTAL_MIN
    heading = (u_transverse * cos_s - u_frontal * sin_s) / cos_f
    return u_sagittal - sin_f * heading, u_frontal * cos_s + u_transverse * sin_s, heading


_rates_of_angles = compiled(**EXACT_INNER)(rates_of_angles)


@compiled(**EXACT)
def run_recursion(
    kind: int,
    rates: Any,
    extras: Any,
    columns: Any,
    parameters: tuple[float, float, float],
    coupled: bool,
    posture: Any,
    fresh: bool,
    state: Any,
    out: Any,
) -> None:
    """Fill `columns` of out (N, 3) from rates (N, 3) and extras (N, 3); advance state (3, 3).

    kind: index of the recursion in `RECURSIONS`. Outputs are relative to posture (3,). With
    `coupled`, the rates of the angles replace those of the gyroscope, with the tilt extrapolated to
    the time of the sample. With `fresh`, the output of the first sample is that of the state.
    """
    interval = parameters[0]
    rate = np.empty(3)
    for k in range(len(rates)):
        if coupled:
            rate[0], rate[1], rate[2] = _rates_of_angles(
                rates[k, 0],
                rates[k, 1],
                rates[k, 2],
                posture[0] + state[0, 0] + interval * state[0, 2],
                posture[1] + state[1, 0] + interval * state[1, 2],
            )
        else:
            copy_row(rates[k], rate)
        for axis in columns:
            if k > 0 or not fresh:
                output, memory, before = state[axis, 0], state[axis, 1], state[axis, 2]
                now, extra = rate[axis], extras[k, axis]
                if kind == 0:
                    output, memory = _integrate(output, memory, before, now, extra, parameters)
                elif kind == 1:
                    output, memory = _leak(output, memory, before, now, extra, parameters)
                elif kind == 2:
                    output, memory = _pull(output, memory, before, now, extra, parameters)
                elif kind == 3:
                    output, memory = _reset(output, memory, before, now, extra, parameters)
                else:
                    output, memory = _band_pass(output, memory, before, now, extra, parameters)
                state[axis, 0], state[axis, 1] = output, memory
            state[axis, 2] = rate[axis]
            out[k, axis] = posture[axis] + state[axis, 0]
