"""Compare an export with the package before its file is written."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from narx.errors import UserError
from narx.inference.checkpoint import Checkpoint
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import axis_rates, orientation_from_angles
from narx.types import FloatArray

TOLERANCE_RAD = {"double": 1e-9, "float": 1e-4}
SIGNALS = "a walk with rest, turn, slip and losses, and noise with losses; known and unknown start"
# a dozen swings for a tracker to correct by; what follows a start-up, s; samples at most
_TRACKED_S, _AFTER_S, _MOST_SAMPLES = 16.0, 9.0, 20_000
_LOST = 0.02
_STARTS = np.array([[0.0, 0.0, 0.0], [0.3, -0.1, 0.2]])
_GRAVITY_M_S2 = 9.81

# (inputs (B, N, C), interval_s (B, N), start (B, 3) or None) -> angles (B, N, 3)
Runner = Callable[[FloatArray, FloatArray, FloatArray | None], FloatArray]


def walk(time_s: FloatArray) -> FloatArray:
    """Make the signals of a leg: rest, walk with a turn and a slip of the sensor, rest.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Times, from zero.

    Returns
    -------
    ndarray, shape (N, 6)
        Rates with a bias, rad/s, and specific force, m/s^2.
    """

    def angles(time: FloatArray) -> FloatArray:
        walks = np.clip(time - 1.5, 0.0, 1.0) * np.clip(time_s[-1] - 1.0 - time, 0.0, 1.0)
        phase = 2.0 * np.pi * 0.9 * time
        turn = 1.2 * np.clip(0.3 * (time - 0.4 * time_s[-1]), 0.0, 1.0)
        slip = 0.3 * np.clip(2.0 * (time - 0.7 * time_s[-1]), 0.0, 1.0)
        return np.column_stack(
            [
                walks * (0.35 * np.sin(phase) + 0.08 * np.sin(2.0 * phase + 0.5)) + slip,
                walks * 0.06 * np.sin(phase + 1.0),
                walks * 0.1 * np.sin(phase + 2.0) + turn,
            ]
        )

    step_s = 1e-4
    turned = [_rotation(angles(time_s + shift)) for shift in (-step_s, 0.0, step_s)]
    rates = axis_rates((turned[0].inv() * turned[2]).as_rotvec() / (2.0 * step_s))
    bias = np.radians([0.4, -0.3, 0.2])
    return np.hstack([rates + bias, turned[1].inv().apply([0.0, 0.0, _GRAVITY_M_S2])])


def _rotation(angles_rad: FloatArray) -> Rotation:
    return Rotation.from_quat(orientation_from_angles(angles_rad), scalar_first=True)


def signals(checkpoint: Checkpoint) -> tuple[FloatArray, FloatArray]:
    """Create the signals for verification.

    Parameters
    ----------
    checkpoint : Checkpoint
        Gives the sampling rate and the length of the start-up.

    Returns
    -------
    inputs : ndarray, shape (2, N, 6)
        A walk and noise, rates and forces; 2 % of the samples lost, in gaps of one to a dozen, one
        beyond the limit.
    interval_s : ndarray, shape (2, N)
        Regular for the walk, with jitter for the noise.
    """
    rng = np.random.default_rng(0)
    rate_hz = checkpoint.model.sampling_rate_hz
    tracked = checkpoint.tracker is not None
    seconds = _TRACKED_S if tracked else checkpoint.start_up.duration_s + _AFTER_S
    n_samples = min(round(seconds * rate_hz), _MOST_SAMPLES)
    interval_s = np.full((2, n_samples), 1.0 / rate_hz)
    interval_s[1] *= 1.0 + 0.3 * rng.uniform(-1.0, 1.0, n_samples)
    inputs = 0.02 * rng.normal(size=(2, n_samples, 6))
    inputs[0] += walk(np.arange(n_samples) / rate_hz)
    inputs[1, :, :3] += rng.normal(size=(n_samples, 3))
    inputs[1, :, 3:] += np.array([0.5, -0.3, 9.7]) + rng.normal(size=(n_samples, 3))
    inputs[rng.random((2, n_samples)) < _LOST] = np.nan
    for begin in rng.integers(n_samples, size=4):
        inputs[:, begin : begin + rng.integers(2, 13)] = np.nan
    inputs[:, n_samples // 2, 1] = 1e30
    return inputs, interval_s


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
    method = checkpoint.method()
    inputs: FloatArray
    interval_s: FloatArray
    inputs, interval_s = (np.asarray(part, dtype) for part in signals(checkpoint))
    inputs = np.ascontiguousarray(inputs[..., : 6 if method.needs_accelerometer else 3])
    worst = 0.0
    starts: tuple[FloatArray | None, ...] = (None, _STARTS.astype(dtype))
    for start in starts:
        stream = OrientationStream(
            method, checkpoint.model.sampling_rate_hz, n_sensors=2, initial_angles_rad=start
        )
        times = np.cumsum(interval_s.astype(np.float64), axis=1)
        expected = stream.update_block(inputs, times).angles_rad
        found = run(inputs, interval_s, start)
        if (np.isnan(found) != np.isnan(expected)).any():
            return float("nan")
        worst = max(worst, float(np.nanmax(np.abs(found - expected))))
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
