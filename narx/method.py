"""The one interface that the network and every baseline share."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from narx.errors import MethodNotApplicableError
from narx.types import BoolArray, FloatArray

# one sample in (axis rates (3,), specific force (3,)), three angles out
Step = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class SegmentSignals:
    """Calibrated signals of one segment: all that a method may look at.

    Parameters
    ----------
    segment : str
        Name of the segment.
    sampling_rate_hz : float
        Rate of the uniform clock.
    axis_rates_rad_s : ndarray, shape (N, 3)
        Angular rate about the sagittal, frontal and transverse axis of the segment, reported
        signs (`narx.kinematics.segment_angles.axis_rates`), static bias removed; NaN where missing.
    specific_force_m_s2 : ndarray, shape (N, 3)
        Accelerometer x (forward), y (left), z (up) in the anatomical frame, left leg mirrored.
    initial_angles_rad : ndarray, shape (3,), optional
        Angles at the first sample where the protocol gives them (standing in the calibration
        posture: zero); None where the start is unknown.
    """

    segment: str
    sampling_rate_hz: float
    axis_rates_rad_s: FloatArray
    specific_force_m_s2: FloatArray
    initial_angles_rad: FloatArray | None = None

    @property
    def n_samples(self) -> int:
        """Number of samples."""
        return len(self.axis_rates_rad_s)

    @property
    def interval_s(self) -> float:
        """Sampling interval, s."""
        return 1.0 / self.sampling_rate_hz

    def select(self, keep: BoolArray | slice) -> "SegmentSignals":
        """Return the signals of some samples as if they followed one another.

        Parameters
        ----------
        keep : ndarray of bool, shape (N,), or slice
            Samples to keep.

        Returns
        -------
        SegmentSignals
            Same segment, fewer samples.
        """
        return SegmentSignals(
            self.segment,
            self.sampling_rate_hz,
            self.axis_rates_rad_s[keep],
            self.specific_force_m_s2[keep],
            self.initial_angles_rad,
        )


class OrientationMethod(ABC):
    """Estimates a segment's three angles from its calibrated signals.

    A subclass implements `_estimate` for signals without gaps, and `stream` where the method is
    meant to run sample by sample; both must agree. Missing samples never reach a subclass: a
    method pauses in a gap, answers NaN there, and goes on from the state it had.
    """

    name: ClassVar[str]
    needs_accelerometer: ClassVar[bool] = False
    streams: ClassVar[bool] = False

    def estimate(self, signals: SegmentSignals) -> FloatArray:
        """Estimate the angles of a whole recording.

        Parameters
        ----------
        signals : SegmentSignals
            Calibrated signals; NaN where missing.

        Returns
        -------
        ndarray, shape (N, 3)
            Sagittal, frontal and transverse angle in rad. NaN at missing samples, and over a
            whole axis that the method cannot observe.

        Raises
        ------
        MethodNotApplicableError
            If the recording lacks something that the method needs.
        """
        needed = [signals.axis_rates_rad_s]
        if self.needs_accelerometer:
            needed.append(signals.specific_force_m_s2)
        # looking sample by sample takes as long as the simpler methods themselves
        if all(np.isfinite(values).all() for values in needed):
            return self._estimate(signals)
        there: BoolArray = np.asarray(np.isfinite(np.hstack(needed)).all(axis=1))
        angles = np.full((signals.n_samples, 3), np.nan)
        if there.any():
            angles[there] = self._estimate(signals.select(there))
        return angles

    def standard_deviation(self, signals: SegmentSignals) -> FloatArray | None:
        """Predict the standard deviation of the error at every sample.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        ndarray, shape (N, 3), or None
            rad; NaN where a sample is missing. None where the method predicts none.
        """
        return None

    @abstractmethod
    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        """Estimate the angles, shape (N, 3), of signals without a missing sample."""

    def stream(self, sampling_rate_hz: float) -> Step:
        """Start the method for use sample by sample, from zero angles.

        Parameters
        ----------
        sampling_rate_hz : float
            Rate at which samples will come.

        Returns
        -------
        callable
            ``step(axis_rates (3,), specific_force (3,)) -> angles (3,)``, equal to `estimate`
            on the same samples. A sample with a NaN that the method needs gives NaN and leaves
            the state as it was.

        Raises
        ------
        MethodNotApplicableError
            If the method needs the whole recording.
        """
        if not self.streams:
            raise MethodNotApplicableError(f"{self.name} needs the whole recording to estimate")
        step = self._stream(sampling_rate_hz)
        missing = np.full(3, np.nan)

        def guarded(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            if not np.isfinite(axis_rates).all() or (
                self.needs_accelerometer and not np.isfinite(specific_force).all()
            ):
                return missing.copy()
            return step(axis_rates, specific_force)

        return guarded

    def _stream(self, sampling_rate_hz: float) -> Step:
        """Start the recursion; override where `streams` is True."""
        raise NotImplementedError
