"""A trained network as an orientation method: three angles from a gyroscope's recording."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray

from narx.errors import MethodNotApplicableError
from narx.inference.clocks import RateConversion
from narx.inference.composition import Composition
from narx.inference.recursion import NarxRecursion
from narx.inference.start_up import StartUp
from narx.inference.washout import WASHOUT_S, washout_gain
from narx.kernels.clock import AFTER_PAUSE, ARRIVED, MISSING, ON_TICK, STARTING
from narx.method import Estimate, OrientationMethod, SegmentSignals, longest_gap_s
from narx.network.model import Narx
from narx.recursion import Recursion
from narx.settings import Flag, checked
from narx.types import BoolArray, FloatArray

AxisScaling = Literal["training", "own"]


@dataclass(frozen=True)
class NetworkEstimate(Estimate):
    """Output of a network for a whole recording.

    Parameters
    ----------
    angles_rad, std_rad
        As in `narx.method.Estimate`.
    starting : ndarray of bool, shape (N,)
        Samples at which the rates were integrated without the network; False at missing samples.
    quality : ndarray of int8, shape (N,)
        A `narx.inference.stream.Quality` each, the same as from a stream: what stands behind the
        angles.
    """

    starting: BoolArray
    quality: NDArray[np.int8]


class NarxMethod(OrientationMethod):
    """Run a trained network on the gyroscope only.

    Parameters
    ----------
    model : Narx
        Trained network.
    start_up : StartUp
        Start-up that estimates the posture; ``duration_s=0`` starts from zero.
    axis_scaling : {"training", "own"}
        Normalisation of axes on which the network was not trained, which Tham et al. do not
        specify: by the scale of training, or each by the amplitude of its own rate (root mean
        square over the recording, which excludes running sample by sample).
    error_std_rad : ndarray, shape (3,), optional
        Standard deviation of the error per axis, from training; None if unknown.
    start_std_rad : ndarray, shape (3,), optional
        The same during the start-up; None or NaN if not known separately.
    washout_s : float, optional
        Time constant with which a constant deviation from the posture is removed
        (`narx.inference.washout`), s; None for no washout.
    smoothing : bool
        Average a forward and a backward pass (`narx.inference.smoothing`): smaller errors, whole
        recordings only.

    Raises
    ------
    UserError
        If the axis scaling is unknown or the washout not positive.
    """

    name = "narx"
    streams = True

    @checked
    def __init__(
        self,
        model: Narx,
        start_up: StartUp | None = None,
        axis_scaling: AxisScaling = "training",
        error_std_rad: FloatArray | None = None,
        start_std_rad: FloatArray | None = None,
        washout_s: float | None = WASHOUT_S,
        smoothing: Flag = False,
    ) -> None:
        self.model = model
        self.start_up = start_up or StartUp()
        self.axis_scaling = axis_scaling
        self.error_std_rad = error_std_rad
        self.start_std_rad = start_std_rad
        self.smoothing = smoothing
        self._composition = Composition(self.start_up, washout_s, smoothing)

    @property
    def causal(self) -> bool:
        """Whether angles depend only on past samples."""
        return not self.smoothing and self.axis_scaling == "training"

    def run(self, signals: SegmentSignals) -> NetworkEstimate:
        """Estimate angles, their standard deviation, and what stands behind each sample.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        NetworkEstimate
            Standard deviations are None if the network has none, and with smoothing: they were
            measured with a single pass and are too large for two. The end of the start-up is
            accurate to one sample at other rates than the network's.
        """
        there = self.usable(signals)
        starting = self._starting(signals, there)
        std, stds = None, self.stds_rad()
        if stds is not None:
            std = stds[starting.astype(int)]
            std[~there] = np.nan
        quality = quality_of(there, starting, signals.interval_s)
        return NetworkEstimate(self.estimate(signals), std, starting, quality)

    def stds_rad(self) -> FloatArray | None:
        """Standard deviations of the error after the start-up and during it.

        Returns
        -------
        ndarray, shape (2, 3), or None
            Standard deviations, rad; None as from `run`.
        """
        if self.error_std_rad is None or self.smoothing:
            return None
        after = np.asarray(self.error_std_rad, dtype=float)
        start = after if self.start_std_rad is None else self.start_std_rad
        return np.stack([after, np.where(np.isfinite(start), start, after)])

    @property
    def takes_over(self) -> str:
        """When the network takes over from the start-up, as text."""
        return f"after {self.start_up.duration_s:g} s of movement"

    def with_doubtful_bias(self) -> "NarxMethod":
        """Return the method for a recording whose gyroscope bias is unknown.

        Returns
        -------
        NarxMethod
            The same method: without a tracker it cannot estimate a bias.
        """
        return self

    def _starting(self, signals: SegmentSignals, there: BoolArray) -> BoolArray:
        starting = np.zeros(signals.n_samples, dtype=bool)
        if there.any():
            bridged, tick_of = self.bridged(signals)
            taken = self.start_up.run(
                bridged.axis_rates_rad_s,
                signals.interval_s,
                self.start_up.begin(signals.initial_angles_rad),
                self.model.coupled,
            )
            starting[there] = tick_of[there] < len(taken)
        return starting

    def _estimate(self, signals: SegmentSignals) -> FloatArray:
        rate_hz = self.model.sampling_rate_hz
        if np.isclose(signals.sampling_rate_hz, rate_hz, rtol=1e-6):
            return self._at_network_rate(signals.axis_rates_rad_s, signals.initial_angles_rad)
        conversion = RateConversion(signals.axis_rates_rad_s, signals.sampling_rate_hz, rate_hz)
        return conversion.to_recording(
            self._at_network_rate(conversion.network_rates_rad_s, signals.initial_angles_rad)
        )

    def _at_network_rate(
        self, rates_rad_s: FloatArray, initial_angles_rad: FloatArray | None
    ) -> FloatArray:
        if self.axis_scaling == "training" and not self._composition.smoothing:
            start = None if initial_angles_rad is None else initial_angles_rad[None]
            rates = np.ascontiguousarray(rates_rad_s, dtype=np.float64)
            angles, _ = self._compiled(1, start).advance(rates, np.array([0, len(rates)]))
            return angles
        recursion = _WholeRecording(self.model, self.axis_scaling, rates_rad_s)
        return self._composition.estimate(
            recursion, rates_rad_s, 1.0 / self.model.sampling_rate_hz, initial_angles_rad
        )

    def recursion(
        self, sampling_rate_hz: float, n_sensors: int, initial_angles_rad: FloatArray | None
    ) -> Recursion:
        """Start the method for use sample by sample (`narx.inference.stream`).

        Parameters
        ----------
        sampling_rate_hz : float
            Sampling rate, which must be the network's.
        n_sensors : int
            Number of sensors that run in parallel.
        initial_angles_rad : ndarray, shape (n_sensors, 3), optional
            Known start poses; None if they are unknown.

        Returns
        -------
        Recursion
            Recursion that gives the same angles as `estimate`.

        Raises
        ------
        MethodNotApplicableError
            If the rate differs from the network's, or the whole recording is needed.
        """
        rate_hz = self.model.sampling_rate_hz
        if not np.isclose(sampling_rate_hz, rate_hz, rtol=1e-6):
            raise MethodNotApplicableError(
                f"narx: this network runs sample by sample at {rate_hz:g} Hz, "
                f"not at {sampling_rate_hz:g} Hz"
            )
        self._composition.refuse_stream(self.name)
        if self.axis_scaling == "own":
            raise MethodNotApplicableError(
                "narx: axis_scaling=own needs the whole recording, use axis_scaling=training"
            )
        return self._compiled(n_sensors, initial_angles_rad)

    def _compiled(self, n_sensors: int, initial_angles_rad: FloatArray | None) -> NarxRecursion:
        gain = washout_gain(self._composition.washout_s, 1.0 / self.model.sampling_rate_hz)
        return NarxRecursion(self.model, self.start_up, gain, n_sensors, initial_angles_rad)


def quality_of(there: BoolArray, starting: BoolArray, interval_s: float) -> NDArray[np.int8]:
    """Return what stands behind the angles of each sample.

    Parameters
    ----------
    there : ndarray of bool, shape (N,)
        Samples that are not missing.
    starting : ndarray of bool, shape (N,)
        As in `NetworkEstimate`.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    ndarray of int8, shape (N,)
        As in `NetworkEstimate`.
    """
    quality = np.where(starting, STARTING, ARRIVED).astype(np.int8)
    quality[~there] = MISSING
    at = np.flatnonzero(there)
    gap_s = np.diff(at) * interval_s
    quality[at[1:][gap_s > longest_gap_s(interval_s) * (1.0 + ON_TICK)]] = AFTER_PAUSE
    return quality


class _WholeRecording:
    """The network on one recording, its axes scaled to the recording."""

    def __init__(self, model: Narx, axis_scaling: AxisScaling, rates_rad_s: FloatArray) -> None:
        self.coupled, self.holds_start = model.coupled, False
        self._model, self._rates = model, rates_rad_s
        self._relative: torch.Tensor | None = None
        if axis_scaling == "own":
            # the noise of an axis with hardly any movement must not be amplified
            rms = np.maximum(np.sqrt(np.mean(rates_rad_s**2, axis=0)), 1e-3)
            self._relative = torch.from_numpy(rms / model.normalisation.rate_rms_rad_s)

    def begin(self, initial_angles_rad: FloatArray | None) -> torch.Tensor | None:
        return None

    def take_over(self, *followed: FloatArray) -> torch.Tensor:
        parts = [torch.from_numpy(part) for part in followed]
        if self._relative is not None:
            parts = [part / self._relative for part in parts]
        return self._model.initial_state(*parts)

    def run(
        self,
        samples: slice,
        backwards: bool,
        state: torch.Tensor | None,
        posture_rad: FloatArray,
    ) -> FloatArray:
        signed = -self._rates[samples] if backwards else self._rates[samples]
        rates = torch.from_numpy(np.ascontiguousarray(signed))
        with torch.no_grad():
            angles, _ = self._model(rates, state, torch.from_numpy(posture_rad), self._relative)
        return np.asarray(angles.numpy())
