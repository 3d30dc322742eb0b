"""2-point error estimation: the drift between two standing parts, modelled as a line."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.moving_average import centred_moving_average
from narx.baselines.parameters import one_of, positive
from narx.errors import MethodNotApplicableError, UserError
from narx.gait.standing import StillThresholds, start_and_stop
from narx.kinematics.segment_angles import TRANSVERSE, tilt_from_specific_force
from narx.method import OrientationMethod, SegmentSignals
from narx.types import BoolArray, FloatArray


@dataclass(frozen=True)
class TwoPointParts:
    """Intermediate results of the method, for figures and tables.

    Parameters
    ----------
    start, stop : int or None
        Samples A and B; None if the whole recording is still.
    gyroscope_angles_rad : ndarray, shape (N, 3)
        Integrated gyroscope psi from the accelerometer's tilt at the first sample; NaN where
        samples are missing, or if the whole recording is still.
    drift_rad : ndarray, shape (N, 3)
        Its estimated drift, the line between A and B; NaN outside A..B.
    angles_rad : ndarray, shape (N, 3)
        The estimate.
    """

    start: int | None
    stop: int | None
    gyroscope_angles_rad: FloatArray
    drift_rad: FloatArray
    angles_rad: FloatArray


class TwoPoint(OrientationMethod):
    """Integrate between two standing parts, and subtract a straight line for the drift.

    Parameters
    ----------
    start_s, stop_s : float, optional
        Times A and B given manually, s from the first sample; None detects them.
    gravity_threshold_g : float
        Lambda_1: largest deviation of the accelerometer's norm from 1 g while standing, g.
    rate_threshold_deg_s : float
        Lambda_2: largest rate about any axis while standing, deg/s.
    still_s : float
        Lambda_3: shortest standing, s (50 samples at 100 Hz).
    smoothing_s : float
        Window of the averages over standing, s (2 K + 1 = 61 samples at 100 Hz).
    shaky_legs : bool
        Raise both thresholds above the tremor in the first second, which must be standing.
    shaky_margin : float
        Factor on the mean deviation of the first second.
    rule : {"trapezoid", "rectangle"}
        Rate between two samples; the paper uses the rectangle (eq. (9)).
    coupled : bool
        Integrate the rates of the angles instead of the gyroscope's own axes.

    Notes
    -----
    Han et al., eqs. (3) to (14), with three corrections. Eq. (3) has its absolute value in the
    wrong place (see `narx.gait.standing.StillThresholds`). Eq. (7) sums 2 K + 1 samples and divides
    by 2 K, which makes gravity 1.7 % too large; here it is a true mean. At A and B its window would
    extend into the walk, where the leg immediately tilts and accelerates; so the errors, eqs. (10)
    and (11), are means of psi minus tilt over the same length of time before A and after B. Yaw is
    zero before A and after B, which is correct only for a straight walk.
    """

    name = "two_point"
    needs_accelerometer = True

    def __init__(
        self,
        start_s: float | None = None,
        stop_s: float | None = None,
        gravity_threshold_g: float = 0.07,
        rate_threshold_deg_s: float = 10.0,
        still_s: float = 0.5,
        smoothing_s: float = 0.6,
        shaky_legs: bool = False,
        shaky_margin: float = 2.0,
        rule: str = "trapezoid",
        coupled: bool = False,
    ) -> None:
        if (start_s is None) != (stop_s is None):
            raise UserError(
                f"method {self.name}: start_s is {start_s} and stop_s {stop_s}, expected both "
                "or neither"
            )
        self.start_s, self.stop_s = start_s, stop_s
        self.thresholds = StillThresholds(
            positive(self.name, "gravity_threshold_g", gravity_threshold_g),
            float(np.deg2rad(positive(self.name, "rate_threshold_deg_s", rate_threshold_deg_s))),
            positive(self.name, "still_s", still_s),
        )
        self.smoothing_s = positive(self.name, "smoothing_s", smoothing_s)
        self.shaky_legs = shaky_legs
        self.shaky_margin = positive(self.name, "shaky_margin", shaky_margin)
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))
        self._integral = GyroIntegration(rule, coupled)

    def estimate(self, signals: SegmentSignals) -> FloatArray:
        """Estimate the angles of a whole recording.

        Parameters
        ----------
        signals : SegmentSignals
            Calibrated signals; NaN where missing.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles in rad; NaN at missing samples. Unlike in other methods, gaps keep their
            duration, because the drift is linear in time; rotation during a gap of the
            gyroscope becomes part of the drift.

        Raises
        ------
        MethodNotApplicableError
            If there is no still part before or after the walk, or given times A and B are not
            within the recording.
        """
        return self.parts(signals).angles_rad

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        return self.parts(signals).angles_rad

    def parts(self, signals: SegmentSignals) -> TwoPointParts:
        """Estimate the angles, and return the intermediate results as well.

        Parameters
        ----------
        signals : SegmentSignals
            Calibrated signals; NaN where missing.

        Returns
        -------
        TwoPointParts
            A, B, integrated gyroscope, drift line and angles.

        Raises
        ------
        MethodNotApplicableError
            As `estimate`.
        """
        rates, force = signals.axis_rates_rad_s, signals.specific_force_m_s2
        there = np.asarray(np.isfinite(np.hstack([rates, force])).all(axis=1))
        found = self._start_and_stop(signals)
        nowhere = np.full((signals.n_samples, 3), np.nan)
        if found is None:
            return TwoPointParts(None, None, nowhere, nowhere, self._standing(signals, there))
        start, stop = found
        tilt = self._tilt(signals, there)
        gyroscope = self._integral.estimate(
            replace(
                signals,
                axis_rates_rad_s=np.where(np.isfinite(rates), rates, 0.0),
                initial_angles_rad=tilt[there][0],
            )
        )
        error = gyroscope - tilt
        at_start = self._mean_error(signals, "before", np.arange(start, -1, -1), error)
        at_stop = self._mean_error(signals, "after", np.arange(stop, len(error)), error)
        walk = np.arange(start, stop + 1)
        drift, angles = nowhere, np.empty_like(nowhere)
        error_at_stop = at_start + _short_way_round(at_stop - at_start)
        drift[walk] = _drift_line(at_start, error_at_stop, len(walk))
        angles[:start] = self._standing(signals.select(slice(0, start)), there[:start])
        angles[walk] = _compensate(gyroscope[walk], drift[walk])
        angles[stop + 1 :] = self._standing(
            signals.select(slice(stop + 1, None)), there[stop + 1 :]
        )
        angles[~there] = gyroscope[~there] = np.nan
        return TwoPointParts(start, stop, gyroscope, drift, angles)

    def _start_and_stop(self, signals: SegmentSignals) -> tuple[int, int] | None:
        if self.start_s is not None and self.stop_s is not None:
            last_s = (signals.n_samples - 1) * signals.interval_s
            if not 0.0 <= self.start_s < self.stop_s <= last_s:
                raise MethodNotApplicableError(
                    f"method {self.name}: start_s is {self.start_s} and stop_s {self.stop_s}, "
                    f"expected 0 <= start_s < stop_s <= {last_s:.2f} in {signals.segment}"
                )
            rate_hz = signals.sampling_rate_hz
            return round(self.start_s * rate_hz), round(self.stop_s * rate_hz)
        rates, force = signals.axis_rates_rad_s, signals.specific_force_m_s2
        thresholds = self.thresholds
        if self.shaky_legs:
            thresholds = thresholds.raised_for_shaky_legs(
                rates, force, signals.sampling_rate_hz, self.shaky_margin
            )
        try:
            return start_and_stop(rates, force, signals.sampling_rate_hz, thresholds)
        except MethodNotApplicableError as error:
            raise MethodNotApplicableError(
                f"method {self.name} does not apply to {signals.segment}: {error} "
                "(start_s and stop_s may be given)"
            ) from error

    def _tilt(self, signals: SegmentSignals, there: BoolArray) -> FloatArray:
        """Accelerometer's tilt, eqs. (5) and (6), with a yaw of zero."""
        angles = np.full((signals.n_samples, 3), np.nan)
        angles[there, :TRANSVERSE] = tilt_from_specific_force(signals.specific_force_m_s2[there])
        angles[there, TRANSVERSE] = 0.0
        return angles

    def _standing(self, signals: SegmentSignals, there: BoolArray) -> FloatArray:
        """Tilt after eq. (7), a moving average of the accelerometer."""
        smooth = signals.specific_force_m_s2.copy()
        smooth[there] = centred_moving_average(
            smooth[there], self.smoothing_s, signals.sampling_rate_hz
        )
        return self._tilt(replace(signals, specific_force_m_s2=smooth), there)

    def _mean_error(
        self, signals: SegmentSignals, part: str, samples: NDArray[np.int64], error: FloatArray
    ) -> FloatArray:
        """Eqs. (10) and (11) over the standing next to the walk; `samples` lead away from it."""
        samples = samples[np.isfinite(error[samples]).all(axis=1)]
        if not len(samples):
            raise MethodNotApplicableError(
                f"method {self.name}: every sample of {signals.segment} {part} the walk is "
                "missing, expected standing"
            )
        samples = samples[: 1 + round(self.smoothing_s * signals.sampling_rate_hz)]
        nearest = error[samples[0]]
        return nearest + _short_way_round(error[samples] - nearest).mean(axis=0)


def _drift_line(at_start: FloatArray, at_stop: FloatArray, n_samples: int) -> FloatArray:
    """Eqs. (12) and (13): the error at A and at B, joined by a line."""
    weight = np.linspace(0.0, 1.0, n_samples)[:, None]
    return at_start * (1.0 - weight) + at_stop * weight


def _compensate(gyroscope: FloatArray, drift: FloatArray) -> FloatArray:
    """Eq. (14)."""
    return gyroscope - drift


def _short_way_round(difference_rad: FloatArray) -> FloatArray:
    return difference_rad - 2.0 * np.pi * np.round(difference_rad / (2.0 * np.pi))
