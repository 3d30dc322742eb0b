"""Strapdown integration: the rates about all three axes as one rotation."""

import numpy as np

from narx.baselines.parameters import one_of
from narx.kernels.strapdown import compose_turns
from narx.kinematics.segment_angles import (
    TRANSVERSE,
    angles_from_orientation,
    gyroscope_xyz,
    orientation_from_angles,
)
from narx.kinematics.strapdown import strapdown_orientation
from narx.method import OrientationMethod, SegmentSignals
from narx.recursion import Step
from narx.types import FloatArray


class Strapdown(OrientationMethod):
    """Compose the rotations about all three axes from the initial angles, or from zero.

    Parameters
    ----------
    rule : {"trapezoid", "rectangle"}
        Rate between two samples: linear, or constant at the later value.

    Notes
    -----
    ``R_k = R_{k-1} exp([w Ts]x)``: gyroscope only, without any assumption on the movement. It
    drifts only because of the remaining bias.
    """

    name = "strapdown"
    streams = True

    def __init__(self, rule: str = "trapezoid") -> None:
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        initial = signals.initial_angles_rad
        start = np.zeros(3) if initial is None else np.asarray(initial, dtype=float)
        if not signals.n_samples:
            return np.empty((0, 3))
        between = _between(signals.axis_rates_rad_s, self.rule)
        angles = angles_from_orientation(strapdown_orientation(between, signals.interval_s, start))
        # the heading is continuous, even beyond half a turn
        angles[:, TRANSVERSE] += _whole_turns(start[TRANSVERSE] - angles[0, TRANSVERSE])
        return angles

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        start = np.zeros(3) if initial_angles_rad is None else np.asarray(initial_angles_rad)
        return _StrapdownStep(1.0 / sampling_rate_hz, self.rule, start)


class _StrapdownStep:
    def __init__(self, interval_s: float, rule: str, start: FloatArray) -> None:
        self.interval_s, self.rule = interval_s, rule
        self.orientation = orientation_from_angles(start)[0]
        self.heading = float(start[TRANSVERSE])
        self.before: FloatArray | None = None

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        if self.before is not None:
            between = _between(np.stack([self.before, axis_rates]), self.rule)
            turns = gyroscope_xyz(between * self.interval_s)
            self.orientation = compose_turns(self.orientation, turns)[-1]
        self.before = np.array(axis_rates, dtype=float)
        angles = angles_from_orientation(self.orientation)[0]
        angles[TRANSVERSE] += _whole_turns(self.heading - angles[TRANSVERSE])
        self.heading = float(angles[TRANSVERSE])
        return angles


def _between(rates: FloatArray, rule: str) -> FloatArray:
    return 0.5 * (rates[1:] + rates[:-1]) if rule == "trapezoid" else rates[1:]


def _whole_turns(difference_rad: float) -> float:
    """Multiple of a full turn nearest to a difference, rad."""
    return float(2.0 * np.pi * np.round(difference_rad / (2.0 * np.pi)))
