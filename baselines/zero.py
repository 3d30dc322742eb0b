"""The zero angle: the lower benchmark for every method."""

import numpy as np

from narx.method import OrientationMethod, SegmentSignals
from narx.recursion import Step
from narx.types import FloatArray


class Zero(OrientationMethod):
    """Return zero at every sample: the segment stays in its calibration posture.

    Notes
    -----
    Its root mean square error is that of the reference itself, its SD that of the movement.
    """

    name = "zero"
    streams = True

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        return np.zeros((signals.n_samples, 3))

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        return _ZeroStep()


class _ZeroStep:
    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        return np.zeros(3)
