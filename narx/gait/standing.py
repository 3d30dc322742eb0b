"""Standing and walking parts of a recording, detected from one IMU."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from narx.errors import MethodNotApplicableError
from narx.recordings.trial import GRAVITY_M_S2
from narx.types import BoolArray, FloatArray

# a sensor that is put on or taken off during the recording also moves outside the walk
_MOST_MOVEMENT_OUTSIDE = 0.25


@dataclass(frozen=True)
class StillThresholds:
    """Thresholds of standing still (Han et al., eqs. (3) and (4)).

    Parameters
    ----------
    gravity_fraction : float
        Largest deviation of the accelerometer's norm from 1 g, in g (lambda_1).
    rate_rad_s : float
        Largest angular rate about any axis, rad/s (lambda_2: 10 degrees/s).
    duration_s : float
        Shortest time for which both must hold, s (lambda_3: 50 samples at 100 Hz).

    Notes
    -----
    Eq. (3) is printed as ``1 - |norm| < lambda_1``, which lets any acceleration above 1 g pass
    as still; ``|1 - norm| < lambda_1`` is meant.
    """

    gravity_fraction: float = 0.07
    rate_rad_s: float = float(np.deg2rad(10.0))
    duration_s: float = 0.5

    def raised_for_shaky_legs(
        self,
        axis_rates_rad_s: ArrayLike,
        specific_force_m_s2: ArrayLike,
        sampling_rate_hz: float,
        margin: float = 2.0,
    ) -> "StillThresholds":
        """Raise the thresholds above the tremor in the first second (Han et al., section IV).

        Parameters
        ----------
        axis_rates_rad_s : array_like, shape (N, 3)
            Angular rates; the recording must begin with standing.
        specific_force_m_s2 : array_like, shape (N, 3)
            Accelerometer.
        sampling_rate_hz : float
            Sampling rate.
        margin : float
            Factor on the mean deviation in the first second. The paper says 'slightly higher than
            the average'; the peaks of a sinusoidal tremor are pi / 2 times its mean magnitude, so
            any factor below 1.6 would still interrupt every run.

        Returns
        -------
        StillThresholds
            No threshold is lower than its value in this object.
        """
        first = slice(0, max(1, round(sampling_rate_hz)))
        rate, gravity = _deviation(axis_rates_rad_s, specific_force_m_s2)
        rate, gravity = rate[first], gravity[first]
        valid = np.isfinite(rate) & np.isfinite(gravity)
        if not valid.any():
            return self
        return replace(
            self,
            rate_rad_s=max(self.rate_rad_s, margin * float(rate[valid].mean())),
            gravity_fraction=max(self.gravity_fraction, margin * float(gravity[valid].mean())),
        )


def _deviation(
    axis_rates_rad_s: ArrayLike, specific_force_m_s2: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Largest rate of the three axes, and deviation of the norm from 1 g, in g."""
    rate = np.abs(np.asarray(axis_rates_rad_s, dtype=float)).max(axis=1)
    norm = np.linalg.norm(np.asarray(specific_force_m_s2, dtype=float), axis=1)
    return rate, np.abs(1.0 - norm / GRAVITY_M_S2)


def still_samples(
    axis_rates_rad_s: ArrayLike,
    specific_force_m_s2: ArrayLike,
    sampling_rate_hz: float,
    thresholds: StillThresholds | None = None,
) -> BoolArray:
    """Mark the samples at which the wearer stands still.

    Parameters
    ----------
    axis_rates_rad_s : array_like, shape (N, 3)
        Angular rates, rad/s; NaN where missing.
    specific_force_m_s2 : array_like, shape (N, 3)
        Accelerometer, m/s^2; NaN where missing.
    sampling_rate_hz : float
        Sampling rate.
    thresholds : StillThresholds, optional
        Default: those of Han et al.

    Returns
    -------
    ndarray of bool, shape (N,)
        True within runs that are long enough. A missing sample is not still.
    """
    limits = thresholds or StillThresholds()
    rate, gravity = _deviation(axis_rates_rad_s, specific_force_m_s2)
    quiet = (rate < limits.rate_rad_s) & (gravity < limits.gravity_fraction)
    return _keep_long_runs(quiet, max(1, round(limits.duration_s * sampling_rate_hz)))


def runs(flags: BoolArray) -> list[tuple[int, int]]:
    """List the runs of True.

    Parameters
    ----------
    flags : ndarray of bool, shape (N,)
        Any flags.

    Returns
    -------
    list of (int, int)
        First and one-past-last index of each run.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def _keep_long_runs(flags: BoolArray, shortest: int) -> BoolArray:
    kept = np.zeros(len(flags), dtype=bool)
    for begin, end in runs(flags):
        if end - begin >= shortest:
            kept[begin:end] = True
    return kept


def start_and_stop(
    axis_rates_rad_s: ArrayLike,
    specific_force_m_s2: ArrayLike,
    sampling_rate_hz: float,
    thresholds: StillThresholds | None = None,
) -> tuple[int, int] | None:
    """Find the sample at which a walk starts (A) and stops (B) (Han et al., Fig. 5).

    Parameters
    ----------
    axis_rates_rad_s : array_like, shape (N, 3)
        Angular rates, rad/s; NaN where missing.
    specific_force_m_s2 : array_like, shape (N, 3)
        Accelerometer, m/s^2; NaN where missing.
    sampling_rate_hz : float
        Sampling rate.
    thresholds : StillThresholds, optional
        Default: those of Han et al.

    Returns
    -------
    tuple of (int, int) or None
        Last still sample before and first still sample after the walk; None if the whole recording
        is still.

    Raises
    ------
    MethodNotApplicableError
        If there is no still part before or after the walk (the message names which, and the time
        that was searched), or if the still parts found are pauses within a longer walk.

    Notes
    -----
    The paper searches outwards from the middle of the recording. Here the search starts at the
    median of the samples that are not still: the same sample where the person stands equally long
    before and after, and inside the walk in any other case.
    """
    limits = thresholds or StillThresholds()
    rates = np.asarray(axis_rates_rad_s, dtype=float)
    force = np.asarray(specific_force_m_s2, dtype=float)
    still = still_samples(rates, force, sampling_rate_hz, limits)
    valid = np.isfinite(rates).all(axis=1) & np.isfinite(force).all(axis=1)
    moving = np.flatnonzero(valid & ~still)
    if not moving.size:
        return None
    middle = int(moving[len(moving) // 2])
    before, after = np.flatnonzero(still[:middle]), np.flatnonzero(still[middle:])
    wanted = (
        f"none of {limits.duration_s:g} s with the accelerometer within "
        f"{limits.gravity_fraction:.3g} g of 1 g and every rate below "
        f"{np.rad2deg(limits.rate_rad_s):.3g} deg/s"
    )
    if not before.size:
        raise MethodNotApplicableError(
            f"no still part before the walk: {wanted} in the first "
            f"{middle / sampling_rate_hz:.1f} s"
        )
    if not after.size:
        raise MethodNotApplicableError(
            f"no still part after the walk: {wanted} in the last "
            f"{(len(rates) - 1 - middle) / sampling_rate_hz:.1f} s"
        )
    start, stop = int(before[-1]), middle + int(after[0])
    outside = float(np.mean((moving < start) | (moving > stop)))
    if outside > _MOST_MOVEMENT_OUTSIDE:
        raise MethodNotApplicableError(
            f"no still part before and after the walk: the nearest end at "
            f"{start / sampling_rate_hz:.1f} s and begin at {stop / sampling_rate_hz:.1f} s, "
            f"but {outside:.0%} of the movement lies outside, so they are pauses in it"
        )
    return start, stop
