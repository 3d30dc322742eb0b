"""Plain integration of the gyroscope: shows the drift that the other methods remove."""

from narx.baselines.parameters import one_of
from narx.baselines.recursive import Constants, GivenStartUp
from narx.baselines.trackable import GivenTracker, TrackableMethod
from narx.inference.tracker import LinearRecursion
from narx.kernels.recursions import integrate


class GyroIntegration(TrackableMethod):
    """Integrate the angular rate of each axis from the initial angles, or from zero.

    Parameters
    ----------
    rule : {"trapezoid", "rectangle"}
        Rate between two samples: linear, or constant at the later value (Han et al., eq. (9), as
        printed; it is half a sample ahead).
    coupled : bool
        False treats the axes independently, as in the papers, so that a turn of a tilted segment
        appears as flexion. True integrates the rates of the angles (Euler kinematics);
        `narx.baselines.strapdown.Strapdown` composes rotations and has no singularity.
    start_up, washout_s, smoothing, tracker
        As in `narx.baselines.trackable.TrackableMethod`.
    """

    name = "gyro_integration"
    _recursion = integrate

    def __init__(
        self,
        rule: str = "trapezoid",
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
        tracker: GivenTracker = None,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing, tracker)
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, float(self.rule == "trapezoid"), 0.0

    def _linear(self, sampling_rate_hz: float) -> LinearRecursion:
        interval_s, trapezoid, _ = self._parameters(1.0 / sampling_rate_hz)
        inputs = (0.5 * interval_s, 0.5 * interval_s) if trapezoid else (interval_s, 0.0)
        return LinearRecursion(sampling_rate_hz, inputs, (1.0, 0.0))
