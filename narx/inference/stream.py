"""Run any causal method sample by sample: one or many sensors, with lost samples and jitter."""

import copy
import hashlib
import pickle
from collections.abc import Mapping
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from narx.errors import UserError
from narx.method import OrientationMethod
from narx.recordings.stamps import checked_rate_hz
from narx.settings import real_numbers
from narx.settings.wording import shown
from narx.types import FloatArray

_new = tuple.__new__
# tilts, and a heading, that can be meant: a number of degrees mostly exceeds them
_MOST_START_RAD = np.array([np.pi, np.pi, 2 * np.pi])
# some kilobytes each
_MOST_SENSORS = 1_000_000


class Quality(IntEnum):
    """Quality of the angles of a sample."""

    GOOD = 0
    """Regular operation of the method."""
    AFTER_PAUSE = 1
    """First sample after a gap longer than `narx.method.MAX_GAP_S`; rotation in it is lost, or
    with a tracker and below 0.35 s estimated roughly."""
    MISSING = 2
    """No usable sample: the angles are NaN."""
    STARTING = 3
    """Start-up, or no walking: the rates are integrated, and errors are larger."""
    DOUBTFUL = 4
    """With a tracker: the motion does not resemble the swing of a leg, which is faster forward than
    backward, or a tilt angle was corrected by several degrees in the last seconds; errors are
    larger."""


class Estimate(NamedTuple):
    """Result of a stream for a sample or a block of samples.

    Parameters
    ----------
    angles_rad : ndarray, shape (..., 3)
        Sagittal, frontal and transverse angle, rad; NaN where the sample is missing.
    std_rad : ndarray, shape (..., 3), or None
        Standard deviation of their error, rad; None if the method predicts none.
    quality : ndarray of int8, shape (...)
        A `Quality` for each sample.
    """

    angles_rad: FloatArray
    std_rad: FloatArray | None
    quality: NDArray[np.int8]


class OrientationStream:
    """Estimate angles sample by sample, as `OrientationMethod.estimate` does for whole recordings.

    A stream can be pickled and copied; the copy is independent. The angles do not depend on how the
    samples are divided into blocks, to the last bit. Lost samples (NaN) are interpolated once the
    next one has arrived, up to `narx.method.MAX_GAP_S`; in longer gaps the method pauses; a
    tracker accounts for the elapsed time, and interpolates below 0.35 s with a larger uncertainty.

    Parameters
    ----------
    method : OrientationMethod
        Network or baseline that runs sample by sample.
    sampling_rate_hz : float
        Rate of the method's recursion, which for a network is its own. Without time stamps, samples
        must have this rate.
    n_sensors : int, optional
        Number of sensors that run in parallel, the first dimension of all arrays; by default there
        is one sensor and no such dimension.
    initial_angles_rad : array_like, shape (3,) or (n_sensors, 3), optional
        Known start pose (upright standing is zero), rad; None if it is unknown.

    Raises
    ------
    MethodNotApplicableError
        If the method needs the whole recording or runs at a different rate.
    UserError
        If an argument is invalid.

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
        if not isinstance(method, OrientationMethod):
            raise UserError(
                f"method is a {type(method).__name__}, expected a method, e.g. checkpoint.method()"
            )
        rate_hz = checked_rate_hz(sampling_rate_hz, "sampling_rate_hz")
        if n_sensors is not None and not (
            isinstance(n_sensors, int | np.integer) and 1 <= n_sensors <= _MOST_SENSORS
        ):
            raise UserError(
                f"n_sensors is {shown(n_sensors)}, expected a whole number from 1 to "
                f"{_MOST_SENSORS}"
            )
        n = 1 if n_sensors is None else int(n_sensors)
        self._lead = () if n_sensors is None else (n,)
        starts = None
        if initial_angles_rad is not None:
            starts = _numbers(initial_angles_rad, "initial_angles_rad")
            if starts.shape not in ((3,), (n, 3)):
                raise UserError(
                    f"initial_angles_rad has the shape {starts.shape}, expected (3,) or ({n}, 3)"
                )
            if not (np.abs(starts) <= _MOST_START_RAD).all():
                raise UserError(
                    f"initial_angles_rad is {shown(initial_angles_rad)}, expected radians of at "
                    "most pi, transverse 2 pi (np.radians converts degrees)"
                )
            starts = np.broadcast_to(starts, (n, 3)).copy()
        n_columns = 6 if method.needs_accelerometer else 3
        numbers, stds = method.clock_numbers(1.0 / rate_hz), method.stds_rad()
        self._clocked = method.recursion(rate_hz, n, starts).clocked(numbers, (n, n_columns), stds)
        # a state says nothing about the constants it belongs to
        alone = method.recursion(rate_hz, 1, None).clocked(numbers, (1, n_columns), stds)
        constants = hashlib.sha256(pickle.dumps(alone)).hexdigest()
        self._arguments = type(method).__qualname__, rate_hz, n_sensors, constants
        self._one = n, 1, n_columns
        self._of_a_sample = (*self._lead, n_columns)
        self._no_stamps = np.empty((n, 0))

    def update(self, sample: ArrayLike, time_s: ArrayLike | None = None) -> Estimate:
        """Process the next sample of every sensor.

        Parameters
        ----------
        sample : array_like, shape (3,) or (6,), with sensors (n_sensors, 3) or (n_sensors, 6)
            Rates about the sagittal, frontal and transverse axis without bias, rad/s, and for a
            method that needs it the specific force x, y, z, m/s^2 (`SegmentSignals`). NaN, or a
            rate beyond `narx.method.RATE_LIMIT_RAD_S`, is a missing sample.
        time_s : float or array_like, shape (n_sensors,), optional
            Sampling time, s on any increasing clock; by default samples follow each other at the
            sampling rate. A sample whose time is not later than the previous one is missing.

        Returns
        -------
        Estimate
            Result for this sample.

        Raises
        ------
        UserError
            If a shape is wrong, or a value is not a number.
        """
        # `real_numbers` takes as long as the rest of a step
        plain = sample.__class__ is np.ndarray and sample.dtype == np.float64
        values = np.array(sample, np.float64) if plain else _numbers(sample, "sample")
        if values.shape == self._of_a_sample:
            # an index costs half as much as a reshape
            values = values[:, None] if self._lead else values[None, None]
        else:
            values = self._in_shape(values, one=True)
        stamps = self._no_stamps if time_s is None else self._stamps(time_s, self._one[:2])
        angles, std, quality = self._clocked.follow(values, stamps)
        if self._lead:
            found = angles[:, 0], None if std is None else std[:, 0], quality[:, 0]
        else:
            found = angles[0, 0], None if std is None else std[0, 0], quality[0, 0]
        return _new(Estimate, found)  # a call of the class costs six times as much

    def update_block(self, samples: ArrayLike, time_s: ArrayLike | None = None) -> Estimate:
        """Process the next samples of every sensor.

        Parameters
        ----------
        samples : array_like, shape (N, C), with sensors (n_sensors, N, C)
            As for `update`.
        time_s : array_like, shape (N,) or (n_sensors, N), optional
            As for `update`.

        Returns
        -------
        Estimate
            Result for each sample.

        Raises
        ------
        UserError
            If a shape is wrong, or a value is not a number.
        """
        values = self._in_shape(_numbers(samples, "samples"))
        stamps = self._no_stamps if time_s is None else self._stamps(time_s, values.shape[:2])
        angles, std, quality = self._clocked.follow(values, stamps)
        if self._lead:
            return Estimate(angles, std, quality)
        return Estimate(angles[0], None if std is None else std[0], quality[0])

    def _in_shape(self, samples: FloatArray, one: bool = False) -> FloatArray:
        """Reshape samples, or one per sensor, to (B, N, C) without columns that are not needed."""
        n, _, n_columns = self._one
        values = samples[..., None, :] if one and samples.ndim else samples
        values = values if self._lead else values[None]
        if values.ndim == 3 and len(values) == n and values.shape[2] in (n_columns, 6):
            return np.ascontiguousarray(values[:, :, :n_columns])
        if one:
            raise UserError(
                f"sample has the shape {samples.shape}, expected {(*self._lead, n_columns)}"
            )
        lead = "".join(f"{size}, " for size in self._lead)
        raise UserError(f"samples have the shape {samples.shape}, expected ({lead}N, {n_columns})")

    def _stamps(self, time_s: ArrayLike, shape: tuple[int, int]) -> FloatArray:
        times = _numbers(time_s, "time_s")
        if times.ndim < 2 and 1 in shape and times.size == shape[0] * shape[1]:
            return np.array(times).reshape(shape)
        stamps = np.empty(shape)
        try:
            stamps[:] = times
        except ValueError as error:
            wanted = shape if self._lead else shape[1:]
            raise UserError(f"time_s has the shape {times.shape}, expected {wanted}") from error
        return stamps

    def __copy__(self) -> "OrientationStream":
        return copy.deepcopy(self)

    def state_dict(self) -> dict[str, Any]:
        """Return a copy of the state.

        Returns
        -------
        dict
            State for `load_state_dict` of a stream created with the same arguments.
        """
        return copy.deepcopy(vars(self))

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a copied state.

        Parameters
        ----------
        state : dict
            From `state_dict`; not changed.

        Raises
        ------
        UserError
            If it is the state of a stream with different arguments.
        """
        if (
            not isinstance(state, Mapping)
            or set(state) != set(vars(self))
            or any(type(value) is not type(state[name]) for name, value in vars(self).items())
            or state["_arguments"] != self._arguments
        ):
            raise UserError("the state belongs to a stream with different arguments")
        vars(self).update(copy.deepcopy(state))


def _numbers(values: ArrayLike, name: str) -> FloatArray:
    try:
        return real_numbers(values)
    except ValueError as error:
        raise UserError(f"{name} is {shown(values)}, expected numbers") from error
