"""Network and tracker of B sensors at work, compiled."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from narx.inference.tracker import LinearRecursion, PostureTracker
from narx.inference.tracking import Tracking
from narx.kernels.tracked_stream import follow_many, follow_one
from narx.network.kernel_arrays import grouped
from narx.network.model import Narx
from narx.recursion import Clocked, ClockNumbers, CompiledClocked, Recursion, new_clock
from narx.types import BoolArray, FloatArray


class TrackedRecursion(Recursion):
    """The state of B sensors whose angles a recursion with a tracker estimates.

    Parameters
    ----------
    tracker : PostureTracker
        Parameters of the filter.
    model : Narx or LinearRecursion
        The recursion; if a network, a coupled one.
    n_sensors : int
        Sensors side by side.
    initial_angles_rad : ndarray, shape (B, 3), optional
        Known start poses; None where they are unknown.
    """

    def __init__(
        self,
        tracker: PostureTracker,
        model: Narx | LinearRecursion,
        n_sensors: int = 1,
        initial_angles_rad: FloatArray | None = None,
    ) -> None:
        starts = [None] * n_sensors if initial_angles_rad is None else list(initial_angles_rad)
        self.trackings = [Tracking(tracker, model, start) for start in starts]
        self._std_scale = tracker.std_scale

    def advance(
        self, samples: FloatArray, first: NDArray[np.int64]
    ) -> tuple[FloatArray, BoolArray]:
        """Advance all sensors.

        Parameters
        ----------
        samples : ndarray, shape (M, C)
            Rates, and forces if aided, those of a sensor one after another; NaN where missing.
        first : ndarray of int, shape (B + 1,)
            Where each sensor's samples begin.

        Returns
        -------
        angles : ndarray, shape (M, 3)
            rad.
        starting : ndarray of bool, shape (M,)
            Samples at which the rates were integrated.
        """
        followed = [
            tracking.follow(samples[begin:end, :3], samples[begin:end, -3:])
            for tracking, begin, end in zip(self.trackings, first, first[1:], strict=False)
        ]
        angles = np.concatenate([one.angles_rad for one in followed])
        return angles, ~np.concatenate([one.by_network for one in followed])

    def clocked(
        self, numbers: ClockNumbers, shape: tuple[int, int], stds_rad: FloatArray | None
    ) -> Clocked:
        """Put a clock before the recursion.

        Parameters
        ----------
        numbers : ClockNumbers
            Of the clock.
        shape : tuple of two ints
            Sensors, and columns of their samples.
        stds_rad : ndarray, shape (2, 3), or None
            Not used: the tracker has a standard deviation of each sample.

        Returns
        -------
        Clocked
            Goes on from the present state, by itself.
        """
        clock = np.hstack([new_clock(shape[0]), np.zeros((shape[0], shape[1] + 1))])
        packed = np.stack([tracking.packed for tracking in self.trackings])
        one = self.trackings[0]
        counts = numbers.lost_most, one.hidden, len(one.x), one.rates.shape[1]
        constants: list[ArrayLike] = [
            counts,
            numbers[:3],
            self._std_scale,
            one.parameters,
            one.weights,
        ]
        joined = np.concatenate([np.ravel(part) for part in constants])
        return _ClockedTracker(joined, grouped(np.hstack([clock, packed])), True)


class _ClockedTracker(CompiledClocked):
    one, many = staticmethod(follow_one), staticmethod(follow_many)
