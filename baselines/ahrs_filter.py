"""Common base of Madgwick's and Mahony's filters: a quaternion updated sample by sample."""

from collections.abc import Hashable
from typing import Any, ClassVar

import numpy as np

from narx.baselines.orientation_filter import AnglesOneByOne, OrientationFilter
from narx.kinematics.segment_angles import (
    gyroscope_xyz,
    orientation_from_angles,
    tilt_from_specific_force,
)
from narx.method import SegmentSignals
from narx.recursion import Step
from narx.types import FloatArray


class AhrsFilter(OrientationFilter):
    """A compiled filter (`narx.kernels.ahrs`) with gyroscope and accelerometer.

    Parameters
    ----------
    gains : float or tuple of float
        Gains of the kernel.
    **heading : Any
        As in `narx.baselines.orientation_filter.OrientationFilter`.

    Notes
    -----
    Starts from the initial angles if known, otherwise from the tilt of the first
    accelerometer sample, and as the library `ahrs` estimates nothing at that sample.
    """

    kernel: ClassVar[Any]
    streams = True

    def __init__(self, gains: Any, **heading: Any) -> None:
        super().__init__(**heading)
        self._gains = gains

    @property
    def _settings(self) -> Hashable:
        return self._gains

    def _orientation(self, signals: SegmentSignals) -> FloatArray:
        initial = signals.initial_angles_rad
        force = np.ascontiguousarray(signals.specific_force_m_s2)
        out = np.empty((signals.n_samples, 4))
        out[0] = _from_gravity(force[0]) if initial is None else orientation_from_angles(initial)[0]
        type(self).kernel(
            gyroscope_xyz(signals.axis_rates_rad_s)[1:],
            force[1:],
            signals.interval_s,
            self._gains,
            out[0].copy(),
            np.zeros(3),
            out[1:],
        )
        return out

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        self.heading.refuse_stream(self.name)
        return _AhrsStep(type(self), 1.0 / sampling_rate_hz, self._gains, initial_angles_rad)


class _AhrsStep:
    def __init__(
        self, method: type[AhrsFilter], interval_s: float, gains: Any, initial: FloatArray | None
    ) -> None:
        self.method, self.interval_s, self.gains, self.initial = method, interval_s, gains, initial
        self.angles = AnglesOneByOne(initial)
        self.quaternion: FloatArray | None = None
        self.bias, self.out = np.zeros(3), np.empty((1, 4))

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        force = np.array(specific_force, dtype=float)
        if self.quaternion is None:
            if self.initial is None:
                self.quaternion = _from_gravity(force)
            else:
                self.quaternion = orientation_from_angles(self.initial)[0]
            return self.angles(self.quaternion)
        self.method.kernel(
            gyroscope_xyz(axis_rates)[None],
            force[None],
            self.interval_s,
            self.gains,
            self.quaternion,
            self.bias,
            self.out,
        )
        return self.angles(self.out[0])


def _from_gravity(specific_force_m_s2: FloatArray) -> FloatArray:
    tilt = tilt_from_specific_force(specific_force_m_s2)
    return np.asarray(orientation_from_angles(np.append(tilt, 0.0))[0])
