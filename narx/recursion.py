"""Running methods: the state after the samples so far, for several sensors in parallel."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from narx.kernels.clock import CLOCK, MISSING, STAMP, collect, lay_out, longest_pause
from narx.kernels.threads import in_threads
from narx.types import BoolArray, FloatArray


class ClockNumbers(NamedTuple):
    """Parameters for converting samples to ticks of a uniform clock (`narx.kernels.clock.lay_out`).

    Parameters
    ----------
    limit_rad_s : float
        A rate above this is a fault.
    interval_s : float
        Time between ticks, s.
    max_gap_s : float
        Longest time between two samples across which ticks are interpolated, s.
    lost_most : int
        Largest number of ticks of a longer gap that the recursion receives as NaN.
    """

    limit_rad_s: float
    interval_s: float
    max_gap_s: float
    lost_most: int

    @property
    def longest_pause_s(self) -> float:
        """Time without a sample that is as good as any longer one."""
        return float(longest_pause(self.interval_s, self.max_gap_s, self.lost_most))


def new_clock(n_sensors: int) -> FloatArray:
    """Create the state of the clock before the first sample.

    Parameters
    ----------
    n_sensors : int
        Number of sensors that run in parallel.

    Returns
    -------
    ndarray, shape (n_sensors, 4)
        State for `narx.kernels.clock.arrive`.
    """
    clock = np.zeros((n_sensors, CLOCK))
    clock[:, STAMP] = np.nan
    return clock


class Clocked(ABC):
    """A recursion over samples with losses and jitter."""

    @abstractmethod
    def follow(
        self, samples: FloatArray, stamps: FloatArray
    ) -> tuple[FloatArray, FloatArray | None, NDArray[np.int8]]:
        """Advance all sensors.

        Parameters
        ----------
        samples : ndarray, shape (B, N, C)
            As from `narx.method.OrientationMethod.samples`; NaN where missing.
        stamps : ndarray, shape (B, N) or (B, 0)
            Sampling times, s; empty if the samples follow each other at the sampling rate.

        Returns
        -------
        angles : ndarray, shape (B, N, 3)
            Angles, rad; NaN where a sample is missing.
        std : ndarray, shape (B, N, 3), or None
            Standard deviation of their error, rad.
        quality : ndarray of int8, shape (B, N)
            As `narx.inference.stream.Quality`.
        """


class Step(Protocol):
    """The recursion of one sensor, which can be pickled and copied."""

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        """Advance by one sample.

        Parameters
        ----------
        axis_rates : ndarray, shape (3,)
            Angular rates about the clinical axes, rad/s.
        specific_force : ndarray, shape (3,)
            Accelerometer, m/s^2; NaN for a method that needs none.

        Returns
        -------
        ndarray, shape (3,)
            Angles, rad.
        """
        ...


class Recursion(ABC):
    """The state of B sensors, advanced by samples without gaps."""

    @abstractmethod
    def advance(
        self, samples: FloatArray, first: NDArray[np.int64]
    ) -> tuple[FloatArray, BoolArray]:
        """Advance all sensors.

        Parameters
        ----------
        samples : ndarray, shape (M, C)
            As from `narx.method.OrientationMethod.samples`, grouped by sensor.
        first : ndarray of int, shape (B + 1,)
            Index of each sensor's first sample.

        Returns
        -------
        angles : ndarray, shape (M, 3)
            rad.
        starting : ndarray of bool, shape (M,)
            Samples that belong to a start-up.
        """

    def clocked(
        self, numbers: ClockNumbers, shape: tuple[int, int], stds_rad: FloatArray | None
    ) -> Clocked:
        """Combine the recursion with a clock.

        Parameters
        ----------
        numbers : ClockNumbers
            Parameters of the clock.
        shape : tuple of two ints
            Number of sensors, and of columns of their samples.
        stds_rad : ndarray, shape (2, 3), or None
            From `narx.method.OrientationMethod.stds_rad`.

        Returns
        -------
        Clocked
            Recursion with a clock.
        """
        return _TickByTick(self, numbers, shape, stds_rad)


class _TickByTick(Clocked):
    """Compute all ticks first, then run the recursion over them."""

    def __init__(
        self,
        recursion: Recursion,
        numbers: ClockNumbers,
        shape: tuple[int, int],
        stds_rad: FloatArray | None,
    ) -> None:
        n_sensors = shape[0]
        self._recursion, self._numbers, self._stds_rad = recursion, numbers, stds_rad
        self._latest, self._clock = np.zeros(shape), new_clock(n_sensors)
        self._at_tick = np.full((n_sensors, 3), np.nan), np.zeros(n_sensors, dtype=np.bool_)

    def follow(
        self, samples: FloatArray, stamps: FloatArray
    ) -> tuple[FloatArray, FloatArray | None, NDArray[np.int8]]:
        shape = samples.shape[:2]
        tick_of, past = np.empty(shape, np.int64), np.empty(shape)
        quality, angles = np.empty(shape, np.int8), np.empty((*shape, 3))
        starting = np.empty(shape, np.bool_)
        ticks, first = lay_out(
            samples, stamps, *self._numbers, self._latest, self._clock, tick_of, past, quality
        )
        tick_angles, tick_starting = self._recursion.advance(ticks, first)
        collect(
            tick_angles, tick_starting, tick_of, past, samples, *self._at_tick,
            angles, starting, quality,
        )  # fmt: skip
        std = None
        if self._stds_rad is not None:
            std = self._stds_rad[starting.astype(np.intp)]
            std[quality == MISSING] = np.nan
        return angles, std, quality


# sensors that are worth a thread of their own
_TOGETHER = 256


class CompiledClocked(Clocked):
    """A recursion and its clock in one compiled function, many sensors in threads.

    Parameters
    ----------
    numbers : ndarray, shape (P,)
        Constants of the kernels.
    state : ndarray, shape (groups, S, W)
        State of the sensors, in groups of W side by side (`narx.network.kernel_arrays.grouped`);
        changed in place.
    has_stds : bool
        Whether the standard deviations are known.
    """

    # tuples of sizes among their arguments would take as long as the rest of the call
    one: Callable[..., None]
    many: Callable[..., None]

    def __init__(self, numbers: FloatArray, state: FloatArray, has_stds: bool) -> None:
        self._numbers, self._state, self._has_stds = numbers, state, has_stds

    def follow(
        self, samples: FloatArray, stamps: FloatArray
    ) -> tuple[FloatArray, FloatArray | None, NDArray[np.int8]]:
        """Advance all sensors.

        Parameters
        ----------
        samples, stamps : ndarray
            As for `Clocked.follow`.

        Returns
        -------
        angles, std, quality : ndarray
            As from `Clocked.follow`.
        """
        n_sensors, n_samples, _ = samples.shape
        angles = np.empty((n_sensors, n_samples, 3))
        stds = np.empty((n_sensors, n_samples, 3))
        quality = np.empty((n_sensors, n_samples), np.int8)
        if n_sensors == 1:
            self.one(samples, stamps, self._numbers, self._state, angles, stds, quality)
        else:
            width = self._state.shape[2]

            def part(first: int, last: int) -> None:
                at = slice(first * width, last * width)
                self.many(
                    samples[at], stamps[at], self._numbers, self._state[first:last],
                    angles[at], stds[at], quality[at],
                )  # fmt: skip

            in_threads(part, len(self._state), _TOGETHER // width)
        return angles, stds if self._has_stds else None, quality


class SampleBySample(Recursion):
    """Methods that advance one sensor by one sample.

    Parameters
    ----------
    steps : sequence of Step
        One step per sensor.
    """

    def __init__(self, steps: Sequence[Step]) -> None:
        self.steps = list(steps)

    def advance(
        self, samples: FloatArray, first: NDArray[np.int64]
    ) -> tuple[FloatArray, BoolArray]:
        """Advance all sensors, one sample after another.

        Parameters
        ----------
        samples : ndarray, shape (M, C)
            As for `Recursion.advance`.
        first : ndarray of int, shape (B + 1,)
            As for `Recursion.advance`.

        Returns
        -------
        angles : ndarray, shape (M, 3)
            rad.
        starting : ndarray of bool, shape (M,)
            All False.
        """
        angles, no_force = np.empty((len(samples), 3)), np.full(3, np.nan)
        for step, begin, end in zip(self.steps, first, first[1:], strict=False):
            for k in range(begin, end):
                force = samples[k, 3:] if samples.shape[1] > 3 else no_force
                angles[k] = step(samples[k, :3], force)
        return angles, np.zeros(len(samples), dtype=bool)
