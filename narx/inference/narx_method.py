"""A trained network as an orientation method: from a gyroscope's recording to three angles."""

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
import torch

from narx.errors import MethodNotApplicableError, UserError
from narx.inference.clocks import RateConversion
from narx.inference.smoothing import forward_share, turned_round
from narx.inference.start_up import StartUp
from narx.inference.washout import WASHOUT_S, wash_out, washout_gain
from narx.method import OrientationMethod, SegmentSignals, Step
from narx.network.model import Narx
from narx.types import BoolArray, FloatArray

AxisScaling = Literal["training", "own"]


class NarxMethod(OrientationMethod):
    """Run a trained network on the gyroscope alone.

    Parameters
    ----------
    model : Narx
        Trained network.
    start_up : StartUp
        How the first half minute finds the posture; ``duration_s=0`` starts from zero.
    axis_scaling : {"training", "own"}
        How axes are normalised on which the network was not trained, which Tham et al. leave
        open: with the scale of training, or each with its own gyroscope's amplitude (root mean
        square over the recording, so not sample by sample).
    error_std_rad : ndarray, shape (3,), optional
        Standard deviation of the error per axis, from training; None where it is not known.
    start_std_rad : ndarray, shape (3,), optional
        The same during the start-up; None or NaN where it is not known apart.
    washout_s : float, optional
        Time constant with which a lasting deviation from the posture is taken off
        (`narx.inference.washout`), s; None leaves it.
    smoothing : bool
        Run backwards as well and average (`narx.inference.smoothing`): smaller errors, whole
        recordings only.

    Raises
    ------
    UserError
        If the axis scaling is unknown or the washout not positive.
    """

    name = "narx"
    streams = True

    def __init__(
        self,
        model: Narx,
        start_up: StartUp | None = None,
        axis_scaling: AxisScaling = "training",
        error_std_rad: FloatArray | None = None,
        start_std_rad: FloatArray | None = None,
        washout_s: float | None = WASHOUT_S,
        smoothing: bool = False,
    ) -> None:
        if axis_scaling not in get_args(AxisScaling):
            raise UserError(
                f"axis_scaling is '{axis_scaling}', expected one of "
                f"{', '.join(get_args(AxisScaling))}"
            )
        self.model = model
        self.start_up = start_up or StartUp()
        self.axis_scaling = axis_scaling
        self.error_std_rad = error_std_rad
        self.start_std_rad = start_std_rad
        self.smoothing = smoothing
        self._washout_gain = washout_gain(washout_s, 1.0 / model.sampling_rate_hz)

    def standard_deviation(self, signals: SegmentSignals) -> FloatArray | None:
        """Predict the standard deviation of the error at every sample.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        ndarray, shape (N, 3), or None
            rad; NaN where a sample is missing. None if the network came without, and with
            smoothing: it was measured on one pass and is too large for two.
        """
        if self.error_std_rad is None or self.smoothing:
            return None
        std = np.tile(np.asarray(self.error_std_rad, dtype=float), (signals.n_samples, 1))
        if self.start_std_rad is not None:
            known = np.isfinite(self.start_std_rad)
            std[np.ix_(self.starting(signals), known)] = self.start_std_rad[known]
        std[~np.isfinite(signals.axis_rates_rad_s).all(axis=1)] = np.nan
        return std

    def starting(self, signals: SegmentSignals) -> BoolArray:
        """Tell which samples belong to the start-up.

        Parameters
        ----------
        signals : SegmentSignals
            As for `estimate`.

        Returns
        -------
        ndarray of bool, shape (N,)
            False at missing samples; at another rate than the network's right to a sample.
        """
        starting: BoolArray = np.array(np.isfinite(signals.axis_rates_rad_s).all(axis=1))
        there = np.flatnonzero(starting)
        taken = self.start_up.run(
            signals.axis_rates_rad_s[there],
            signals.interval_s,
            self.start_up.begin(signals.initial_angles_rad),
            self.model.coupled,
        )
        starting[there[len(taken) :]] = False
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
        model = self.model
        relative = None
        if self.axis_scaling == "own":
            # an axis that hardly moves must not be blown up into noise
            rms = np.maximum(np.sqrt(np.mean(rates_rad_s**2, axis=0)), 1e-3)
            relative = torch.from_numpy(rms / model.normalisation.rate_rms_rad_s)
        begun = self.start_up.begin(initial_angles_rad)
        first = self.start_up.run(rates_rad_s, 1.0 / model.sampling_rate_hz, begun, model.coupled)
        state, posture = self._take_over(begun if len(first) else None, relative)
        rest = self._run(rates_rad_s[len(first) :], state, posture, relative)
        angles = np.concatenate([first, rest])
        if not self.smoothing or not len(rest):
            return angles
        followed = turned_round(model, rates_rad_s[-1], angles[-1], posture)
        state = self._state(followed, relative)
        # the same kinematics with time turned round
        back = self._run(-rates_rad_s[-2::-1], state, posture, relative)
        back = np.concatenate([back[::-1], angles[-1:]])
        share = forward_share(
            len(angles),
            len(first),
            round(self.start_up.duration_s * model.sampling_rate_hz),
            len(first) > 0 and initial_angles_rad is not None,
        )
        return share * angles + (1.0 - share) * back

    def _run(
        self,
        rates_rad_s: FloatArray,
        state: torch.Tensor | None,
        posture: torch.Tensor,
        relative: torch.Tensor | None,
    ) -> FloatArray:
        rates = torch.from_numpy(np.ascontiguousarray(rates_rad_s))
        with torch.no_grad():
            angles, _ = self.model(rates, state, posture, relative)
        return wash_out(angles.numpy(), posture.numpy(), self._washout_gain, np.zeros(3))

    def _take_over(
        self, begun: FloatArray | None, relative: torch.Tensor | None
    ) -> tuple[torch.Tensor | None, torch.Tensor]:
        if begun is None:
            return None, torch.zeros(3, dtype=torch.float64)
        interval_s = 1.0 / self.model.sampling_rate_hz
        posture, *followed = map(torch.from_numpy, StartUp.hand_over(begun, interval_s))
        return self._state(followed, relative), posture

    def _state(
        self, followed: Sequence[torch.Tensor], relative: torch.Tensor | None
    ) -> torch.Tensor:
        if relative is not None:
            followed = [part / relative for part in followed]
        return self.model.initial_state(*followed)

    def _stream(self, sampling_rate_hz: float) -> Step:
        model = self.model
        if not np.isclose(sampling_rate_hz, model.sampling_rate_hz, rtol=1e-6):
            raise MethodNotApplicableError(
                f"narx: this network runs sample by sample at {model.sampling_rate_hz:g} Hz, "
                f"not at {sampling_rate_hz:g} Hz"
            )
        if self.smoothing:
            raise MethodNotApplicableError(
                "narx: smoothing needs the whole recording, use smoothing=false"
            )
        if self.axis_scaling == "own":
            raise MethodNotApplicableError(
                "narx: axis_scaling=own needs the whole recording, use axis_scaling=training"
            )
        cell, interval_s = model.cell(), 1.0 / sampling_rate_hz
        begun, starting = self.start_up.begin(None), self.start_up.duration_s > 0
        state, posture = self._take_over(None, None)
        if state is None:
            state = torch.zeros(3, model.structure.n_state, dtype=torch.float64)
        mean = np.zeros(3)

        def step(axis_rates: FloatArray, specific_force: FloatArray) -> FloatArray:
            nonlocal starting, state, posture
            if starting:
                angles = self.start_up.run(axis_rates[None], interval_s, begun, model.coupled)[0]
                if self.start_up.is_over(begun):
                    starting = False
                    state, posture = self._take_over(begun, None)
                return np.asarray(angles)
            with torch.no_grad():
                output, state = cell(torch.as_tensor(axis_rates), state, posture)
            return wash_out(output.numpy()[None], posture.numpy(), self._washout_gain, mean)[0]

        return step
