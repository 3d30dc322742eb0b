"""Gyro integration-based orientation filter (GIOF): integrate, and reset to gravity at rest."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from narx.baselines.heading import Heading
from narx.baselines.moving_average import centred_moving_average
from narx.baselines.parameters import both_if_coupled, one_of, positive, tilt_axes
from narx.baselines.recursive import Constants, GivenStartUp, Inputs, RecursiveMethod
from narx.errors import MethodNotApplicableError, UserError
from narx.gait.stride_frequency import stride_frequency_hz
from narx.kernels.gravity import gravity_alone, tilt
from narx.kernels.recursions import reset
from narx.kinematics.segment_angles import (
    FRONTAL,
    SAGITTAL,
    TRANSVERSE,
    coupled_rates,
    tilt_from_specific_force,
)
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2
from narx.types import BoolArray, FloatArray

_PAPERS_OFFSET_WINDOW_S = 1.5  # 150 samples at 100 Hz


class Giof(RecursiveMethod):
    """Integrate the gyroscope; use the accelerometer instead when it measures only gravity.

    Parameters
    ----------
    mode : {"offline", "real_time"}
        ``offline`` cleans the gyroscope with two centred moving averages and needs the whole
        recording; ``real_time`` low-passes both sensors causally and subtracts a static offset.
    axes : sequence of str
        ``sagittal`` (the only axis in the paper), ``frontal`` or both. The others are NaN.
    eta_m_s2 : float
        Allowed deviation of the accelerometer's norm from gravity, m/s^2.
    rate_threshold_deg_s : float
        Gamma_3: the segment is at rest below this angular rate, deg/s.
    rest_s : float
        Time for which both conditions must hold before the accelerometer is used, s. 0 as in the
        paper: one sample is enough.
    noise_window_s : float
        Offline: window of the moving average against noise, s (10 samples at 100 Hz).
    offset_window_s : float, optional
        Offline: window of the moving average used as the gyroscope's offset, s (150 samples at
        100 Hz). None uses two strides of the detected cadence (1.5 s if no walking is found).
    low_pass_hz : float, optional
        Real time: cut-off of the second-order Butterworth filter on all six channels, Hz; None
        for sensors that filter themselves.
    static_offset_deg_s : sequence of float
        Real time: offset subtracted from the three axis rates, deg/s, in addition to the static
        bias that was removed in calibration.
    coupled, start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.
    heading, heading_leak_rad_s
        As `treatment` and `leak_rad_s` of `narx.baselines.heading.Heading`.

    Notes
    -----
    Abhayasinghe et al., eqs. (1), (2) and Fig. 6; neither eta nor gamma_3 is printed, so the
    defaults suit quiet standing with a consumer IMU. Eq. (2) is printed as ``rate < gamma_3``,
    which any backward swing fulfils; the absolute value is meant. `rest_s` is an addition: at the
    end of a swing the rate passes through zero while the thigh accelerates strongly, and whether
    a single sample falls into that moment depends on the sampling rate. With two axes, both rates
    must be below the threshold, because the accelerometer measures only gravity if the segment
    rotates about neither. A window with an even number of samples is centred by giving its two end
    samples half a weight, so that its length is a duration and not a number of samples.
    """

    name = "giof"
    needs_accelerometer = True
    _recursion = reset

    def __init__(
        self,
        mode: str = "offline",
        axes: Sequence[str] = ("sagittal", "frontal"),
        eta_m_s2: float = 0.2,
        rate_threshold_deg_s: float = 5.0,
        rest_s: float = 0.1,
        noise_window_s: float = 0.1,
        offset_window_s: float | None = _PAPERS_OFFSET_WINDOW_S,
        low_pass_hz: float | None = 10.0,
        static_offset_deg_s: Sequence[float] = (0.0, 0.0, 0.0),
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.heading = Heading(heading, heading_leak_rad_s)
        self.mode = one_of(self.name, "mode", mode, ("offline", "real_time"))
        self.columns = both_if_coupled(self.name, tilt_axes(self.name, axes), coupled)
        self.eta_m_s2 = positive(self.name, "eta_m_s2", eta_m_s2)
        self.rate_threshold_rad_s = float(
            np.deg2rad(positive(self.name, "rate_threshold_deg_s", rate_threshold_deg_s))
        )
        if not (np.isfinite(rest_s) and rest_s >= 0):
            raise UserError(f"method {self.name}: rest_s is {rest_s}, expected 0 or more")
        self.rest_s = float(rest_s)
        self.noise_window_s = positive(self.name, "noise_window_s", noise_window_s)
        self.offset_window_s = (
            None
            if offset_window_s is None
            else positive(self.name, "offset_window_s", offset_window_s)
        )
        self.low_pass_hz = (
            None if low_pass_hz is None else positive(self.name, "low_pass_hz", low_pass_hz)
        )
        if len(static_offset_deg_s) != 3:
            raise UserError(
                f"method {self.name}: static_offset_deg_s has {len(static_offset_deg_s)} values, "
                "expected three"
            )
        self.static_offset_rad_s = np.deg2rad(np.array([*static_offset_deg_s], dtype=float))

    @property
    def _norm_squared_range(self) -> tuple[float, float]:
        return (GRAVITY_M_S2 - self.eta_m_s2) ** 2, (GRAVITY_M_S2 + self.eta_m_s2) ** 2

    def _rest_samples(self, sampling_rate_hz: float) -> int:
        return 1 + round(self.rest_s * sampling_rate_hz)

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, 0.0, 0.0

    @property
    def _extras_are_angles(self) -> bool:
        return True

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        return self.mode == "real_time" and super().causal

    @property
    def _couples_as_it_runs(self) -> bool:
        return self.coupled and self.mode == "real_time"

    def _inputs(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        if self.mode == "offline":
            rates, force = self._clean(self._coupled_by_a_first_pass(signals))
        else:
            rates, force = self._low_pass(signals)
        low, high = self._norm_squared_range
        norm_squared = (force**2).sum(axis=1)
        resting = (low < norm_squared) & (norm_squared < high)
        resting &= (np.abs(rates[:, self.columns]) < self.rate_threshold_rad_s).all(axis=1)
        rested = _run_lengths(resting) >= self._rest_samples(signals.sampling_rate_hz)
        angles = np.full_like(rates, np.nan)
        angles[rested, :TRANSVERSE] = tilt_from_specific_force(force[rested])
        return rates, angles

    def _coupled_by_a_first_pass(self, signals: SegmentSignals) -> SegmentSignals:
        """Convert to the rates of the angles by a first pass, before the mean is subtracted."""
        if not self.coupled:
            return signals
        first = copy(self)
        first.coupled = False
        tilt_rad = first.estimate(signals)
        return replace(signals, axis_rates_rad_s=coupled_rates(signals.axis_rates_rad_s, tilt_rad))

    def _clean(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        """Remove noise and offset from the gyroscope by centred moving averages."""
        rates, rate_hz = signals.axis_rates_rad_s, signals.sampling_rate_hz
        window_s = self.offset_window_s
        if window_s is None:
            found = stride_frequency_hz(rates[:, SAGITTAL], rate_hz)
            window_s = 2.0 / found if np.isfinite(found) else _PAPERS_OFFSET_WINDOW_S
        offset = centred_moving_average(rates, window_s, rate_hz)
        clean = centred_moving_average(rates, self.noise_window_s, rate_hz) - offset
        return clean, signals.specific_force_m_s2

    def _butterworth(self, sampling_rate_hz: float) -> tuple[FloatArray, FloatArray] | None:
        if self.low_pass_hz is None:
            return None
        if self.low_pass_hz >= 0.5 * sampling_rate_hz:
            raise MethodNotApplicableError(
                f"method {self.name}: low_pass_hz is {self.low_pass_hz:g}, expected less than "
                f"half the sampling rate of {sampling_rate_hz:g} Hz"
            )
        return signal.butter(2, self.low_pass_hz, fs=sampling_rate_hz)

    def _low_pass(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        coefficients = self._butterworth(signals.sampling_rate_hz)
        if coefficients is None:
            rates, force = signals.axis_rates_rad_s, signals.specific_force_m_s2
            return rates - self.static_offset_rad_s, force
        b, a = coefficients
        six = np.hstack([signals.axis_rates_rad_s, signals.specific_force_m_s2])
        # steady state at the first sample: no transient from zero
        smooth, _ = signal.lfilter(b, a, six, axis=0, zi=signal.lfilter_zi(b, a)[:, None] * six[0])
        return smooth[:, :3] - self.static_offset_rad_s, smooth[:, 3:]

    def _inputs_one_by_one(self, sampling_rate_hz: float) -> Inputs:
        if self.mode == "offline":
            raise MethodNotApplicableError(
                f"method {self.name}: mode=offline needs the whole recording; "
                "mode=real_time runs sample by sample"
            )
        return _GiofInputs(self, sampling_rate_hz)


class _GiofInputs:
    def __init__(self, method: Giof, sampling_rate_hz: float) -> None:
        coefficients = method._butterworth(sampling_rate_hz)
        self.low_pass = None if coefficients is None else [_Biquad(*coefficients) for _ in range(6)]
        self.offset = method.static_offset_rad_s.tolist()
        self.columns, self.wanted = method.columns, range(3) if method.coupled else method.columns
        self.norm_squared_range = method._norm_squared_range
        self.threshold = method.rate_threshold_rad_s
        self.needed, self.rested = method._rest_samples(sampling_rate_hz), 0

    def __call__(
        self, axis_rates: FloatArray, specific_force: FloatArray
    ) -> tuple[Sequence[Any], Sequence[Any]]:
        rates: list[Any] = [0.0] * 3
        for axis in self.wanted:
            rates[axis] = self._smooth(axis, axis_rates[axis]) - self.offset[axis]
        x, y, z = (self._smooth(3 + i, specific_force[i]) for i in range(3))
        resting = gravity_alone(x, y, z, *self.norm_squared_range) and all(
            abs(rates[axis]) < self.threshold for axis in self.columns
        )
        self.rested = self.rested + 1 if resting else 0
        angles: list[Any] = [np.nan] * 3
        if self.rested >= self.needed:
            for axis in self.columns:
                angles[axis] = tilt(axis == FRONTAL, x, y, z)
        return rates, angles

    def _smooth(self, channel: int, value: Any) -> Any:
        return value if self.low_pass is None else self.low_pass[channel](value)


def _run_lengths(true: BoolArray) -> NDArray[np.int64]:
    """Count the consecutive true samples up to and including each sample."""
    count = np.arange(1, len(true) + 1)
    return count - np.maximum.accumulate(np.where(true, 0, count))


class _Biquad:
    """Second-order filter in transposed direct form II, as in scipy, one sample at a time."""

    def __init__(self, b: FloatArray, a: FloatArray) -> None:
        self.b, self.a = b.tolist(), a.tolist()
        self.rest = signal.lfilter_zi(b, a).tolist()
        self.memory: tuple[Any, Any] | None = None

    def __call__(self, value: Any) -> Any:
        b, a = self.b, self.a
        first, second = self.memory or (self.rest[0] * value, self.rest[1] * value)
        out = b[0] * value + first
        self.memory = b[1] * value - a[1] * out + second, b[2] * value - a[2] * out
        return out
