"""A regular clock in place of stamps that are not sampling times.

A stamp taken on arrival is never earlier than the sample, so the clock is the line below all stamps
with the smallest mean distance from them: an edge of their lower convex hull (Moon, Skelly and
Towsley, Estimation and removal of clock skew from network delay measurements, IEEE INFOCOM 1999).
Stamps that jitter to either side get the least-squares line, truncated ones a line above them, and
stamps that all samples of a packet share, from the end of the first packet on, a line below them.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.stats import skew

from narx.types import FloatArray, IntArray

# a longer pause between packets is not lost samples of one clock
_MAX_PERIODS = 1e9
# samples read out of one packet have stamps closer than this share of the mean interval
_AT_ONCE = 0.1
_AT_ONCE_SHARE = 0.25
# packets have the same size; if not, the delays are not symmetric
_MOSTLY, _ONE_SIDED = 0.6, 0.4
# deviations of stamps in steps: 0.29 steps, if they are spread evenly over one
_STEP_SD = 0.4
# the residuals must be without structure beyond this, over windows of a length
_STRUCTURE_S, _MAX_STRUCTURE_S = 0.02, 0.05
_WINDOW_S, _ARRIVAL_WINDOW_S = 1.0, 2.0
_WINDOW_PACKETS = 5
# more points do not change the hull noticeably
_HULL_POINTS = 5000


def regular_clock(time_s: FloatArray) -> tuple[FloatArray | None, str]:
    """Fit a regular clock to stamps.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Stamps in the order of the samples, s.

    Returns
    -------
    clock_s : ndarray, shape (N,), or None
        Sampling times; None if the deviations of the stamps have structure, so that they are not
        explained by delay or jitter.
    how : str
        Description of the stamps and of the clock, as a note.
    """
    steps = np.diff(time_s)
    mean_step = float(np.mean(steps))
    first = np.r_[0, np.flatnonzero(steps > 0.5 * mean_step) + 1]
    sizes = np.diff(np.r_[first, len(time_s)])
    size = int(np.median(sizes))
    period = float(np.median(np.diff(time_s[first]))) if len(first) > 1 else np.inf
    if not np.isfinite(period) or min(period, mean_step) <= 0:
        return None, ""
    periods = np.round(np.diff(time_s[first]) / period)
    if periods.max() > _MAX_PERIODS:
        return None, ""
    lost = np.maximum(0, periods.astype(int) - 1) * size
    with_lost = np.arange(len(time_s)) + np.repeat(np.r_[0, np.cumsum(lost)], sizes)
    in_steps = size > 1 and _on_grid(time_s, period)
    at_once = (steps >= 0) & (steps < _AT_ONCE * mean_step)
    arrived = not in_steps and float(at_once.mean()) > _AT_ONCE_SHARE
    if arrived and (np.mean(sizes == size) < _MOSTLY or _is_rounded(time_s, mean_step)):
        # jitter, rounded, has equal stamps as well, but its deviations are symmetric
        slope = np.polyfit(np.arange(len(time_s)), time_s - time_s[0], 1)[0]
        delay = time_s - slope * np.arange(len(time_s))
        arrived = bool(skew(delay) > _ONE_SIDED)
    if arrived:
        # the samples of a packet have arrived with its first one
        packet = np.r_[0, np.flatnonzero(~at_once) + 1]
        time_s = np.repeat(time_s[packet], np.diff(np.r_[packet, len(time_s)]))
    best: tuple[float, FloatArray, FloatArray] | None = None
    for index in (np.arange(len(time_s)), with_lost):
        if arrived:
            interval = _slope_below(index, time_s)
        else:
            # only the first sample of a step carries timing information
            interval = float(np.polyfit(index[first], time_s[first] - time_s[0], 1)[0])
        residual: FloatArray = time_s - time_s[0] - interval * index
        structure = _structure_s(residual, interval, size, arrived)
        if interval > 0 and (best is None or structure < 0.8 * best[0]):
            best = structure, np.asarray(interval * index), residual
    if best is None:
        return None, ""
    structure, clock, offset = best
    limit = max(0.5 * period, _STRUCTURE_S)
    if arrived:
        usual_delay = float(np.median(offset) - offset.min())
        limit = max(limit, min(0.5 * usual_delay, _MAX_STRUCTURE_S))
    if structure > limit:
        return None, ""
    interval = float(np.median(np.diff(clock)))
    # the first packet of a clock that starts at zero is stamped after a whole packet
    whole = sizes[0] == size and round(float(time_s[0]) / period) == 1
    # a step hides less than its length; more is jitter that was rounded
    in_steps = in_steps and float(offset.std()) < _STEP_SD * period
    if in_steps and whole:
        kind, start = f"stamps at the end of packets of {size} samples", float(offset.min())
    elif in_steps:
        kind = f"stamps in steps of {period:g} s"
        start = float(min(offset.max(), offset.mean() + 0.5 * period))
    elif arrived:
        kind, start = "stamps at arrival", float(offset.min())
        if size > 1:
            kind += f" of packets of {size} samples"
    else:
        kind, start = f"jitter of the stamps {1e3 * offset.std():.1f} ms", float(offset.mean())
    how = f"{kind}: a regular clock of {1 / interval:.6g} Hz in its place"
    return time_s[0] + start + clock, how


def _is_rounded(time_s: FloatArray, mean_step_s: float) -> bool:
    """Return whether all stamps are multiples of about an interval."""
    steps = np.diff(time_s)
    unit = float(steps[steps > 0].min())
    return unit > 0.5 * mean_step_s and _on_grid(time_s, unit)


def _on_grid(time_s: FloatArray, unit_s: float) -> bool:
    """Return whether the stamps are whole units apart, to a thousandth."""
    units = (time_s - time_s[0]) / unit_s
    # the unit was measured on one step, in which the digits of a time of day are few
    units *= np.round(units[-1]) / units[-1]
    return bool(np.abs(units - np.round(units)).max() < 1e-3)


def _structure_s(residual: FloatArray, interval: float, size: int, arrived: bool) -> float:
    """Return how far the residuals wander: their least values, or their running mean."""
    window = _ARRIVAL_WINDOW_S if arrived else _WINDOW_S
    n = min(max(_WINDOW_PACKETS * size, round(window / max(interval, 1e-6))), len(residual))
    if not arrived:
        return float(np.ptp(uniform_filter1d(residual, n)))
    least = np.minimum.reduceat(residual, np.arange(0, len(residual) - n + 1, n))
    return float(np.ptp(least))


def _slope_below(index: IntArray, time_s: FloatArray) -> float:
    """Slope of the line below all points with the smallest mean distance from them."""
    slope = float(np.polyfit(index, time_s - time_s[0], 1)[0])
    residual = time_s - time_s[0] - slope * index
    block = max(1, len(index) // _HULL_POINTS)
    least = [
        begin + int(np.argmin(residual[begin : begin + block]))
        for begin in range(0, len(index), block)
    ]
    hull: list[tuple[float, float]] = []
    for x, y in zip(index[least].astype(float), residual[least], strict=True):
        while len(hull) > 1 and (hull[-1][1] - hull[-2][1]) * (x - hull[-2][0]) >= (
            y - hull[-2][1]
        ) * (hull[-1][0] - hull[-2][0]):
            hull.pop()
        hull.append((float(x), float(y)))
    middle = float(index.mean())
    edge = next((k for k in range(1, len(hull) - 1) if hull[k][0] >= middle), len(hull) - 1)
    (x0, y0), (x1, y1) = hull[edge - 1], hull[edge]
    return slope + ((y1 - y0) / (x1 - x0) if x1 > x0 else 0.0)
