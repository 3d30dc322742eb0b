"""Leaky integrator: the simplest recursion that does not drift, with one parameter."""

from narx.baselines.parameters import positive
from narx.baselines.recursive import Constants, GivenStartUp
from narx.baselines.trackable import GivenTracker, TrackableMethod
from narx.inference.tracker import LinearRecursion
from narx.kernels.recursions import leak


class LeakyIntegrator(TrackableMethod):
    """Integrate each axis with a leak of one time constant.

    Parameters
    ----------
    leak_rad_s : float
        Leak, rad/s: one over the time constant.
    coupled, start_up, washout_s, smoothing, tracker
        As in `narx.baselines.trackable.TrackableMethod`.

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
        tracker: GivenTracker = None,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing, tracker)
        self.leak_rad_s = positive(self.name, "leak_rad_s", leak_rad_s)

    def _parameters(self, interval_s: float) -> Constants:
        return interval_s, 1.0 / (1.0 + interval_s * self.leak_rad_s), 0.0

    def _linear(self, sampling_rate_hz: float) -> LinearRecursion:
        interval_s, kept, _ = self._parameters(1.0 / sampling_rate_hz)
        share = 0.5 * interval_s * kept
        return LinearRecursion(sampling_rate_hz, (share, share), (kept, 0.0))
