"""Methods that can run beside a tracker: recursions of the gyroscope alone, which are linear."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

from narx.baselines.recursive import GivenStartUp, RecursiveMethod
from narx.errors import UserError
from narx.inference.composition import tracker_of
from narx.inference.tracked_recursion import TrackedRecursion
from narx.inference.tracker import LinearRecursion, PostureTracker
from narx.inference.tracking import Tracking, follow
from narx.kernels import tracker_layout as kernel
from narx.method import SegmentSignals
from narx.recursion import Recursion
from narx.types import FloatArray

GivenTracker = PostureTracker | Mapping[str, Any] | bool | None


class TrackableMethod(RecursiveMethod):
    """A recursion about a posture that is given by a start-up, or tracked.

    Parameters
    ----------
    coupled, start_up, washout_s, smoothing
        As in `narx.baselines.recursive.RecursiveMethod`.
    tracker : PostureTracker, mapping, bool, optional
        Learn posture and bias as the method runs (`narx.inference.tracker`), instead of start-up
        and washout, which are then not used; True uses the default one.

    Raises
    ------
    UserError
        If one of them is invalid, or the axes are not coupled for a tracker.
    """

    def __init__(
        self,
        coupled: bool = False,
        start_up: GivenStartUp = None,
        washout_s: float | None = None,
        smoothing: bool = False,
        tracker: GivenTracker = None,
    ) -> None:
        super().__init__(coupled, start_up, washout_s, smoothing)
        self.tracker = tracker_of(tracker, self.name)
        if self.tracker is None:
            return
        if not coupled:
            raise UserError(f"method {self.name}: a tracker needs coupled=true")
        # class variables of methods without such a choice
        self.counted_gap_s = kernel.LONGEST_GAP_S  # type: ignore[misc]
        self.needs_accelerometer = self.tracker.aided  # type: ignore[misc]

    @abstractmethod
    def _linear(self, sampling_rate_hz: float) -> LinearRecursion:
        """Return the recursion of one axis."""

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        if self.tracker is None:
            return super()._estimate(signals)
        linear = self._linear(signals.sampling_rate_hz)
        tracking = Tracking(self.tracker, linear, signals.initial_angles_rad)
        inputs = self.samples(signals.axis_rates_rad_s, signals.specific_force_m_s2)
        return follow(tracking, inputs, self.tracker.aided, self.composition.smoothing).angles_rad

    def recursion(
        self, sampling_rate_hz: float, n_sensors: int, initial_angles_rad: FloatArray | None
    ) -> Recursion:
        """Start the method for use as samples come (`narx.inference.stream`).

        Parameters
        ----------
        sampling_rate_hz : float
            Rate at which samples will come.
        n_sensors : int
            Sensors that run side by side.
        initial_angles_rad : ndarray, shape (n_sensors, 3), optional
            Known start poses; None where they are unknown.

        Returns
        -------
        Recursion
            Gives the angles that `estimate` gives.

        Raises
        ------
        MethodNotApplicableError
            With smoothing.
        """
        if self.tracker is None:
            return super().recursion(sampling_rate_hz, n_sensors, initial_angles_rad)
        self.composition.refuse_stream(self.name)
        linear = self._linear(sampling_rate_hz)
        return TrackedRecursion(self.tracker, linear, n_sensors, initial_angles_rad)
