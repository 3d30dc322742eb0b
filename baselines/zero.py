"""The zero angle: what a method must beat to have estimated anything."""

import numpy as np

from narx.method import OrientationMethod, SegmentSignals, Step
from narx.types import FloatArray


class Zero(OrientationMethod):
    """Say that the segment stands as in its calibration posture, always.

    Notes
    -----
    Its root mean square error is that of the reference itself, its SD that of the movement.
    """

    name = "zero"
    streams = True

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        return np.zeros((signals.n_samples, 3))

    def _stream(self, sampling_rate_hz: float) -> Step:
        return lambda axis_rates, specific_force: np.zeros(3)
