"""Pseudo-integrator, Tham et al., eq. (9): see `narx.baselines.pseudo_integrator`."""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled


def pseudo_integrator_step(
    state: tuple[float, float, float], rate: float, breakpoint_rad_s: float, interval_s: float
) -> tuple[float, float, float]:
    """Advance one axis by one sample.

    The state is the leaky integral, its slow part and the rate; the angle is the first less the
    second. Plain arithmetic, so that its operations can be counted.
    """
    integral, slow, rate_before = state
    leak = 0.5 * interval_s * breakpoint_rad_s
    normaliser = 1.0 / (1.0 + leak)
    kept = (1.0 - leak) * normaliser
    following = kept * integral + (0.5 * interval_s) * normaliser * (rate + rate_before)
    slow = kept * slow + leak * normaliser * (following + integral)
    return following, slow, rate


_step = compiled(**EXACT_INNER)(pseudo_integrator_step)


@compiled(**EXACT)
def pseudo_integrate(rates: Any, breakpoint_rad_s: Any, interval_s: float) -> Any:
    """Angles (N, A) of axes from their rates (N, A) and the breakpoint (N,) at each sample."""
    out = np.empty_like(rates)
    for axis in range(rates.shape[1]):
        state = (0.0, 0.0, 0.0)
        for k in range(len(rates)):
            state = _step(state, rates[k, axis], breakpoint_rad_s[k], interval_s)
            out[k, axis] = state[0] - state[1]
    return out
