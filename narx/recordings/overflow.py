"""Rates beyond the range of the sensor's 16-bit numbers, which wrap around to the other sign."""

import numpy as np

from narx.errors import RecordingError
from narx.types import BoolArray, FloatArray

# the smallest range of any gyroscope is 125 deg/s
_MIN_RANGE_RAD_S = np.radians(100.0)
# both samples at a jump lie beyond this share of the largest rate, on either side of zero
_NEAR_THE_END = 0.6
# continued by the period, the signal bends by less than this share of the jump
_SMOOTH = 0.3
# all jumps are of one period
_SAME = 0.1
# a leg is not beyond the range for longer, and for a small share of a recording
_LONGEST_S, _MOST = 0.5, 0.25


def without_overflow(
    gyroscope_rad_s: FloatArray, interval_s: float, where: str
) -> tuple[FloatArray, tuple[str, ...]]:
    """Continue rates that wrap around at the end of a sensor's range.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate, rad/s; NaN where missing.
    interval_s : float
        Sampling interval, s.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    gyroscope_rad_s : ndarray, shape (N, 3)
        The rates, continued beyond the range.
    notes : tuple of str
        Number of samples, if any.

    Raises
    ------
    RecordingError
        If rates wrap around and do not come back within half a second, or too often.

    Notes
    -----
    Two's complement of 16 bits continues the largest rate as the smallest one. The jump is the
    period less the step of the signal; the period is the median of the jumps with that step
    extrapolated from the two samples before and after. No movement jumps from one end of its range
    to the other within a sample and is smooth if one of the two is moved by this period.
    """
    jumps = [_jumps(gyroscope_rad_s[:, axis]) for axis in range(3)]
    periods = np.concatenate([found[1] for found in jumps])
    period = float(np.median(periods)) if len(periods) else 0.0
    if not len(periods) or np.abs(periods - period).max() > _SAME * period:
        return gyroscope_rad_s, ()
    rate = gyroscope_rad_s.copy()
    beyond = np.zeros(len(rate), dtype=bool)
    for axis, (turns, _) in enumerate(jumps):
        count = np.cumsum(turns)
        beyond |= count != 0
        rate[:, axis] += count * period
        stays = _longest(count != 0) * interval_s > _LONGEST_S
        if count[-1] != 0 or np.abs(count).max() > 1 or stays:
            break
    else:
        if beyond.mean() < _MOST:
            at = np.degrees(0.5 * period)
            return rate, (
                f"{beyond.sum()} samples beyond the gyroscope's range of {at:.0f} deg/s, which "
                "wrapped around to the other sign, continued",
            )
    raise RecordingError(
        f"{where}: the gyroscope jumps from one end of its range ({np.degrees(0.5 * period):.0f} "
        "deg/s) to the other, for too long to be continued: its 16-bit numbers overflowed; "
        "expected a larger range"
    )


def _jumps(rate: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find where one axis wraps around.

    Returns the change of the number of periods at each sample, and the period at each jump.
    """
    turns = np.zeros(len(rate))
    finite = rate[np.isfinite(rate)]
    largest = float(np.abs(finite).max(initial=0.0))
    if len(rate) < 4 or largest < _MIN_RANGE_RAD_S:
        return turns, np.empty(0)
    step = np.diff(rate)
    far = np.abs(rate) > _NEAR_THE_END * largest
    wide: BoolArray = far[1:] & far[:-1] & (rate[1:] * rate[:-1] < 0)
    # the signal's own step: the mean of those before and after, unless they are jumps as well
    own = np.where(wide, np.nan, step)
    before, after = np.r_[np.nan, own[:-1]], np.r_[own[1:], np.nan]
    expected = np.where(
        np.isnan(before), after, np.where(np.isnan(after), before, 0.5 * (before + after))
    )
    expected = np.nan_to_num(expected)
    at = np.flatnonzero(wide & (np.abs(expected) < _SMOOTH * np.abs(step)))
    turns[at + 1] = -np.sign(step[at])
    return turns, np.abs(step[at] - expected[at])


def _longest(flags: BoolArray) -> int:
    edges = np.flatnonzero(np.diff(np.r_[False, flags, False].astype(int)))
    return int((edges[1::2] - edges[::2]).max(initial=0))
