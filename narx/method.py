"""The common interface of the network and all baselines."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from narx.errors import MethodNotApplicableError
from narx.kernels.clock import lay_out
from narx.kernels.limits import FORCE_LIMIT_M_S2
from narx.recursion import ClockNumbers, Recursion, SampleBySample, Step, new_clock
from narx.types import BoolArray, FloatArray

# a few lost samples are interpolated, a lost part of a stride is not
MAX_GAP_S = 0.05
# twice the fastest rate of a leg (1700 deg/s); a sample above this is a fault and is missing
RATE_LIMIT_RAD_S = 30.0


@dataclass(frozen=True)
class SegmentSignals:
    """Calibrated signals of one segment: the only input of a method.

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
        Angles at the first sample if known from the protocol (standing in the calibration posture:
        zero); None if the start is unknown.
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


class Labelled(Protocol):
    """Signals with the angles that a method is to learn: `narx.windows.TrainingSequence`.

    `signals` have no gap, `target_rad` has shape (N, 3) and NaN where there is no target, and
    `weight` is that of the squared errors.
    """

    @property
    def signals(self) -> SegmentSignals:
        """Calibrated signals without a missing sample."""

    @property
    def target_rad(self) -> FloatArray:
        """Target angles, shape (N, 3), rad."""

    @property
    def weight(self) -> float:
        """Weight of the squared errors."""


@dataclass(frozen=True)
class Estimate:
    """Output of a method for a whole recording.

    Parameters
    ----------
    angles_rad : ndarray, shape (N, 3)
        Sagittal, frontal and transverse angle in rad. NaN at missing samples, and over a whole
        axis that the method cannot observe.
    std_rad : ndarray, shape (N, 3), or None
        Standard deviation of the error that the method predicts, rad; NaN where a sample is
        missing. None if it predicts none.
    """

    angles_rad: FloatArray
    std_rad: FloatArray | None


class OrientationMethod(ABC):
    """Estimator of a segment's three angles from its calibrated signals.

    A subclass implements `_estimate` for signals without gaps, and `_step` if the method can run
    sample by sample; both must agree. Missing samples never reach a subclass: gaps of up to
    `MAX_GAP_S` are interpolated; in longer ones the method pauses and then continues from its last
    state. The angles of missing samples are always NaN.

    A method that learns sets `learns` and overrides `fit`.
    """

    name: ClassVar[str]
    needs_accelerometer: ClassVar[bool] = False
    streams: ClassVar[bool] = False
    # whether a benchmark calls `fit` before it tests the method on a fold
    learns: ClassVar[bool] = False
    # longest part of a gap too long to interpolate that the method steps through as missing, s
    counted_gap_s: ClassVar[float] = 0.0

    def fit(self, training: Sequence[Labelled], seed: int) -> None:
        """Learn from the training part of a fold; the same data that the network is trained on.

        Parameters
        ----------
        training : sequence of Labelled
            Stretches without gaps with the teacher's angles, of one sampling rate or several.
        seed : int
            Of everything that is drawn.

        Raises
        ------
        NotImplementedError
            If the method does not learn.
        """
        raise NotImplementedError(f"{type(self).__name__} does not learn")

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
        there = self.usable(signals)
        if there.all():
            return self._estimate(signals)
        angles = np.full((signals.n_samples, 3), np.nan)
        if there.any():
            bridged, tick_of = self.bridged(signals)
            angles[there] = self._estimate(bridged)[tick_of[there]]
        return angles

    def run(self, signals: SegmentSignals) -> Estimate:
        """Estimate the angles of a whole recording, with everything that comes with them.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        Estimate
            The same angles as from `estimate`.

        Raises
        ------
        MethodNotApplicableError
            If the recording lacks something that the method needs.
        """
        return Estimate(self.estimate(signals), None)

    def usable(self, signals: SegmentSignals) -> BoolArray:
        """Return which samples are not missing.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        ndarray of bool, shape (N,)
            False where a value that the method needs is not finite, a rate beyond
            `RATE_LIMIT_RAD_S` or a force beyond `narx.kernels.limits.FORCE_LIMIT_M_S2`.
        """
        there = np.ones(signals.n_samples, dtype=bool)
        # column by column: a reduction over a short last axis takes several times as long
        for axis in range(3):
            # NaN compares false
            there &= np.abs(signals.axis_rates_rad_s[:, axis]) <= RATE_LIMIT_RAD_S
            if self.needs_accelerometer:
                there &= np.abs(signals.specific_force_m_s2[:, axis]) <= FORCE_LIMIT_M_S2
        return there

    def samples(self, axis_rates_rad_s: FloatArray, specific_force_m_s2: FloatArray) -> FloatArray:
        """Join the inputs of the method.

        Parameters
        ----------
        axis_rates_rad_s, specific_force_m_s2 : ndarray, shape (..., 3)
            As in `SegmentSignals`.

        Returns
        -------
        ndarray, shape (..., C)
            The three rates, and the three forces if the method needs them.
        """
        if not self.needs_accelerometer:
            return axis_rates_rad_s
        return np.concatenate([axis_rates_rad_s, specific_force_m_s2], axis=-1)

    def bridged(self, signals: SegmentSignals) -> tuple[SegmentSignals, NDArray[np.int64]]:
        """Interpolate short gaps and cut out long ones.

        Parameters
        ----------
        signals : SegmentSignals
            Signals with missing samples.

        Returns
        -------
        signals : SegmentSignals
            Signals without missing samples, concatenated across long gaps, except for the ticks of
            `counted_gap_s`, which are NaN.
        tick_of : ndarray of int, shape (N,)
            Index in these signals of each sample, or for a missing one of the latest before it
            (-1: none).
        """
        samples = self.samples(signals.axis_rates_rad_s, signals.specific_force_m_s2)
        shape = (1, signals.n_samples)
        tick_of = np.empty(shape, np.int64)
        ticks, _ = lay_out(
            np.ascontiguousarray(samples[None], dtype=np.float64),
            np.empty((1, 0)),
            *self.clock_numbers(signals.interval_s),
            np.zeros((1, samples.shape[1])),
            new_clock(1),
            tick_of,
            np.empty(shape),
            np.empty(shape, np.int8),
        )
        force = ticks[:, 3:] if self.needs_accelerometer else np.full_like(ticks, np.nan)
        filled = replace(signals, axis_rates_rad_s=ticks[:, :3], specific_force_m_s2=force)
        return filled, tick_of[0]

    def clock_numbers(self, interval_s: float) -> ClockNumbers:
        """Return the parameters for converting the method's samples to ticks.

        Parameters
        ----------
        interval_s : float
            Time between ticks, s.

        Returns
        -------
        ClockNumbers
            Parameters for `bridged` and for streams.
        """
        lost_most = math.ceil(self.counted_gap_s / interval_s)
        return ClockNumbers(RATE_LIMIT_RAD_S, interval_s, longest_gap_s(interval_s), lost_most)

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        return self.streams

    @abstractmethod
    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        """Estimate the angles, shape (N, 3), of signals without a missing sample."""

    def stds_rad(self) -> FloatArray | None:
        """Standard deviations of the error after the start-up and during it.

        Returns
        -------
        ndarray, shape (2, 3), or None
            Standard deviations, rad; None if the method predicts none.
        """
        return None

    def recursion(
        self, sampling_rate_hz: float, n_sensors: int, initial_angles_rad: FloatArray | None
    ) -> Recursion:
        """Start the method for use sample by sample (`narx.inference.stream`).

        Parameters
        ----------
        sampling_rate_hz : float
            Sampling rate.
        n_sensors : int
            Number of sensors that run in parallel.
        initial_angles_rad : ndarray, shape (n_sensors, 3), optional
            Known start poses; None if they are unknown.

        Returns
        -------
        Recursion
            Recursion that gives the same angles as `estimate`.

        Raises
        ------
        MethodNotApplicableError
            If the method needs the whole recording.
        """
        if not self.streams:
            raise MethodNotApplicableError(f"{self.name} needs the whole recording to estimate")
        starts = [None] * n_sensors if initial_angles_rad is None else list(initial_angles_rad)
        return SampleBySample([self._step(sampling_rate_hz, start) for start in starts])

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        """Start the recursion; to be overridden if `streams` is True."""
        raise NotImplementedError


def longest_gap_s(interval_s: float) -> float:
    """Return the longest time between two samples that is interpolated.

    Parameters
    ----------
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    float
        `MAX_GAP_S`, but more than one interval.
    """
    return max(MAX_GAP_S, 1.5 * interval_s)
