"""Pseudo-integrator: a band-pass that integrates above its breakpoint and attenuates below it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from narx.baselines.parameters import one_of, positive
from narx.baselines.recursive import Constants, GivenStartUp, Inputs, RecursiveMethod
from narx.errors import MethodNotApplicableError
from narx.gait.stride_frequency import StrideFrequencyTracker, stride_frequency_hz
from narx.kernels.recursions import band_pass
from narx.kinematics.segment_angles import SAGITTAL
from narx.method import SegmentSignals
from narx.types import FloatArray


class PseudoIntegrator(RecursiveMethod):
    """Integrate each axis with two real poles instead of the integrator's pole at zero.

    Parameters
    ----------
    breakpoint_ratio : float
        Breakpoint divided by gait frequency, both in rad/s. The default, 1 / (2 pi), interprets
        'the breakpoint frequency is the gait frequency' as the value in Hz used in rad/s. 1 is the
        literal interpretation, with a phase of 0 instead of -90 degrees at the gait frequency, so
        that the output is proportional to the rate.
    gait_frequency_hz : float, optional
        Stride frequency; None detects it from the sagittal rate.
    frequency : {"constant", "following"}
        Without `gait_frequency_hz`: one frequency for the whole recording, or that of the past
        strides, which also works sample by sample.
    frequency_without_gait_hz : float
        Used if no walking is detected, and for 'following' until the first stride.
    coupled, start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.

    Notes
    -----
    Tham et al., eq. (9), from Holgate et al.: ``H(s) = tau^2 s / (tau s + 1)^2`` with
    ``tau = 1 / wn``, here as a leaky integrator followed by a high-pass filter,
    ``z' = v - z / tau``, ``w' = (z - w) / tau``, ``p = z - w``, by the trapezoidal rule
    (bilinear transform). Both states are angles, so a change of the breakpoint causes no jump.
    Starts from zero states, as in the paper, or from the start-up's; a static bias is removed, and
    so is the mean angle, except for the posture of a start-up.
    """

    name = "pseudo_integrator"
    _recursion = band_pass
    holds_first = False

    def __init__(
        self,
        breakpoint_ratio: float = 1.0 / (2.0 * np.pi),
        gait_frequency_hz: float | None = None,
        frequency: str = "constant",
        frequency_without_gait_hz: float = 0.9,
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.breakpoint_ratio = positive(self.name, "breakpoint_ratio", breakpoint_ratio)
        self.gait_frequency_hz = (
            None
            if gait_frequency_hz is None
            else positive(self.name, "gait_frequency_hz", gait_frequency_hz)
        )
        self.frequency = one_of(self.name, "frequency", frequency, ("constant", "following"))
        self.frequency_without_gait_hz = positive(
            self.name, "frequency_without_gait_hz", frequency_without_gait_hz
        )

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        detected = self.gait_frequency_hz is None and self.frequency == "constant"
        return not detected and super().causal

    @property
    def _tracker(self) -> StrideFrequencyTracker:
        return StrideFrequencyTracker(start_frequency_hz=self.frequency_without_gait_hz)

    def breakpoint_rad_s(self, signals: SegmentSignals) -> FloatArray:
        """Breakpoint that the filter uses, at every sample.

        Parameters
        ----------
        signals : SegmentSignals
            Signals without missing samples.

        Returns
        -------
        ndarray, shape (N,)
            ``2 pi * breakpoint_ratio * stride frequency``, rad/s.
        """
        sagittal = signals.axis_rates_rad_s[:, SAGITTAL]
        rate_hz = signals.sampling_rate_hz
        if self.gait_frequency_hz is not None:
            frequency = np.full(len(sagittal), self.gait_frequency_hz)
        elif self.frequency == "following":
            frequency = self._tracker.follow(sagittal, rate_hz)
        else:
            found = stride_frequency_hz(sagittal, rate_hz)
            constant = found if np.isfinite(found) else self.frequency_without_gait_hz
            frequency = np.full(len(sagittal), constant)
        return 2.0 * np.pi * self.breakpoint_ratio * frequency

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, 0.0, 0.0

    def _inputs(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        breakpoints = np.repeat(self.breakpoint_rad_s(signals)[:, None], 3, axis=1)
        return signals.axis_rates_rad_s, breakpoints

    def _inputs_one_by_one(self, sampling_rate_hz: float) -> Inputs:
        fixed_hz = self.gait_frequency_hz
        if fixed_hz is None and self.frequency == "constant":
            raise MethodNotApplicableError(
                f"method {self.name} detects its constant gait frequency from the whole "
                "recording: to run it sample by sample, give gait_frequency_hz or set "
                "frequency=following"
            )
        return _BreakpointInputs(
            self._tracker.start(sampling_rate_hz), fixed_hz, 2.0 * np.pi * self.breakpoint_ratio
        )


@dataclass
class _BreakpointInputs:
    track: Callable[[float], float]
    fixed_hz: float | None
    scale: float

    def __call__(
        self, axis_rates: FloatArray, specific_force: FloatArray
    ) -> tuple[FloatArray, Sequence[float]]:
        frequency = self.fixed_hz
        if frequency is None:
            frequency = self.track(axis_rates[SAGITTAL])
        return axis_rates, (self.scale * frequency,) * 3
