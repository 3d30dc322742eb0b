"""Leaky integrator: the simplest recursion that does not drift, with one parameter."""

from narx.baselines.parameters import positive
from narx.baselines.recursive import Constants, GivenStartUp, RecursiveMethod
from narx.kernels.recursions import leak


class LeakyIntegrator(RecursiveMethod):
    """Integrate each axis with a leak of one time constant.

    Parameters
    ----------
    leak_rad_s : float
        Leak, rad/s: one over the time constant.
    coupled, start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.

    Notes
    -----
    ``1 / (s + leak)``, which is the corrected form of eqs. (4) to (6) of Tham et al.
    (`narx.training.initial_weights`). Backward Euler for the leak, the trapezoidal rule for the
    rate: ``p_k = (p_{k-1} + Ts (v_k + v_{k-1}) / 2) / (1 + Ts leak)``.
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
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.leak_rad_s = positive(self.name, "leak_rad_s", leak_rad_s)

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, 1.0 / (1.0 + interval_s * self.leak_rad_s), 0.0
