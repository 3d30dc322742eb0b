"""Artefacts of a sensor, a radio link or a logger: detected, removed and reported.

Each detector handles one kind of fault. The samples that it finds become missing (NaN); clipping is
only reported, since the samples around it are real.
"""

from collections.abc import Callable

import numpy as np

from narx.missing import finite_rows
from narx.types import BoolArray, FloatArray

# beyond the widest range of any gyroscope, 4000 deg/s
IMPOSSIBLE_RAD_S = np.radians(4500.0)
# a sensor that turns faster than this does not output the same value twice
_MOVING_RAD_S = np.radians(12.0)
_HELD_ROWS, _HELD_S = 3, 0.03
# values repeated as often as this come from a slower sensor than the file's clock
_SLOWER_SHARE = 0.3
_STUCK_S = 0.25
_STUCK_OTHERS_RAD_S = np.radians(15.0)
# no movement faster than this stops within one sample
_JUMP_RAD_S = np.radians(20.0)
# Rotation by a spike of one, two or three samples: the smaller limits if it deviates by 25 times
# the usual, the larger by 12 times. No walk or hand movement recorded at 12 to 280 Hz has one.
_SPIKE_RAD = tuple(map(tuple, np.radians([(2.0, 5.0), (4.5, 9.0), (12.0, 12.0)])))
_SPIKE_RATIOS = (25.0, 12.0)
_SPIKE_NEIGHBOURS, _SPIKE_ROUNDS, _SPIKE_SAMPLES = 0.25, 3, 10
_CLIPPED_SHARE = 0.002
_CLIPPED_RAD_S = np.radians(20.0)

Detector = Callable[[FloatArray, FloatArray], tuple[BoolArray, str]]


def without_faults(
    time_s: FloatArray, gyroscope_rad_s: FloatArray
) -> tuple[FloatArray, tuple[str, ...]]:
    """Remove artefacts from a gyroscope's recording.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate, rad/s; NaN where missing.

    Returns
    -------
    gyroscope_rad_s : ndarray, shape (N, 3)
        The rates, with NaN for values beyond the range of any sensor, zeros within movement, held
        or stuck values, and single spikes.
    notes : tuple of str
        Number of each kind of fault and time of the first; share of samples clipped by the range.
    """
    rate = gyroscope_rad_s
    notes = []
    for detector in (_impossible, _zeros, _spikes, _held, _stuck):
        wrong, what = detector(time_s, rate)
        if wrong.any():
            first = int(np.flatnonzero(wrong)[0])
            count = int(wrong.sum())
            notes.append(
                f"{count} {'sample' if count == 1 else 'samples'} {what} taken as missing, the "
                f"first at {time_s[first]:g} s"
            )
            rate = np.where(wrong[:, None], np.nan, rate)
    notes += _clipping(rate)
    return rate, tuple(notes)


def repeated_share(gyroscope_rad_s: FloatArray) -> float:
    """Return the share of samples in movement that repeat the previous one.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate, rad/s.

    Returns
    -------
    float
        Between 0 and 1; 0 where nothing moves.
    """
    moving = _moving(gyroscope_rad_s)
    repeats = _repeats(gyroscope_rad_s) & moving
    return float(repeats.sum() / max(1, moving.sum())) if moving.any() else 0.0


def repeats_of_a_slower_sensor(gyroscope_rad_s: FloatArray) -> BoolArray | None:
    """Find the rows that a logger added because its clock is faster than the sensor's.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate, rad/s.

    Returns
    -------
    ndarray of bool, shape (N,), or None
        Rows that repeat the previous row; None unless such rows are frequent in movement, in short
        runs.
    """
    repeats = _repeats(gyroscope_rad_s)
    if repeated_share(gyroscope_rad_s) < _SLOWER_SHARE:
        return None
    moving = _moving(gyroscope_rad_s)
    runs = [stop - start for start, stop in _runs(repeats & moving)]
    usual = np.quantile(runs, 0.9)
    return repeats if usual <= 1.5 * max(1.0, float(np.median(runs))) else None


def _impossible(time: FloatArray, rate: FloatArray) -> tuple[BoolArray, str]:
    wrong = (np.abs(rate) > IMPOSSIBLE_RAD_S).any(axis=1)
    largest = float(np.abs(rate[wrong]).max()) if wrong.any() else 0.0
    return wrong, f"beyond any gyroscope (up to {largest:.3g} rad/s)"


def _zeros(time: FloatArray, rate: FloatArray) -> tuple[BoolArray, str]:
    """Find zeros in place of missing samples: movement stops or starts within one sample."""
    wrong = np.zeros(len(rate), dtype=bool)
    speed = np.linalg.norm(rate, axis=1)
    for start, stop in _runs((rate == 0).all(axis=1)):
        before = speed[start - 1] if start else 0.0
        after = speed[stop] if stop < len(rate) else 0.0
        wrong[start:stop] = max(before, after) > _JUMP_RAD_S
    return wrong, "of exactly zero within movement"


def _held(time: FloatArray, rate: FloatArray) -> tuple[BoolArray, str]:
    wrong = np.zeros(len(rate), dtype=bool)
    for start, stop in _runs(_repeats(rate) & _moving(rate)):
        long = stop - start + 1 >= _HELD_ROWS and time[stop - 1] - time[start - 1] >= _HELD_S
        wrong[start:stop] = long
    return wrong, "that repeat their predecessor bit by bit in movement"


def _stuck(time: FloatArray, rate: FloatArray) -> tuple[BoolArray, str]:
    """Find samples with one constant axis while the others move."""
    wrong = np.zeros(len(rate), dtype=bool)
    rms = np.sqrt(np.mean(np.nan_to_num(rate) ** 2, axis=0))
    for axis in range(3):
        one = rate[:, axis]
        if rms[axis] < _MOVING_RAD_S:
            continue
        others = np.delete(rate, axis, axis=1)
        extremes = np.nanmin(one), np.nanmax(one)
        for start, stop in _runs(np.r_[False, one[1:] == one[:-1]]):
            inside = np.sqrt(np.mean(np.sum(np.nan_to_num(others[start:stop]) ** 2, axis=1)))
            wrong[start:stop] |= (
                time[stop - 1] - time[start - 1] >= _STUCK_S
                and inside > _STUCK_OTHERS_RAD_S
                and one[start] not in extremes
            )
    return wrong, "with a constant axis while the others move"


def _spikes(time: FloatArray, rate: FloatArray) -> tuple[BoolArray, str]:
    """Find one to three samples that deviate from a line between consistent neighbours."""
    wrong = np.zeros(len(rate), dtype=bool)
    there = finite_rows(rate)
    interval = float(np.median(np.diff(time)))
    # large spikes hide small ones
    for _ in range(_SPIKE_ROUNDS):
        rows = np.flatnonzero(there & ~wrong)
        found = np.zeros(len(rows), dtype=bool)
        for width, limits_rad in enumerate(_SPIKE_RAD, start=1):
            if len(rows) < _SPIKE_SAMPLES:
                break
            found |= _spikes_of(width, limits_rad, time[rows], rate[rows], interval)
        if not found.any():
            break
        wrong[rows[found]] = True
    return wrong, "with a spike"


def _spikes_of(
    width: int,
    limits_rad: tuple[float, float],
    time: FloatArray,
    rate: FloatArray,
    interval: float,
) -> BoolArray:
    """Find runs of so many samples that all deviate."""
    before, after = rate[: -width - 1], rate[width + 1 :]
    inside = [slice(1 + k, len(rate) - width + k) for k in range(width)]
    off = np.full(len(before), np.inf)
    for k, own in enumerate(inside, start=1):
        line = before + (after - before) * (k / (width + 1))
        off = np.minimum(off, np.linalg.norm(rate[own] - line, axis=1))
    moving = _moving(rate[1 : len(off) + 1])
    found = np.zeros(len(rate), dtype=bool)
    usual = float(np.quantile(off[moving] if moving.sum() > _SPIKE_SAMPLES else off, 0.75))
    turned = off * width * interval
    beyond = np.zeros(len(off), dtype=bool)
    for limit_rad, ratio in zip(limits_rad, _SPIKE_RATIOS, strict=True):
        beyond |= (turned > limit_rad) & (off > ratio * usual)
    # an impact changes the neighbours as well, and across a gap they are none
    beyond &= np.linalg.norm(after - before, axis=1) < _SPIKE_NEIGHBOURS * off
    beyond &= time[width + 1 :] - time[: -width - 1] < 1.5 * (width + 1) * interval
    for own in inside:
        found[own] |= beyond
    return found


def _clipping(rate: FloatArray) -> list[str]:
    clipped = np.zeros(len(rate), dtype=bool)
    levels = []
    for axis, name in enumerate("xyz"):
        one = rate[:, axis]
        valid = one[np.isfinite(one)]
        if valid.size < 10:
            continue
        for level in (valid.max(), valid.min()):
            at_level = one == level
            if abs(level) < _CLIPPED_RAD_S or at_level.mean() < _CLIPPED_SHARE:
                continue
            runs = [(start, stop) for start, stop in _runs(at_level) if stop - start >= 3]
            inside = sum(stop - start for start, stop in runs)
            if len(runs) and inside > 0.5 * at_level.sum() and _flat(one, runs, level):
                clipped |= at_level
                levels.append(f"{name} {level:g}")
    if not levels:
        return []
    return [
        f"{100 * clipped.mean():.0f} % of the rows are at the same extreme value "
        f"({', '.join(levels)} rad/s): the gyroscope's range is too small, and the "
        "clipped rotation is missing from the angles"
    ]


def _flat(one: FloatArray, runs: list[tuple[int, int]], level: float) -> bool:
    """Return whether a peak is clipped, not rounded: the signal reaches it at full slope."""
    steps = np.abs(np.diff(one[np.isfinite(one)]))
    quantum = steps[steps > 0].min() if (steps > 0).any() else 0.0
    before = one[[start - 1 for start, _ in runs if start > 0]]
    into = np.abs(before[np.isfinite(before)] - level)
    return bool(into.size) and float(np.median(into)) > 3 * quantum


def _moving(rate: FloatArray) -> BoolArray:
    # far above the bias of any current gyroscope
    return np.asarray(np.linalg.norm(rate, axis=1) > _MOVING_RAD_S)


def _repeats(rate: FloatArray) -> BoolArray:
    repeats = np.zeros(len(rate), dtype=bool)
    repeats[1:] = (rate[1:] == rate[:-1]).all(axis=1)
    return repeats


def _runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Start and end (exclusive) of each run of True."""
    edges = np.flatnonzero(np.diff(np.r_[False, flags, False].astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
