"""Compare an export with the package before its file is written."""

from collections.abc import Callable

import numpy as np

from narx.errors import UserError
from narx.inference.checkpoint import Checkpoint
from narx.inference.stream import OrientationStream
from narx.method import SegmentSignals
from narx.types import FloatArray

TOLERANCE_RAD = {"double": 1e-9, "float": 1e-4}
# with the digits of float in its covariances, the last digit can decide whether a swing is used
TRACKED_TOLERANCE_RAD = {"double": 1e-8, "float": 1e-2}
# time simulated after the start-up, s, and the largest number of samples
_AFTER_S, _MOST_SAMPLES = 8.0, 20_000
_LOST = 0.02
_STARTS = np.array([[0.0, 0.0, 0.0], [0.3, -0.1, 0.2]])

# (axis_rates (B, N, 3), interval_s (B, N), start (B, 3) or None) -> angles (B, N, 3)
Runner = Callable[[FloatArray, FloatArray, FloatArray | None], FloatArray]


def signals(checkpoint: Checkpoint) -> tuple[FloatArray, FloatArray]:
    """Create the signals for verification.

    Parameters
    ----------
    checkpoint : Checkpoint
        Gives the sampling rate and the length of the start-up.

    Returns
    -------
    axis_rates : ndarray, shape (2, N, 3)
        A walk after one second of standing, and noise; 2 % of the samples are lost in gaps of one
        to a dozen samples, and one sample is beyond the limit.
    interval_s : ndarray, shape (2, N)
        Regular for the walk, with jitter for the noise.
    """
    rng = np.random.default_rng(0)
    rate_hz = checkpoint.model.sampling_rate_hz
    seconds = 1.0 + checkpoint.start_up.duration_s + _AFTER_S
    n_samples = min(round(seconds * rate_hz), _MOST_SAMPLES)
    interval_s = np.full((2, n_samples), 1.0 / rate_hz)
    interval_s[1] *= 1.0 + 0.3 * rng.uniform(-1.0, 1.0, n_samples)
    time_s = np.cumsum(interval_s, axis=1)
    phase = 2.0 * np.pi * 0.9 * time_s[0, :, None]
    axis_rates = 0.02 * rng.normal(size=(2, n_samples, 3))
    swing = [2.0, 0.4, 0.7] * np.cos(phase) + [0.8, 0.3, 0.2] * np.cos(2 * phase + [0.5, 1.0, 2.0])
    axis_rates[0] += np.where(time_s[0, :, None] < 1.0, 0.0, swing)
    axis_rates[1] += rng.normal(size=(n_samples, 3))
    axis_rates[rng.random((2, n_samples)) < _LOST] = np.nan
    for begin in rng.integers(n_samples, size=4):
        axis_rates[:, begin : begin + rng.integers(2, 13)] = np.nan
    axis_rates[:, n_samples // 2, 1] = 1e30
    return axis_rates, interval_s


def largest_difference_rad(checkpoint: Checkpoint, run: Runner, dtype: type) -> float:
    """Compare an export with the package.

    Parameters
    ----------
    checkpoint : Checkpoint
        The exported network.
    run : callable
        Runs the export.
    dtype : type
        Type of its numbers; both are given the same inputs.

    Returns
    -------
    float
        Largest difference of an angle, rad, over `signals` from an unknown and a known start; NaN
        if an angle is missing in only one of the two.
    """
    axis_rates: FloatArray
    interval_s: FloatArray
    axis_rates, interval_s = (np.asarray(part, dtype) for part in signals(checkpoint))
    worst = 0.0
    starts: tuple[FloatArray | None, ...] = (None, _STARTS.astype(dtype))
    for start in starts:
        stream = OrientationStream(
            checkpoint.method(),
            checkpoint.model.sampling_rate_hz,
            n_sensors=2,
            initial_angles_rad=start,
        )
        times = np.cumsum(interval_s.astype(np.float64), axis=1)
        expected = stream.update_block(axis_rates, times).angles_rad
        difference = np.abs(run(axis_rates, interval_s, start) - expected)
        if (np.isnan(difference) != np.isnan(expected)).any():
            return float("nan")
        worst = max(worst, float(np.nanmax(difference)))
    return worst


def tracked_difference_rad(checkpoint: Checkpoint, run: Runner, dtype: type) -> float:
    """Compare an export with a tracker, which has a fixed sampling rate, with the package.

    Parameters
    ----------
    checkpoint : Checkpoint
        The exported network.
    run : callable
        Runs the export; the intervals are ignored.
    dtype : type
        Type of its numbers.

    Returns
    -------
    float
        As `largest_difference_rad`.
    """
    axis_rates, interval_s = signals(checkpoint)
    axis_rates[np.abs(axis_rates) > 1e3] = np.nan
    force = np.array([0.5, -0.3, 9.7]) + 0.3 * axis_rates
    worst = 0.0
    starts: tuple[FloatArray | None, ...] = (None, _STARTS.astype(dtype))
    for start in starts:
        poses = (None, None) if start is None else start
        given: FloatArray = np.concatenate([axis_rates, force], axis=2).astype(dtype)
        n_inputs = 6 if checkpoint.tracker and checkpoint.tracker.aided else 3
        found = run(np.ascontiguousarray(given[..., :n_inputs]), interval_s, start)
        for sensor, pose in enumerate(poses):
            rates, forces = np.split(given[sensor].astype(np.float64), 2, axis=1)
            known = None if pose is None else np.asarray(pose, np.float64)
            rate_hz = checkpoint.model.sampling_rate_hz
            expected = checkpoint.method().estimate(
                SegmentSignals("segment", rate_hz, rates, forces, known)
            )
            difference = np.abs(found[sensor] - expected)
            if (np.isnan(difference) != np.isnan(expected)).any():
                return float("nan")
            worst = max(worst, float(np.nanmax(difference)))
    return worst


def refuse_above_tolerance(difference_rad: float, tolerance_rad: float, export_format: str) -> None:
    """Refuse an export that differs from the package.

    Parameters
    ----------
    difference_rad : float
        From `largest_difference_rad`.
    tolerance_rad : float
        Largest difference allowed.
    export_format : str
        Format, for the message.

    Raises
    ------
    UserError
        If it is too large.
    """
    if not difference_rad <= tolerance_rad:
        raise UserError(
            f"format={export_format}: the export differs from the package by {difference_rad:.1e} "
            f"rad, expected at most {tolerance_rad:g}; no file was written"
        )
