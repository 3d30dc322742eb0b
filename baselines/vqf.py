"""Adapter to VQF, the orientation filter of Laidig and Seel (library `vqf`)."""

from collections.abc import Hashable
from typing import Any

import numpy as np

from narx.baselines.orientation_filter import AnglesOneByOne, OrientationFilter
from narx.baselines.parameters import optional_library, positive
from narx.baselines.recursive import GivenStartUp
from narx.errors import MethodNotApplicableError
from narx.kinematics.segment_angles import gyroscope_xyz
from narx.method import SegmentSignals
from narx.recursion import Step
from narx.types import FloatArray


class Vqf(OrientationFilter):
    """VQF with gyroscope and accelerometer (6D), online or offline.

    Parameters
    ----------
    offline : bool
        False runs causally. True runs forwards and backwards over the whole recording.
    tau_acc_s : float
        Time constant of the inclination correction, s (`tauAcc`).
    motion_bias_estimation : bool
        Estimate the gyroscope's bias while moving (`motionBiasEstEnabled`).
    rest_bias_estimation : bool
        Estimate the gyroscope's bias at rest (`restBiasEstEnabled`).
    heading, heading_leak_rad_s, start_up
        As in `narx.baselines.orientation_filter.OrientationFilter`.

    Raises
    ------
    MethodNotApplicableError
        If the package `vqf` is not installed.

    Notes
    -----
    D. Laidig and T. Seel, "VQF: Highly accurate IMU orientation estimation with bias estimation
    and magnetic disturbance rejection", Information Fusion 91, 2023. Defaults are the
    library's. Initial angles are not supported: its inclination is determined by the first
    accelerometer samples, and its heading starts at zero.
    """

    name = "vqf"
    streams = True

    def __init__(
        self,
        offline: bool = False,
        tau_acc_s: float = 3.0,
        motion_bias_estimation: bool = True,
        rest_bias_estimation: bool = True,
        heading: str = "own",
        heading_leak_rad_s: float = 0.3,
        start_up: GivenStartUp = None,
    ) -> None:
        super().__init__(heading, heading_leak_rad_s, start_up)
        self._library = optional_library(self.name, "vqf")
        self.offline = offline
        self._parameters = {
            "tauAcc": positive(self.name, "tau_acc_s", tau_acc_s),
            "motionBiasEstEnabled": motion_bias_estimation,
            "restBiasEstEnabled": rest_bias_estimation,
        }

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        return not self.offline

    @property
    def _settings(self) -> Hashable:
        return self.offline, tuple(self._parameters.items())

    def _orientation(self, signals: SegmentSignals) -> FloatArray:
        gyroscope = gyroscope_xyz(signals.axis_rates_rad_s)
        accelerometer = np.ascontiguousarray(signals.specific_force_m_s2)
        if self.offline:
            result = self._library.offlineVQF(
                gyroscope, accelerometer, None, signals.interval_s, self._parameters
            )
        else:
            vqf = self._library.VQF(signals.interval_s, **self._parameters)
            result = vqf.updateBatch(gyroscope, accelerometer)
        return np.asarray(result["quat6D"])

    def _step(self, sampling_rate_hz: float, initial_angles_rad: FloatArray | None) -> Step:
        if self.offline:
            raise MethodNotApplicableError(
                f"method {self.name}: offline=true needs the whole recording; "
                "offline=false runs sample by sample"
            )
        self.heading.refuse_stream(self.name)
        return _VqfStep(1.0 / sampling_rate_hz, self._parameters, initial_angles_rad)


class _VqfStep:
    def __init__(
        self, interval_s: float, parameters: dict[str, Any], initial: FloatArray | None
    ) -> None:
        self._arguments = interval_s, parameters
        self._angles = AnglesOneByOne(initial)
        self._vqf = self._made()

    def _made(self) -> Any:
        interval_s, parameters = self._arguments
        return optional_library(Vqf.name, "vqf").VQF(interval_s, **parameters)

    def __call__(self, axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
        force = np.ascontiguousarray(specific_force, dtype=float)
        self._vqf.update(gyroscope_xyz(axis_rates), force)
        return self._angles(self._vqf.getQuat6D())

    # the library's objects cannot be pickled, but their state can be read and set
    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_vqf": self._vqf.state}

    def __setstate__(self, content: dict[str, Any]) -> None:
        vars(self).update(content)
        self._vqf = self._made()
        self._vqf.state = content["_vqf"]
