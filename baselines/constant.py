"""A constant angle: the posture estimated by the start-up."""

import numpy as np

from narx.baselines.recursive import GivenStartUp
from narx.inference.composition import start_up_of
from narx.inference.start_up import StartUp
from narx.method import OrientationMethod, SegmentSignals
from narx.types import FloatArray


class Constant(OrientationMethod):
    """Return the mean posture of the first steps at every sample.

    Parameters
    ----------
    start_up : StartUp, mapping, bool, optional
        Estimates the posture (`narx.inference.start_up`); True uses the default one.

    Notes
    -----
    Shows the accuracy of the start-up alone. If the start is unknown, or the recording ends before
    the posture is estimated, the posture is zero. It is returned from the first sample on, before
    it can be known, so the method does not run sample by sample.
    """

    name = "constant"

    def __init__(self, start_up: GivenStartUp = True) -> None:
        self.start_up = start_up_of(start_up, self.name) or StartUp()

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        state = self.start_up.begin(signals.initial_angles_rad)
        self.start_up.run(signals.axis_rates_rad_s, signals.interval_s, state)
        posture, *_ = StartUp.hand_over(state, signals.interval_s)
        return np.tile(posture, (signals.n_samples, 1))
