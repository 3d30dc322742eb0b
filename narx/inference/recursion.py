"""Compiled recursion of a trained network: start-up, network and washout of B sensors."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from narx.inference.start_up import StartUp
from narx.kernels import sample_steps as kernel
from narx.kernels.network_stream import follow_many, follow_one
from narx.network.kernel_arrays import grouped, kernel_shape
from narx.network.model import Narx
from narx.recursion import Clocked, ClockNumbers, CompiledClocked, Recursion, new_clock
from narx.types import BoolArray, FloatArray


class NarxRecursion(Recursion):
    """The state of B sensors whose angles are estimated by one network.

    Parameters
    ----------
    model : Narx
        Trained network.
    start_up : StartUp
        Start-up of the network.
    washout_gain : float
        From `narx.inference.washout.washout_gain`.
    n_sensors : int
        Number of sensors that run in parallel.
    initial_angles_rad : ndarray, shape (B, 3), optional
        Known start poses; None if they are unknown.
    """

    def __init__(
        self,
        model: Narx,
        start_up: StartUp,
        washout_gain: float,
        n_sensors: int = 1,
        initial_angles_rad: FloatArray | None = None,
    ) -> None:
        scaled = model.normalisation
        scales = np.array(
            [
                scaled.rate_offset_rad_s,
                scaled.rate_scale_rad_s,
                scaled.angle_offset_rad,
                scaled.angle_scale_rad,
            ]
        )
        self._shape = kernel_shape(model.structure)
        self._network = (
            model.weights.detach().numpy().copy(),
            np.tile(scales, (3, 1)),
            washout_gain,
            model.coupled,
        )
        self._interval_s = 1.0 / model.sampling_rate_hz
        self._start_up = (
            start_up.duration_s,
            start_up.averaged_from_s,
            start_up.averaging_s,
            start_up.leak_rad_s,
            start_up.settling_gain,
            start_up.settling_s,
        )
        starts = [None] * n_sensors if initial_angles_rad is None else initial_angles_rad
        self.start = np.stack([start_up.begin(angles) for angles in starts])
        self.taken_over = np.full(n_sensors, start_up.duration_s <= 0)
        self.memory = np.zeros((n_sensors, kernel.PAST + 3 * model.structure.n_state, 1))
        self._sizes = (
            model.structure.hidden,
            model.structure.input_lags,
            model.structure.output_lags,
        )

    def advance(
        self, samples: FloatArray, first: NDArray[np.int64]
    ) -> tuple[FloatArray, BoolArray]:
        """Advance all sensors.

        Parameters
        ----------
        samples : ndarray, shape (M, 3)
            Rates about the clinical axes, rad/s, grouped by sensor.
        first : ndarray of int, shape (B + 1,)
            Index of each sensor's first sample.

        Returns
        -------
        angles : ndarray, shape (M, 3)
            Angles, rad.
        starting : ndarray of bool, shape (M,)
            Samples that belong to the start-up.
        """
        angles = np.empty((len(samples), 3))
        starting = np.zeros(len(samples), dtype=np.bool_)
        kernel.run_method(
            first,
            samples,
            self._interval_s,
            self._start_up,
            *self._network,
            self.start,
            self.taken_over,
            self.memory,
            np.empty((2, 3)),
            angles,
            starting,
            self._shape,
        )
        return angles, starting

    def clocked(
        self, numbers: ClockNumbers, shape: tuple[int, int], stds_rad: FloatArray | None
    ) -> Clocked:
        """Put a clock before the recursion.

        Parameters
        ----------
        numbers : ClockNumbers
            Of the clock.
        shape : tuple of two ints
            Sensors, and columns of their samples.
        stds_rad : ndarray, shape (2, 3), or None
            From `narx.method.OrientationMethod.stds_rad`.

        Returns
        -------
        Clocked
            Goes on from the present state, by itself.
        """
        weights, scales, gain, coupled = self._network
        stds = np.full(6, np.nan) if stds_rad is None else stds_rad.ravel()
        constants: list[ArrayLike] = [
            numbers,
            self._sizes,
            stds,
            self._start_up,
            (coupled, gain),
            scales.ravel(),
            weights,
        ]
        # no sample yet, so no angles at a tick and no start-up
        none = np.zeros(shape), np.full((shape[0], 3), np.nan), np.zeros((shape[0], 1))
        state = [
            new_clock(shape[0]), *none, self.taken_over[:, None], self.start, self.memory[:, :, 0]
        ]  # fmt: skip
        return _ClockedNetwork(
            np.concatenate([np.ravel(part) for part in constants]),
            grouped(np.hstack(state)),
            stds_rad is not None,
        )


class _ClockedNetwork(CompiledClocked):
    one, many = staticmethod(follow_one), staticmethod(follow_many)
