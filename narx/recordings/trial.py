"""Inertial recordings and trials, validated on construction.

Everything is SI and radians; a missing sample is NaN, never zero.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from narx.errors import RecordingError
from narx.settings import Flag, Samples, check_fields
from narx.types import BoolArray, FloatArray

GRAVITY_M_S2 = 9.80665


def side_of(segment: str) -> Literal["left", "right"] | None:
    """Return the side of a segment from its name.

    Parameters
    ----------
    segment : str
        Such as ``thigh_right``, ``shank_left``, ``pelvis``.

    Returns
    -------
    {"left", "right"} or None
        None where the name does not end in a side.
    """
    if segment.endswith("_left"):
        return "left"
    return "right" if segment.endswith("_right") else None


def kind_of(segment: str) -> str:
    """Return the kind of a segment or joint, without its side.

    Parameters
    ----------
    segment : str
        Such as ``thigh_right``, ``knee_left``, ``pelvis``.

    Returns
    -------
    str
        The name without its side: ``thigh``, ``knee``, ``pelvis``.
    """
    return segment.removesuffix("_left").removesuffix("_right")


def _check_shape(name: str, array: FloatArray, columns: int | None, where: str) -> None:
    expected = 1 if columns is None else 2
    if array.ndim != expected or (columns is not None and array.shape[1] != columns):
        shape = "(N,)" if columns is None else f"(N, {columns})"
        raise RecordingError(f"{where}: {name} has shape {array.shape}, expected {shape}")


@dataclass(frozen=True)
class ImuRecording:
    """One inertial sensor on one segment, in the sensor's technical frame.

    Arrays are copied; what is masked in them is missing.

    Parameters
    ----------
    segment : str
        ``thigh_right``, ``shank_left``, ``pelvis``, ``thigh`` (side unknown), ``imu1``, ...
    time_s : ndarray, shape (N,)
        Sampling times in s, strictly increasing, finite; regular or not.
    gyroscope_rad_s : ndarray, shape (N, 3)
        Angular rate in rad/s; NaN where missing.
    accelerometer_m_s2 : ndarray, shape (N, 3)
        Specific force in m/s^2 (at rest it points up); NaN where missing.
    notes : tuple of str
        Processing applied when reading, as text.

    Raises
    ------
    UserError
        If a field has another type, as dates or complex numbers have.
    RecordingError
        If shapes differ, times do not increase, or a value is infinite.
    """

    segment: str
    time_s: Samples
    gyroscope_rad_s: Samples
    accelerometer_m_s2: Samples
    notes: tuple[str, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        where = f"IMU '{self.segment}'"
        check_fields(self, "ImuRecording")
        time = self.time_s
        _check_shape("time_s", time, None, where)
        for name in ("gyroscope_rad_s", "accelerometer_m_s2"):
            array = getattr(self, name)
            _check_shape(name, array, 3, where)
            if len(array) != len(time):
                raise RecordingError(
                    f"{where}: {name} has {len(array)} samples, time_s has {len(time)}"
                )
            infinite = np.flatnonzero(np.isinf(array).any(axis=1))
            if infinite.size:
                raise RecordingError(f"{where}: {name} is infinite at sample {infinite[0]}")
        backwards = np.flatnonzero(~(np.diff(time) > 0))
        if backwards.size:
            k = int(backwards[0])
            raise RecordingError(
                f"{where}: time does not increase at sample {k + 1} "
                f"({time[k]:.6g} s, then {time[k + 1]:.6g} s)"
            )

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return len(self.time_s)

    @property
    def sampling_rate_hz(self) -> float:
        """Sampling rate from the median interval, Hz; NaN below two samples."""
        if self.n_samples < 2:
            return float("nan")
        return float(1.0 / np.median(np.diff(self.time_s)))


@dataclass(frozen=True)
class ReferenceOrientation:
    """Orientation of a segment from an optical (or equivalent) system.

    Parameters
    ----------
    segment : str
        Name of the segment, as in the trial's IMUs.
    quaternion_wxyz : ndarray, shape (N, 4)
        Rotation from `frame` to the global frame (z up), on the trial's clock; NaN rows where
        missing.
    frame : {"sensor", "anatomical"}
        Whether the IMU's technical frame (markers on the sensor) or the segment's anatomical frame
        (markers on the body) was tracked.

    Raises
    ------
    UserError
        If a field has another type.
    RecordingError
        If the shape is wrong or a valid quaternion is not of unit norm (within 1e-3).
    """

    segment: str
    quaternion_wxyz: Samples
    frame: Literal["sensor", "anatomical"]

    def __post_init__(self) -> None:
        where = f"reference of '{self.segment}'"
        check_fields(self, "ReferenceOrientation")
        quaternion = self.quaternion_wxyz
        _check_shape("quaternion_wxyz", quaternion, 4, where)
        norm = np.linalg.norm(quaternion, axis=1)
        wrong = np.flatnonzero(np.isfinite(norm) & (np.abs(norm - 1.0) > 1e-3))
        if wrong.size:
            raise RecordingError(
                f"{where}: quaternion {wrong[0]} has norm {norm[wrong[0]]:.4f}, expected 1"
            )
        object.__setattr__(self, "quaternion_wxyz", quaternion / norm[:, None])


@dataclass(frozen=True)
class Trial:
    """One recording of one person (or device) with its reference, calibration and metadata.

    Parameters
    ----------
    dataset, subject, condition, trial : str
        Names used by the source.
    sampling_rate_hz : float
        Rate of the uniform clock shared by `imus` and `reference`.
    imus : mapping of str to ImuRecording
        By segment name, all of the same length on the same uniform clock (gaps are NaN).
    reference : mapping of str to ReferenceOrientation
        By segment name; empty without a reference.
    calibration : mapping of str to mapping of str to ImuRecording
        Extra recordings by part (``standing``, ``hip_abduction_right``, ``knee_flexion_left``,
        ``still``: the sensor at rest anywhere, for its bias), each by segment name, each on its
        own clock.
    still_s : tuple of (float, float)
        Intervals of `imus`' clock in which the wearer stood still in the calibration posture,
        as far as the source's protocol specifies.
    straight : bool
        Whether the walk keeps one heading, so that the transverse angle has a reference.
    starts_in_calibration_posture : bool
        Whether the first sample is the calibration posture (all angles zero).
    scored : ndarray of bool, shape (N,), optional
        Samples that the source marks for scoring; None means all.
    walking_s : tuple of (float, float), optional
        Part of the recording that is the straight walk itself, if known.
    events : mapping of str to ndarray
        Times in s of known events (``heel_strike_right``, ``toe_off_left``, ...).
    clock_offset_s : mapping of str to float
        Per segment, lag of the inertial clock behind the optical one before alignment.
    notes : tuple of str
        Processing applied when reading (misalignment removed, resampled), as text.
    sources : mapping of str to str
        File name to SHA-256.

    Raises
    ------
    UserError
        If a field has another type.
    RecordingError
        If lengths or clocks differ.
    """

    dataset: str
    subject: str
    condition: str
    trial: str
    sampling_rate_hz: float
    imus: Mapping[str, ImuRecording]
    reference: Mapping[str, ReferenceOrientation] = field(default_factory=dict)
    calibration: Mapping[str, Mapping[str, ImuRecording]] = field(default_factory=dict)
    still_s: tuple[tuple[float, float], ...] = ()
    straight: Flag = False
    starts_in_calibration_posture: Flag = False
    scored: BoolArray | None = None
    walking_s: tuple[float, float] | None = None
    events: Mapping[str, FloatArray] = field(default_factory=dict)
    clock_offset_s: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_fields(self, "Trial")
        if not self.imus:
            raise RecordingError(f"{self.name}: no IMU")
        for segment, imu in self.imus.items():
            if imu.n_samples != self.n_samples:
                raise RecordingError(
                    f"{self.name}: IMU '{segment}' has {imu.n_samples} samples, "
                    f"the trial {self.n_samples}"
                )
            if imu.n_samples > 1:
                step = np.diff(imu.time_s) * self.sampling_rate_hz
                if np.abs(step - 1.0).max() > 1e-3:
                    raise RecordingError(
                        f"{self.name}: IMU '{segment}' is not sampled uniformly at "
                        f"{self.sampling_rate_hz:g} Hz"
                    )
        for segment, reference in self.reference.items():
            if segment not in self.imus:
                raise RecordingError(f"{self.name}: reference '{segment}' has no IMU")
            if len(reference.quaternion_wxyz) != self.n_samples:
                raise RecordingError(
                    f"{self.name}: reference '{segment}' has "
                    f"{len(reference.quaternion_wxyz)} samples, the trial {self.n_samples}"
                )
        if self.scored is not None and self.scored.shape != (self.n_samples,):
            raise RecordingError(
                f"{self.name}: scored has shape {self.scored.shape}, expected ({self.n_samples},)"
            )

    @property
    def name(self) -> str:
        """Dataset, subject, condition and trial joined, for messages."""
        return f"{self.dataset}/{self.subject}/{self.condition}/{self.trial}"

    @property
    def time_s(self) -> FloatArray:
        """The common clock of all sensors, s."""
        return next(iter(self.imus.values())).time_s

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return next(iter(self.imus.values())).n_samples
