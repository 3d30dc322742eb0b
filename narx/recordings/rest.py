"""The rest at the start of a recording."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

from narx.types import FloatArray

# above standing sway and sensor noise, below movement (Han et al., gamma of eq. (3))
REST_RAD_S = np.radians(10.0)


def first_rest_s(gyroscopes_rad_s: Sequence[FloatArray], sampling_rate_hz: float) -> float:
    """Find the duration of rest at the start of a recording.

    Parameters
    ----------
    gyroscopes_rad_s : sequence of ndarray, shape (N, 3)
        Angular rates of sensors on one clock, rad/s.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    float
        Time until a tenth of a second before the first sample in which any sensor turns by more
        than 10 deg/s (averaged over a tenth of a second) relative to its median over the first half
        second; 0 without a rest.
    """
    first = max(1, round(0.5 * sampling_rate_hz))
    margin = max(1, round(0.1 * sampling_rate_hz))
    ends = []
    for rate in gyroscopes_rad_s:
        if not np.isfinite(rate[:first]).all(axis=1).any():
            return 0.0
        deviation = rate - np.nanmedian(rate[:first], axis=0)
        # missing samples do not end the rest
        smooth = uniform_filter1d(np.nan_to_num(deviation), margin, axis=0, mode="nearest")
        speed = np.linalg.norm(smooth, axis=1)
        moving = np.flatnonzero(speed > REST_RAD_S)
        ends.append(moving[0] if moving.size else len(rate))
    return max(0.0, float((min(ends) - 1 - margin) / sampling_rate_hz))
