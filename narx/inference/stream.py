"""Any causal method on samples as they come: one sensor or many, with losses and jitter."""

import copy
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from narx.errors import UserError
from narx.kernels.clock import collect, lay_out
from narx.method import RATE_LIMIT_RAD_S, OrientationMethod, longest_gap_s
from narx.types import BoolArray, FloatArray


class Quality(IntEnum):
    """What stands behind the angles of a sample."""

    GOOD = 0
    """The method as it is meant to run."""
    AFTER_PAUSE = 1
    """First sample after a gap too long to bridge: what was turned in it is not in the angles."""
    MISSING = 2
    """No usable sample: the angles are NaN."""
    STARTING = 3
    """The start-up, whose errors are larger."""


class Estimate(NamedTuple):
    """What a stream answers to a sample or a block of samples.

    Parameters
    ----------
    angles_rad : ndarray, shape (..., 3)
        Sagittal, frontal and transverse angle, rad; NaN where the sample is missing.
    std_rad : ndarray, shape (..., 3), or None
        Standard deviation of their error, rad; None where the method predicts none.
    quality : ndarray of int8, shape (...)
        A `Quality` for each sample.
    """

    angles_rad: FloatArray
    std_rad: FloatArray | None
    quality: NDArray[np.int8]


class OrientationStream:
    """Estimate angles sample by sample, as `OrientationMethod.estimate` does at once.

    A stream can be pickled and copied; the copy goes on by itself. In blocks of any size and
    cut anywhere the angles are the same, to the last bit. Lost samples (NaN) are interpolated
    across once the next one is there, up to `narx.method.MAX_GAP_S`; in longer gaps the method
    pauses.

    Parameters
    ----------
    method : OrientationMethod
        Network or baseline that runs sample by sample.
    sampling_rate_hz : float
        Rate of the method's recursion; for a network its own. Without time stamps samples must
        come at this rate.
    n_sensors : int, optional
        Sensors that run side by side, as first dimension of everything; without it there is
        one and no such dimension.
    initial_angles_rad : array_like, shape (3,) or (n_sensors, 3), optional
        Known start pose (upright standing is zero), rad; None where it is unknown.

    Raises
    ------
    MethodNotApplicableError
        If the method needs the whole recording or runs at another rate.
    UserError
        If a number is not what it must be.

    Examples
    --------
    >>> stream = OrientationStream(pretrained().method(), 100.0)  # doctest: +SKIP
    >>> angles_rad, std_rad, quality = stream.update(axis_rates_rad_s)  # doctest: +SKIP
    """

    def __init__(
        self,
        method: OrientationMethod,
        sampling_rate_hz: float,
        *,
        n_sensors: int | None = None,
        initial_angles_rad: ArrayLike | None = None,
    ) -> None:
        if not (np.isfinite(sampling_rate_hz) and sampling_rate_hz > 0):
            raise UserError(f"sampling_rate_hz is {sampling_rate_hz}, expected a positive number")
        if n_sensors is not None and n_sensors < 1:
            raise UserError(f"n_sensors is {n_sensors}, expected one or more")
        n = 1 if n_sensors is None else int(n_sensors)
        self._lead = () if n_sensors is None else (n,)
        starts = None
        if initial_angles_rad is not None:
            starts = np.array(initial_angles_rad, dtype=np.float64)
            if starts.shape not in ((3,), (n, 3)) or not np.isfinite(starts).all():
                raise UserError(
                    f"initial_angles_rad has the shape {starts.shape}, expected (3,) or ({n}, 3), "
                    "finite"
                )
            starts = np.ascontiguousarray(np.broadcast_to(starts, (n, 3)))
        self._recursion = method.recursion(float(sampling_rate_hz), n, starts)
        self._stds_rad = method.stds_rad()
        self._bridges_gaps = method.bridges_gaps
        self._n_columns = 6 if method.needs_accelerometer else 3
        interval_s = 1.0 / float(sampling_rate_hz)
        self._clock = RATE_LIMIT_RAD_S, interval_s, longest_gap_s(interval_s)
        self._latest = np.zeros((n, self._n_columns)), np.zeros((n, 3))
        self._at_tick = np.full((n, 3), np.nan), np.zeros(n, dtype=np.bool_)
        self._time_s = np.full((n, 1), np.nan)

    def update(self, sample: ArrayLike, time_s: ArrayLike | None = None) -> Estimate:
        """Take the next sample of every sensor.

        Parameters
        ----------
        sample : array_like, shape (3,) or (6,), with sensors (n_sensors, 3) or (n_sensors, 6)
            Rates about the sagittal, frontal and transverse axis without bias, rad/s, and for a
            method that needs it the specific force x, y, z, m/s^2 (`SegmentSignals`). NaN, or a
            rate beyond `narx.method.RATE_LIMIT_RAD_S`, is a missing sample.
        time_s : float or array_like, shape (n_sensors,), optional
            When it was taken, s on any clock that goes on; without it samples follow one another
            at the sampling rate. A time that is not later than the one before is a missing
            sample.

        Returns
        -------
        Estimate
            For this sample.
        """
        block = np.asarray(sample, dtype=np.float64)[..., None, :]
        times = None if time_s is None else np.asarray(time_s, dtype=np.float64)[..., None]
        angles, std, quality = self.update_block(block, times)
        return Estimate(angles[..., 0, :], None if std is None else std[..., 0, :], quality[..., 0])

    def update_block(self, samples: ArrayLike, time_s: ArrayLike | None = None) -> Estimate:
        """Take the next samples of every sensor.

        Parameters
        ----------
        samples : array_like, shape (N, C), with sensors (n_sensors, N, C)
            As for `update`.
        time_s : array_like, shape (N,) or (n_sensors, N), optional
            As for `update`.

        Returns
        -------
        Estimate
            For each sample.

        Raises
        ------
        UserError
            If a shape does not fit.
        """
        values = self._checked(samples)
        shape = values.shape[:2]
        intervals = self._intervals(time_s, shape)
        tick_of, past = np.empty(shape, np.int64), np.empty(shape)
        quality, angles = np.empty(shape, np.int8), np.empty((*shape, 3))
        starting = np.empty(shape, np.bool_)
        if not self._bridges_gaps:
            return self._as_they_are(values, time_s)
        ticks, first = lay_out(
            values, intervals, *self._clock, *self._latest, tick_of, past, quality
        )
        tick_angles, tick_starting = self._recursion.advance(ticks, first)
        collect(
            tick_angles, tick_starting, tick_of, past, values, *self._at_tick,
            angles, starting, quality,
        )  # fmt: skip
        std = None if self._stds_rad is None else self._std(self._stds_rad, starting, quality)
        if self._lead:
            return Estimate(angles, std, quality)
        return Estimate(angles[0], None if std is None else std[0], quality[0])

    def _as_they_are(self, values: FloatArray, time_s: ArrayLike | None) -> Estimate:
        """Leave missing samples to the method, which counts the time that passes."""
        if time_s is not None:
            raise UserError("time_s: this method runs at a fixed rate; give lost samples as NaN")
        n_sensors, n_samples = values.shape[:2]
        first = np.arange(n_sensors + 1) * n_samples
        angles, starting = self._recursion.advance(values.reshape(-1, values.shape[2]), first)
        angles = angles.reshape(n_sensors, n_samples, 3)
        quality = np.where(starting, Quality.STARTING, Quality.GOOD).astype(np.int8)
        quality = quality.reshape(n_sensors, n_samples)
        quality[np.isnan(angles).any(axis=2)] = Quality.MISSING
        return (
            Estimate(angles, None, quality) if self._lead else Estimate(angles[0], None, quality[0])
        )

    def state_dict(self) -> dict[str, Any]:
        """Take a copy of the state.

        Returns
        -------
        dict
            For `load_state_dict` of a stream made with the same arguments.
        """
        return copy.deepcopy(vars(self))

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go on from a copied state.

        Parameters
        ----------
        state : dict
            From `state_dict`; not changed.

        Raises
        ------
        UserError
            If it is that of a stream of another kind.
        """
        if set(state) != set(vars(self)) or state["_lead"] != self._lead:
            raise UserError("the state is that of another kind of stream")
        vars(self).update(copy.deepcopy(state))

    def _checked(self, samples: ArrayLike) -> FloatArray:
        values = np.asarray(samples, dtype=np.float64)
        n, expected = len(self._time_s), self._n_columns
        if values.ndim == 2 + len(self._lead) and values.shape[-1] in (expected, 6):
            values = values[..., :expected] if self._lead else values[None, :, :expected]
            if len(values) == n:
                return np.ascontiguousarray(values)
        lead = "".join(f"{size}, " for size in self._lead)
        raise UserError(
            f"samples have the shape {np.shape(samples)}, expected ({lead}N, {expected})"
        )

    def _intervals(self, time_s: ArrayLike | None, shape: tuple[int, ...]) -> FloatArray:
        interval_s = self._clock[1]
        if time_s is None:
            return np.broadcast_to(interval_s, shape)
        times = np.asarray(time_s, dtype=np.float64)
        try:
            times = np.broadcast_to(times, shape)
        except ValueError as error:
            raise UserError(f"time_s has the shape {times.shape}, expected {shape}") from error
        times = np.concatenate([self._time_s, times], axis=1)
        # a time that goes back or is missing does not count; the next one does, from the latest
        running = np.fmax.accumulate(times, axis=1)
        self._time_s = running[:, -1:]
        with np.errstate(invalid="ignore"):
            intervals = running[:, 1:] - running[:, :-1]
        intervals[np.isnan(intervals) & np.isfinite(times[:, 1:])] = interval_s  # the first one
        return intervals

    @staticmethod
    def _std(stds_rad: FloatArray, starting: BoolArray, quality: NDArray[np.int8]) -> FloatArray:
        std = stds_rad[starting.astype(np.intp)]
        std[quality == Quality.MISSING] = np.nan
        return std
