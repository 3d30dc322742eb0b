"""A running method: its state after the samples so far, for several parallel sensors."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from narx.types import BoolArray, FloatArray


class Step(Protocol):
    """One sensor's recursion, which can be pickled and copied."""

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
    """The state of B sensors, which samples without a gap advance."""

    @abstractmethod
    def advance(
        self, samples: FloatArray, first: NDArray[np.int64]
    ) -> tuple[FloatArray, BoolArray]:
        """Advance all sensors.

        Parameters
        ----------
        samples : ndarray, shape (M, C)
            As from `narx.method.OrientationMethod.samples`, those of a sensor one after another.
        first : ndarray of int, shape (B + 1,)
            Where each sensor's samples begin.

        Returns
        -------
        angles : ndarray, shape (M, 3)
            rad.
        starting : ndarray of bool, shape (M,)
            Samples that belong to a start-up.
        """


class SampleBySample(Recursion):
    """Methods that advance one sensor by one sample.

    Parameters
    ----------
    steps : sequence of Step
        One a sensor.
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
            False throughout.
        """
        angles, no_force = np.empty((len(samples), 3)), np.full(3, np.nan)
        for step, begin, end in zip(self.steps, first, first[1:], strict=False):
            for k in range(begin, end):
                force = samples[k, 3:] if samples.shape[1] > 3 else no_force
                angles[k] = step(samples[k, :3], force)
        return angles, np.zeros(len(samples), dtype=bool)
