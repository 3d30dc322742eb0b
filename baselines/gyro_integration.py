"""Plain integration of the gyroscope: it shows the drift that the other methods remove."""

from narx.baselines.parameters import one_of
from narx.baselines.recursive import Constants, GivenStartUp, RecursiveMethod
from narx.kernels.recursions import integrate


class GyroIntegration(RecursiveMethod):
    """Integrate the angular rate of each axis from the initial angles, or from zero.

    Parameters
    ----------
    rule : {"trapezoid", "rectangle"}
        Rate between two samples: linear, or constant at the later value (Han et al., eq. (9), as
        printed; it is half a sample ahead).
    coupled : bool
        False treats the axes independently, as in the papers, so that a turn of a tilted segment
        appears as flexion. True integrates the rates of the angles (Euler kinematics);
        `narx.baselines.strapdown.Strapdown` composes rotations and has no singular angle.
    start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.
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
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, float(self.rule == "trapezoid"), 0.0
