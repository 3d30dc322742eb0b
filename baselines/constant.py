"""A constant: the posture that the start-up finds, and no movement at all."""

import numpy as np

from narx.baselines.recursive import GivenStartUp
from narx.inference.composition import start_up_of
from narx.inference.start_up import StartUp
from narx.kernels.start_up import POSTURE_WEIGHT
from narx.method import OrientationMethod, SegmentSignals
from narx.types import FloatArray


class Constant(OrientationMethod):
    """Say that the segment stays in its mean posture of the first steps.

    Parameters
    ----------
    start_up : StartUp, mapping, bool, optional
        Finds the posture (`narx.inference.start_up`); True takes the default one.

    Notes
    -----
    What a start-up is worth without anything behind it. Where the start is unknown, or the
    recording ends before the posture is found, it is zero. The posture is given from the first
    sample on, before it can be known, so it does not run sample by sample.
    """

    name = "constant"

    def __init__(self, start_up: GivenStartUp = True) -> None:
        self.start_up = start_up_of(start_up, self.name) or StartUp()

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        state = self.start_up.begin(signals.initial_angles_rad)
        self.start_up.run(signals.axis_rates_rad_s, signals.interval_s, state)
        posture = np.zeros(3)
        if state[POSTURE_WEIGHT]:
            posture = StartUp.hand_over(state, signals.interval_s)[0]
        return np.tile(posture, (signals.n_samples, 1))
