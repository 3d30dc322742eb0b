"""Plain integration of the gyroscope: the drift that every other method is there to remove."""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from narx.baselines.parameters import one_of
from narx.kernels.strapdown import compose_turns
from narx.kinematics.segment_angles import (
    TRANSVERSE,
    angles_from_orientation,
    gyroscope_xyz,
)
from narx.kinematics.strapdown import strapdown_orientation
from narx.method import OrientationMethod, SegmentSignals, Step
from narx.types import FloatArray


class GyroIntegration(OrientationMethod):
    """Integrate the angular rate from the initial angles, or from zero.

    Parameters
    ----------
    rule : {"trapezoid", "rectangle"}
        How the rate goes between two samples: straight from one to the next, or the later value
        all the way (Han et al., eq. (9), as printed; it runs half a sample ahead).
    coupled : bool
        False integrates each axis on its own, as the papers do, which books a turn of a tilted
        segment as flexion. True composes the rotations of all three axes (strapdown
        integration).
    """

    name = "gyro_integration"
    streams = True

    def __init__(self, rule: str = "trapezoid", coupled: bool = False) -> None:
        self.rule = one_of(self.name, "rule", rule, ("trapezoid", "rectangle"))
        self.coupled = coupled

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        initial = signals.initial_angles_rad
        start = np.zeros(3) if initial is None else np.asarray(initial, dtype=float)
        rates, interval_s = signals.axis_rates_rad_s, signals.interval_s
        if not len(rates):
            return np.empty((0, 3))
        if self.coupled:
            orientation = strapdown_orientation(_between(rates, self.rule), interval_s, start)
            angles = angles_from_orientation(orientation)
            # the heading goes on from where it was, even beyond half a turn
            angles[:, TRANSVERSE] += _whole_turns(start[TRANSVERSE] - angles[0, TRANSVERSE])
            return angles
        if self.rule == "trapezoid":
            return start + cumulative_trapezoid(rates, dx=interval_s, axis=0, initial=0.0)
        turned = np.cumsum(rates, axis=0) - rates[0]
        return start + interval_s * turned

    def _stream(self, sampling_rate_hz: float) -> Step:
        interval_s = 1.0 / sampling_rate_hz
        return self._coupled_stream(interval_s) if self.coupled else self._axis_stream(interval_s)

    def _axis_stream(self, interval_s: float) -> Step:
        trapezoid = self.rule == "trapezoid"
        angles = [0.0, 0.0, 0.0]
        before: list[float] | None = None

        def step(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            nonlocal before
            rates = [axis_rates[0], axis_rates[1], axis_rates[2]]
            if before is not None:
                for axis in range(3):
                    if trapezoid:
                        turned = (0.5 * interval_s) * (rates[axis] + before[axis])
                    else:
                        turned = interval_s * rates[axis]
                    angles[axis] = angles[axis] + turned
            before = rates
            return np.array(angles)

        return step

    def _coupled_stream(self, interval_s: float) -> Step:
        orientation = np.array([1.0, 0.0, 0.0, 0.0])
        before: FloatArray | None = None
        heading = 0.0

        def step(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            nonlocal orientation, before, heading
            if before is not None:
                between = _between(np.stack([before, axis_rates]), self.rule)
                orientation = compose_turns(orientation, gyroscope_xyz(between * interval_s))[-1]
            before = np.array(axis_rates, dtype=float)
            angles = angles_from_orientation(orientation)[0]
            angles[TRANSVERSE] += _whole_turns(heading - angles[TRANSVERSE])
            heading = float(angles[TRANSVERSE])
            return angles

        return step


def _between(rates: FloatArray, rule: str) -> FloatArray:
    return 0.5 * (rates[1:] + rates[:-1]) if rule == "trapezoid" else rates[1:]


def _whole_turns(difference_rad: float) -> float:
    """Multiple of a full turn nearest to a difference, rad."""
    return float(2.0 * np.pi * np.round(difference_rad / (2.0 * np.pi)))
