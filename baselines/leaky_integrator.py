"""Leaky integrator: the simplest recursion that does not drift, with one parameter."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from narx.baselines.parameters import positive
from narx.baselines.recursive import Constants, GivenStartUp, Inputs
from narx.baselines.trackable import GivenTracker, TrackableMethod
from narx.errors import UserError
from narx.inference.tracker import LinearRecursion
from narx.kernels.recursions import leak
from narx.method import SegmentSignals
from narx.types import FloatArray

# at this deviation the leak has grown by `by_angle`, at this rate it is as large as given
_ANGLE_RAD, _RATE_RAD_S = math.radians(30.0), 2.0
# a leg that stands still has no more than ten times the leak
_LEAST_RATE_RAD_S = 0.1 * _RATE_RAD_S


class LeakyIntegrator(TrackableMethod):
    """Integrate each axis with a leak of one time constant.

    Parameters
    ----------
    leak_rad_s : float
        Leak, rad/s: one over the time constant.
    coupled, start_up, washout_s, smoothing, tracker
        As in `narx.baselines.trackable.TrackableMethod`.
    by_angle : float
        Share by which the leak is larger 30 degrees from the posture; in between it grows with the
        square.
    by_rate : float
        Power of the size of the rate vector, over 2 rad/s, to which the leak is proportional:
        positive leaks while the leg swings, negative while it stands.

    Raises
    ------
    UserError
        If a value is out of its range, or the leak of a tracker depends on the state.

    Notes
    -----
    ``1 / (s + leak)``, which is the corrected form of eqs. (4) to (6) of Tham et al.
    (`narx.training.initial_weights`). Backward Euler for the leak, the trapezoidal rule for the
    rate: ``p_k = (p_{k-1} + Ts (v_k + v_{k-1}) / 2) / (1 + Ts leak)``. With `by_angle` and
    `by_rate` ``leak = leak_rad_s (1 + by_angle (p_{k-1} / 30 deg)^2) (|v_k| / 2 rad/s)^by_rate``,
    as a nonlinear network could learn it.
    """

    name = "leaky_integrator"
    _recursion = leak

    def __init__(
        self,
        leak_rad_s: float = 0.2,
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
        tracker: GivenTracker = None,
        by_angle: float = 0.0,
        by_rate: float = 0.0,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing, tracker)
        self.leak_rad_s = positive(self.name, "leak_rad_s", leak_rad_s)
        for name, value, least in (("by_angle", by_angle, 0.0), ("by_rate", by_rate, -1.0)):
            if not (isinstance(value, int | float) and least <= value <= 100.0):
                raise UserError(
                    f"method {self.name}: {name} is {value!r}, expected a number from {least:g} "
                    "to 100"
                )
        if self.tracker is not None and (by_angle or by_rate):
            raise UserError(
                f"method {self.name}: a tracker needs a constant leak, by_angle=0 and by_rate=0"
            )
        self.by_angle, self.by_rate = float(by_angle), float(by_rate)

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, self.leak_rad_s, self.by_angle / _ANGLE_RAD**2

    def _inputs(self, signals: SegmentSignals) -> tuple[FloatArray, FloatArray]:
        rates = signals.axis_rates_rad_s
        return rates, np.repeat(self._factor(rates)[:, None], 3, axis=1)

    def _inputs_one_by_one(self, sampling_rate_hz: float) -> Inputs:
        return self._input

    def _input(
        self, axis_rates: FloatArray, specific_force: FloatArray
    ) -> tuple[FloatArray, Sequence[Any]]:
        return axis_rates, (self._factor(axis_rates),) * 3

    def _factor(self, rates_rad_s: FloatArray) -> Any:
        """Rates (..., 3) to the factor (...) on the leak."""
        if not self.by_rate:
            return np.ones(np.shape(rates_rad_s)[:-1])
        size = np.sqrt(np.sum(rates_rad_s**2, axis=-1))
        return (np.maximum(size, _LEAST_RATE_RAD_S) / _RATE_RAD_S) ** self.by_rate

    def _linear(self, sampling_rate_hz: float) -> LinearRecursion:
        interval_s = 1.0 / sampling_rate_hz
        kept = 1.0 / (1.0 + interval_s * self.leak_rad_s)
        share = 0.5 * interval_s * kept
        return LinearRecursion(sampling_rate_hz, (share, share), (kept, 0.0))
