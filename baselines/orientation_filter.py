"""Common base of orientation filters: three angles from gyroscope and accelerometer."""

import threading
import weakref
from abc import abstractmethod
from collections.abc import Hashable

import numpy as np
from numpy.typing import ArrayLike

from narx.baselines.heading import Heading
from narx.baselines.recursive import GivenStartUp
from narx.inference.composition import start_up_of
from narx.kinematics.segment_angles import TRANSVERSE, angles_from_orientation
from narx.method import OrientationMethod, SegmentSignals
from narx.types import FloatArray

_Latest = dict[Hashable, tuple["weakref.ref[SegmentSignals]", FloatArray]]


class _OfThread(threading.local):
    """What each filter made of the recording that this thread ran it on last.

    A benchmark runs a filter with every treatment of the heading.
    """

    def __init__(self) -> None:
        self.latest: _Latest = {}


_KEPT = _OfThread()


class OrientationFilter(OrientationMethod):
    """A filter that estimates an orientation from gyroscope and accelerometer.

    Its axes are coupled by design, and gravity gives the mean tilt. Of the parts of
    `narx.inference.composition`, only the start-up is used, for the posture of the heading.

    Parameters
    ----------
    heading, heading_leak_rad_s
        As `treatment` and `leak_rad_s` of `narx.baselines.heading.Heading`.
    start_up : StartUp, mapping, bool, optional
        With ``heading=leak``: determines initial heading and its posture; True uses the default.
    """

    needs_accelerometer = True

    def __init__(
        self,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
        start_up: GivenStartUp = None,
    ) -> None:
        self.heading = Heading(heading, heading_leak_rad_s)
        self.start_up = start_up_of(start_up, self.name)

    @property
    @abstractmethod
    def _settings(self) -> Hashable:
        """Everything that the orientation depends on besides the signals."""

    @abstractmethod
    def _orientation(self, signals: SegmentSignals) -> FloatArray:
        """Quaternions w, x, y, z (N, 4) relative to a world frame with z up and any heading."""

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        if not signals.n_samples:
            return np.empty((0, 3))
        angles = self._angles(signals)
        # without a magnetometer the heading is arbitrary: use it relative to the first sample
        initial = signals.initial_angles_rad
        first = 0.0 if initial is None else float(initial[TRANSVERSE])
        angles[:, TRANSVERSE] += first - angles[0, TRANSVERSE]
        return self.heading.of(
            angles, signals.axis_rates_rad_s, signals.interval_s, initial, self.start_up
        )

    def _angles(self, signals: SegmentSignals) -> FloatArray:
        """Angles with the filter's own heading; treatments of the heading share the latest ones."""
        key = type(self), self._settings
        kept = _KEPT.latest
        latest = kept.get(key)
        if latest is None or latest[0]() is not signals:
            angles = angles_from_orientation(self._orientation(signals))
            latest = weakref.ref(signals, lambda _: kept.pop(key, None)), angles
            kept[key] = latest
        return latest[1].copy()


class AnglesOneByOne:
    """Convert successive orientations to angles.

    Parameters
    ----------
    initial_angles_rad : ndarray, shape (3,), optional
        Gives the heading at the first sample; zero if unknown.
    """

    def __init__(self, initial_angles_rad: FloatArray | None) -> None:
        self._offset: float | None = None
        self._heading = 0.0
        if initial_angles_rad is not None:
            self._heading = float(initial_angles_rad[TRANSVERSE])

    def __call__(self, quaternion_wxyz: ArrayLike) -> FloatArray:
        """Convert the next orientation to angles.

        Parameters
        ----------
        quaternion_wxyz : array_like, shape (4,)
            Orientation of the anatomical frame relative to a world frame with z up.

        Returns
        -------
        ndarray, shape (3,)
            Angles in rad, with an unwrapped heading.
        """
        angles = angles_from_orientation(quaternion_wxyz)[0]
        if self._offset is None:
            self._offset = float(angles[TRANSVERSE]) - self._heading
        change = angles[TRANSVERSE] - self._offset - self._heading
        self._heading += change - 2.0 * np.pi * np.round(change / (2.0 * np.pi))
        angles[TRANSVERSE] = self._heading
        return angles
