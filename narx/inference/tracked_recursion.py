"""Network and tracker of B sensors at work, compiled."""

import numpy as np
from numpy.typing import NDArray

from narx.inference.tracker import LinearRecursion, PostureTracker
from narx.inference.tracking import Tracking
from narx.kernels.threads import in_threads
from narx.kernels.tracked_stream import follow
from narx.network.model import Narx
from narx.recursion import Clocked, ClockNumbers, Recursion, new_clock
from narx.types import BoolArray, FloatArray

# sensors that are worth a thread of their own
_TOGETHER = 256


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
        return _ClockedTracker(
            np.hstack([clock, packed]), numbers, self._std_scale, self.trackings[0]
        )


class _ClockedTracker(Clocked):
    def __init__(
        self,
        state: FloatArray,
        numbers: ClockNumbers,
        std_scale: tuple[float, float, float],
        tracking: Tracking,
    ) -> None:
        self._state = state
        self._numbers = np.concatenate(
            [
                numbers[:3],
                std_scale,
                tracking.parameters,
                tracking.weights,
            ]
        )
        self._counts = (
            numbers.lost_most,
            tracking.hidden,
            len(tracking.x),
            tracking.rates.shape[1],
        )

    def follow(
        self, samples: FloatArray, stamps: FloatArray
    ) -> tuple[FloatArray, FloatArray | None, NDArray[np.int8]]:
        n_sensors, n_samples = samples.shape[:2]
        # two arrays: views of one would cost as much again as the samples themselves
        angles = np.empty((n_sensors, n_samples, 3))
        stds = np.empty((n_sensors, n_samples, 3))
        quality = np.empty((n_sensors, n_samples), np.int8)
        if n_sensors < 2 * _TOGETHER:
            follow(
                samples, stamps, self._numbers, *self._counts, self._state, angles, stds, quality
            )
            return angles, stds, quality

        def part(first: int, last: int) -> None:
            at = slice(first, last)
            follow(
                samples[at], stamps[at], self._numbers, *self._counts,
                self._state[at], angles[at], stds[at], quality[at],
            )  # fmt: skip

        in_threads(part, n_sensors, _TOGETHER)
        return angles, stds, quality
