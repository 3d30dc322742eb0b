"""Estimate and remove the lag of target angles behind the gyroscope.

A reference with a separate clock is late or early by some milliseconds even after its recording
was aligned, and a network would learn that lag, because its input taps can represent a delay.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from narx.errors import UserError
from narx.kinematics.segment_angles import FRONTAL, SAGITTAL, coupled_rates
from narx.recordings.resampling import resample_vectors
from narx.types import FloatArray
from narx.windows.sequences import TrainingSequence

# interval over which changes are compared, s: long enough to exclude tremor
_INTERVAL_S = 0.25
# a larger lag means that the recording's clocks have not been aligned
_LONGEST_LAG_S = 0.05
# with a smaller share of explained variance, target and gyroscope are different motions
_LEAST_EXPLAINED = 0.5
_MIN_INCREMENTS = 100


def target_lag_s(sequences: Sequence[TrainingSequence]) -> float | None:
    """Estimate how late the targets of one trial's segment are.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        Sequences with the same clock.

    Returns
    -------
    float or None
        Lag of the targets behind the gyroscope, s, resolved below one sample; negative if they
        are early. None if they do not follow the gyroscope closely enough.

    Raises
    ------
    UserError
        If the lag is at least 50 ms.

    Notes
    -----
    As `narx.recordings.clock_alignment.estimate_clock_offset`, the gyroscope is averaged over the
    intervals by which the target changes, by the antiderivative of its spline. What is compared
    are the rates of sagittal and frontal angle instead of the angular speed, because a target
    need not have all three angles; the mean of each is left out, as the gyroscope's bias.
    """
    lag_s = _lag_s(sequences)
    if lag_s is not None and abs(lag_s) > 0.99 * _LONGEST_LAG_S:
        raise UserError(
            f"training: the target of {sequences[0].name} is at least "
            f"{1e3 * _LONGEST_LAG_S:g} ms {'late' if lag_s > 0 else 'early'}; align its clock "
            "with the gyroscope's, or set training.align_clock=false"
        )
    if lag_s is None:
        return None
    # repeated with the tilt at the corrected time
    return lag_s + (_lag_s([_earlier(sequence, lag_s) for sequence in sequences]) or 0.0)


def _lag_s(sequences: Sequence[TrainingSequence]) -> float | None:
    motions = [_Motion(sequence) for sequence in sequences]
    variance = sum(float((m.rates_rad_s**2).sum()) for m in motions)
    if sum(len(m.rates_rad_s) for m in motions) < _MIN_INCREMENTS or variance == 0.0:
        return None

    def unexplained(lag_s: float) -> float:
        return sum(m.squares(lag_s) for m in motions) / variance

    best = minimize_scalar(
        unexplained,
        bounds=(-_LONGEST_LAG_S, _LONGEST_LAG_S),
        method="bounded",
        options={"xatol": 1e-6},
    )
    return None if best.fun > 1.0 - _LEAST_EXPLAINED else float(best.x)


def on_gyroscope_clock(sequences: Sequence[TrainingSequence]) -> list[TrainingSequence]:
    """Remove the lag of the targets, trial by trial and segment by segment.

    Parameters
    ----------
    sequences : sequence of TrainingSequence
        Sequences; those with the same name have the same clock.

    Returns
    -------
    list of TrainingSequence
        In the same order, with targets interpolated by cubic splines at the times of the
        gyroscope; NaN where these lie outside. Unchanged where no lag can be estimated.

    Raises
    ------
    UserError
        As `target_lag_s`.
    """
    by_name: dict[str, list[TrainingSequence]] = {}
    for sequence in sequences:
        by_name.setdefault(sequence.name, []).append(sequence)
    lags = {name: target_lag_s(several) for name, several in by_name.items()}
    return [_earlier(sequence, lags[sequence.name] or 0.0) for sequence in sequences]


def _earlier(sequence: TrainingSequence, lag_s: float) -> TrainingSequence:
    if lag_s == 0.0:
        return sequence
    interval_s = sequence.signals.interval_s
    time_s = interval_s * np.arange(sequence.signals.n_samples)
    axes = [
        resample_vectors(time_s, axis[:, None], time_s + lag_s, max_gap_s=1.5 * interval_s)
        for axis in sequence.target_rad.T
    ]
    return replace(sequence, target_rad=np.concatenate(axes, axis=1))


class _Motion:
    """Changes of the target's sagittal and frontal angle, and those measured by the gyroscope."""

    def __init__(self, sequence: TrainingSequence) -> None:
        signals, target = sequence.signals, sequence.target_rad
        time_s = signals.interval_s * np.arange(signals.n_samples)
        tilt = np.column_stack([_filled(axis) for axis in target.T])
        rates = coupled_rates(signals.axis_rates_rad_s, tilt)[:, [SAGITTAL, FRONTAL]]
        self._turned = CubicSpline(time_s, rates).antiderivative()
        n = max(round(_INTERVAL_S / signals.interval_s), 1)
        self._interval_s = n * signals.interval_s
        both = target[:, [SAGITTAL, FRONTAL]]
        rates_rad_s = (both[n:] - both[:-n]) / self._interval_s
        # the spline ends with the recording
        self._seen = np.isfinite(rates_rad_s)
        self._end_s = time_s[n:]
        inside = (self._end_s > self._interval_s + 2 * _LONGEST_LAG_S) & (
            self._end_s < time_s[-1] - 2 * _LONGEST_LAG_S
        )
        self._seen &= inside[:, None]
        self.rates_rad_s = self._centred(rates_rad_s)

    def squares(self, lag_s: float) -> float:
        """Sum of squared differences for a target that is late by `lag_s`."""
        end = self._turned(self._end_s - lag_s)
        begin = self._turned(self._end_s - self._interval_s - lag_s)
        difference = self._centred((end - begin) / self._interval_s) - self.rates_rad_s
        return float((difference**2).sum())

    def _centred(self, rates_rad_s: FloatArray) -> FloatArray:
        """Subtract each axis' mean; zero where the target is missing."""
        seen = np.where(self._seen, rates_rad_s, 0.0)
        mean = seen.sum(axis=0) / np.maximum(self._seen.sum(axis=0), 1)
        return np.where(self._seen, seen - mean, 0.0)


def _filled(angles_rad: FloatArray) -> FloatArray:
    """Interpolate linearly across missing samples; zero if all are missing."""
    known = np.flatnonzero(np.isfinite(angles_rad))
    if not len(known):
        return np.zeros_like(angles_rad)
    return np.interp(np.arange(len(angles_rad)), known, angles_rad[known])
