"""Align an inertial sensor and an optical reference: one clock and one body frame.

Both measure the rotation of the same rigid body. Its angular speed does not depend on the frame,
which gives the clock offset; with the clocks aligned, the angular velocities give the constant
rotation between the tracked body frame and the sensor frame.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from narx.errors import RecordingError
from narx.types import FloatArray

# an interval whose rates differ by this many times the median difference is a tracking fault
_OUTLIER_FACTOR = 5.0
_MIN_INTERVALS = 20
# a lower correlation means that the two did not measure the same motion
_MIN_CORRELATION = 0.5
# an interval longer than this many median intervals is a gap
_GAP_FACTOR = 3.5
# largest plausible rate of a tracked body, as a multiple of its gyroscope's fastest rate
_JUMP_FACTOR = 2.0


@dataclass(frozen=True)
class Misalignment:
    """Constant rotation between the tracked frame and the sensor.

    Parameters
    ----------
    body_to_sensor : Rotation
        Maps vectors in the tracked body frame to the sensor frame.
    rate_offset_rad_s : ndarray, shape (3,)
        Constant sensor rate of the fit: the gyroscope's bias, rad/s.
    residual_rad_s : float
        Root mean square residual of the fit by rotation and offset, per axis, rad/s.
    inlier_share : float
        Fraction of intervals that were used; the others are tracking faults.
    slope : float
        Regression of the sensor's rates on those of the body; 1 if the units agree.
    explained : float
        Share of the variance of the sensor's rates that rotation and slope explain: near 1 for one
        rigid body.
    explained_mirrored : float
        The same for the best reflection: above `explained` only if axes are exchanged or mirrored.
    """

    body_to_sensor: Rotation
    rate_offset_rad_s: FloatArray
    residual_rad_s: float
    inlier_share: float
    slope: float
    explained: float
    explained_mirrored: float


def _check_increasing(what: str, time_s: FloatArray) -> None:
    # a clock shifted by 1e20 s has no digits left for the intervals
    if not (np.isfinite(time_s).all() and (np.diff(time_s) > 0).all()):
        raise RecordingError(
            f"clock alignment: the times of the {what} do not increase, from {time_s[0]:g} to "
            f"{time_s[-1]:g} s"
        )


class _MeanRates:
    """Mean angular velocities over the reference's intervals, from both systems.

    A reference gives the rotation over an interval, so the gyroscope is averaged over the same
    interval (by the antiderivative of its spline) rather than sampled at its middle.
    """

    def __init__(
        self,
        imu_time_s: ArrayLike,
        gyroscope_rad_s: ArrayLike,
        reference_time_s: ArrayLike,
        quaternion_wxyz: ArrayLike,
        interval_s: float,
    ) -> None:
        imu_time = np.asarray(imu_time_s, dtype=float)
        gyroscope = np.asarray(gyroscope_rad_s, dtype=float)
        valid = np.isfinite(gyroscope).all(axis=1)
        if valid.sum() < _MIN_INTERVALS:
            raise RecordingError("clock alignment: too few gyroscope samples")
        imu_time, gyroscope = imu_time[valid], gyroscope[valid]
        _check_increasing("sensor", imu_time)
        self._first, self._last = imu_time[[0, -1]]
        self._integral = CubicSpline(imu_time, gyroscope).antiderivative()
        # values of the spline between two distant samples must not be compared
        apart = np.flatnonzero(np.diff(imu_time) > _GAP_FACTOR * np.median(np.diff(imu_time)))
        self._gap_begin_s, self._gap_end_s = imu_time[apart], imu_time[apart + 1]
        time = np.asarray(reference_time_s, dtype=float)
        quaternion = np.asarray(quaternion_wxyz, dtype=float)
        _check_increasing("reference", time)
        step = float(np.median(np.diff(time)))
        n = max(1, round(interval_s / step))
        seen = np.isfinite(quaternion).all(axis=1)
        begin = np.flatnonzero(seen[:-n] & seen[n:] & (time[n:] - time[:-n] < (n + 0.5) * step))
        if begin.size < _MIN_INTERVALS:
            raise RecordingError(
                f"clock alignment: only {begin.size} intervals of the reference are valid, "
                f"expected at least {_MIN_INTERVALS}"
            )
        self._begin_s, self._end_s = time[begin], time[begin + n]
        turn = Rotation.from_quat(quaternion[begin], scalar_first=True).inv() * Rotation.from_quat(
            quaternion[begin + n], scalar_first=True
        )
        self._reference = turn.as_rotvec() / (self._end_s - self._begin_s)[:, None]

    def at(self, lag_s: float) -> tuple[FloatArray, FloatArray]:
        """Return sensor and reference rates, (K, 3) each, for a sensor clock late by `lag_s`."""
        begin, end = self._begin_s + lag_s, self._end_s + lag_s
        both = (begin >= self._first) & (end <= self._last)
        gaps_begun = np.searchsorted(self._gap_begin_s, end, side="left")
        both &= gaps_begun == np.searchsorted(self._gap_end_s, begin, side="right")
        begin, end = begin[both], end[both]
        mean = (self._integral(end) - self._integral(begin)) / (end - begin)[:, None]
        return mean, self._reference[both]

    def speed_correlation(self, lag_s: float) -> float:
        sensor, reference = (np.linalg.norm(rate, axis=1) for rate in self.at(lag_s))
        # a reference with jumps (swapped markers) has speeds that are not motion
        possible = reference <= _JUMP_FACTOR * sensor.max(initial=0.0)
        sensor, reference = sensor[possible], reference[possible]
        if sensor.size < _MIN_INTERVALS or sensor.std() == 0.0 or reference.std() == 0.0:
            return -1.0
        return float(np.corrcoef(sensor, reference)[0, 1])


def estimate_clock_offset(
    imu_time_s: ArrayLike,
    gyroscope_rad_s: ArrayLike,
    reference_time_s: ArrayLike,
    quaternion_wxyz: ArrayLike,
    *,
    max_offset_s: float = 0.5,
    interval_s: float = 1.0 / 60.0,
) -> tuple[float, float]:
    """Estimate the lag of the inertial clock behind that of the reference.

    Parameters
    ----------
    imu_time_s : array_like, shape (N,)
        The gyroscope's clock, s.
    gyroscope_rad_s : array_like, shape (N, 3)
        Angular rate, static bias removed, rad/s; NaN where missing.
    reference_time_s : array_like, shape (M,)
        The reference's clock, s.
    quaternion_wxyz : array_like, shape (M, 4)
        Orientation of the tracked body; NaN where missing.
    max_offset_s : float
        Offsets from minus to plus this are considered, s.
    interval_s : float
        Intervals over which the reference is differentiated, at least one of its samples, s.

    Returns
    -------
    offset_s : float
        An event at reference time t is at inertial time ``t + offset_s``; resolved below one
        sample.
    correlation : float
        Pearson correlation of the two angular speeds at that offset.

    Raises
    ------
    RecordingError
        If either is too short, or the best correlation is below 0.5 or at the end of the range: the
        two did not measure the same motion.

    Notes
    -----
    The correlation is computed at each lag from the samples that both systems have, so gaps and
    different rates need no special treatment; it is scanned in steps of 5 ms and its peak refined.
    """
    rates = _MeanRates(imu_time_s, gyroscope_rad_s, reference_time_s, quaternion_wxyz, interval_s)
    step = 0.005
    lags = np.arange(-np.ceil(max_offset_s / step), np.ceil(max_offset_s / step) + 1) * step
    correlations = [rates.speed_correlation(lag) for lag in lags]
    best = int(np.argmax(correlations))
    if correlations[best] < _MIN_CORRELATION or best in (0, len(lags) - 1):
        raise RecordingError(
            f"clock alignment: no offset within {max_offset_s:g} s makes the angular speeds of "
            f"sensor and reference agree (best correlation {correlations[best]:.2f} at "
            f"{lags[best]:.3f} s)"
        )
    peak = minimize_scalar(
        lambda lag: -rates.speed_correlation(lag),
        bounds=(lags[best - 1], lags[best + 1]),
        method="bounded",
        options={"xatol": 1e-6},
    )
    return float(peak.x), float(-peak.fun)


def estimate_misalignment(
    imu_time_s: ArrayLike,
    gyroscope_rad_s: ArrayLike,
    reference_time_s: ArrayLike,
    quaternion_wxyz: ArrayLike,
    *,
    offset_s: float = 0.0,
    interval_s: float = 1.0 / 60.0,
) -> Misalignment:
    """Estimate the constant rotation between the tracked body and the sensor.

    Parameters
    ----------
    imu_time_s : array_like, shape (N,)
        The gyroscope's clock, s.
    gyroscope_rad_s : array_like, shape (N, 3)
        Angular rate in the sensor frame, rad/s; NaN where missing.
    reference_time_s : array_like, shape (M,)
        The reference's clock, s.
    quaternion_wxyz : array_like, shape (M, 4)
        Orientation of the tracked body in the global frame; NaN where missing.
    offset_s : float
        Clock offset as from `estimate_clock_offset`, s.
    interval_s : float
        Intervals over which the reference is differentiated, at least one of its samples, s.

    Returns
    -------
    Misalignment
        Rotation, rate offset, residual.

    Raises
    ------
    RecordingError
        If either is too short.

    Notes
    -----
    Kabsch's least-squares rotation between centred angular velocities (the centring is the exact
    solution for a constant gyroscope bias), once over all intervals and once more without those
    beyond five times the median residual: tracking faults of single frames.
    """
    sensor, body = _MeanRates(
        imu_time_s, gyroscope_rad_s, reference_time_s, quaternion_wxyz, interval_s
    ).at(offset_s)
    if len(sensor) < _MIN_INTERVALS:
        raise RecordingError("misalignment: sensor and reference share too few samples")
    use = np.ones(len(sensor), dtype=bool)
    for _ in range(2):
        rotation, _rssd = Rotation.align_vectors(
            sensor[use] - sensor[use].mean(axis=0), body[use] - body[use].mean(axis=0)
        )
        offset = sensor[use].mean(axis=0) - rotation.apply(body[use].mean(axis=0))
        residual = sensor - rotation.apply(body) - offset
        used = use
        size = np.linalg.norm(residual, axis=1)
        use = size <= _OUTLIER_FACTOR * max(float(np.median(size)), 1e-12)
    measured = sensor[used] - sensor[used].mean(axis=0)
    tracked = rotation.apply(body[used] - body[used].mean(axis=0))
    shared, power, tracked_power = (
        float(np.sum(a * b))
        for a, b in ((measured, tracked), (measured, measured), (tracked, tracked))
    )
    moves = power > 0.0 and tracked_power > 0.0
    # the best reflection shares as much along the first two principal directions
    covariance = measured.T @ tracked
    third = float(np.linalg.svd(covariance, compute_uv=False)[-1])
    reflected = shared - 2.0 * third * float(np.sign(np.linalg.det(covariance)))
    return Misalignment(
        rotation,
        offset,
        float(np.sqrt(np.mean(residual[used] ** 2))),
        float(used.mean()),
        shared / tracked_power if moves else 0.0,
        max(shared, 0.0) ** 2 / (power * tracked_power) if moves else 0.0,
        max(reflected, 0.0) ** 2 / (power * tracked_power) if moves else 0.0,
    )


def estimate_heading_misalignment(
    imu_time_s: ArrayLike,
    rate_rad_s: ArrayLike,
    reference_time_s: ArrayLike,
    quaternion_wxyz: ArrayLike,
    *,
    interval_s: float = 0.03,
) -> float:
    """Estimate the constant angle about z between two frames that agree about z.

    Parameters
    ----------
    imu_time_s : array_like, shape (N,)
        The gyroscope's clock, the same as the reference's, s.
    rate_rad_s : array_like, shape (N, 3)
        Angular rate in the sensor's upright frame, rad/s; NaN where missing.
    reference_time_s : array_like, shape (M,)
        Times of the reference, s.
    quaternion_wxyz : array_like, shape (M, 4)
        Orientation of the tracked upright frame; NaN where missing.
    interval_s : float
        Intervals over which the reference is differentiated, s.

    Returns
    -------
    float
        Angle in rad of the rotation about z from reference vectors to sensor vectors.

    Raises
    ------
    RecordingError
        If either is too short.

    Notes
    -----
    The two-dimensional least-squares rotation between the horizontal parts of the rates, once
    over all intervals and once without outliers, as in `estimate_misalignment`.
    """
    sensor, body = _MeanRates(
        imu_time_s, rate_rad_s, reference_time_s, quaternion_wxyz, interval_s
    ).at(0.0)
    to, of = (rate[:, 0] + 1j * rate[:, 1] for rate in (sensor, body))
    to, of = to - to.mean(), of - of.mean()
    use = np.ones(len(to), dtype=bool)
    for _ in range(2):
        angle = float(np.angle(np.sum(to[use] * of[use].conj())))
        size = np.abs(to - of * np.exp(1j * angle))
        use = size <= _OUTLIER_FACTOR * max(float(np.median(size)), 1e-12)
    return angle
