"""What the two adapters to the library `ahrs` share."""

from typing import Any, ClassVar

import numpy as np

from narx.baselines.orientation_filter import AnglesOneByOne, angles_of
from narx.baselines.parameters import optional_library
from narx.kinematics.segment_angles import gyroscope_xyz, orientation_from_angles
from narx.method import OrientationMethod, SegmentSignals, Step
from narx.types import FloatArray


class AhrsFilter(OrientationMethod):
    """A filter of the library `ahrs` with gyroscope and accelerometer.

    Parameters
    ----------
    parameters : dict
        Passed to the library's class as they are.

    Raises
    ------
    MethodNotApplicableError
        If the package `ahrs` is not installed.

    Notes
    -----
    Starts from the initial angles where they are known, otherwise, as the library does, from
    the first accelerometer sample.
    """

    library_class: ClassVar[str]
    needs_accelerometer = True
    streams = True

    def __init__(self, parameters: dict[str, float]) -> None:
        filters = optional_library(self.name, "ahrs").filters
        self._class: Any = getattr(filters, self.library_class)
        self._parameters = parameters

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        if not signals.n_samples:
            return np.empty((0, 3))
        initial = signals.initial_angles_rad
        result = self._class(
            gyr=gyroscope_xyz(signals.axis_rates_rad_s),
            acc=np.ascontiguousarray(signals.specific_force_m_s2),
            frequency=signals.sampling_rate_hz,
            q0=None if initial is None else orientation_from_angles(initial)[0],
            **self._parameters,
        )
        return angles_of(result.Q, signals)

    def _stream(self, sampling_rate_hz: float) -> Step:
        running = self._class(frequency=sampling_rate_hz, **self._parameters)
        angles = AnglesOneByOne()
        quaternion: FloatArray | None = None

        def step(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            nonlocal quaternion
            gyroscope = gyroscope_xyz(axis_rates)
            force = np.asarray(specific_force, dtype=float)
            if quaternion is None:
                # the library's own start from one accelerometer sample
                first = self._class(
                    gyr=gyroscope[None],
                    acc=force[None],
                    frequency=sampling_rate_hz,
                    **self._parameters,
                )
                quaternion = first.Q[0]
            else:
                quaternion = running.updateIMU(quaternion, gyroscope, force)
            return angles(quaternion)

        return step
