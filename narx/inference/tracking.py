"""A running tracker (`narx.inference.tracker`): its state, and its output for every sample."""

import copy
import math
from typing import NamedTuple

import numpy as np

from narx.errors import UserError
from narx.inference.tracker import LinearRecursion, PostureTracker
from narx.kernels import leg
from narx.kernels import tracker_layout as kernel
from narx.kernels.tracker import track
from narx.network.model import Narx
from narx.types import BoolArray, FloatArray


class Tracked(NamedTuple):
    """Output of a tracker for successive samples; NaN where one is missing.

    Parameters
    ----------
    angles_rad : ndarray, shape (N, 3)
        Sagittal, frontal and transverse angle.
    std_rad : ndarray, shape (N, 3)
        Standard deviation of their error according to the model, for the swing of a leg.
    std_growth : ndarray, shape (N,)
        Factor on it for motion that does not resemble one.
    corrected_rad : ndarray, shape (N, 3)
        What the recent corrections add to it.
    by_network : ndarray of bool, shape (N,)
        Whether the network propagated the angle; False while the rates were integrated.
    """

    angles_rad: FloatArray
    std_rad: FloatArray
    std_growth: FloatArray
    corrected_rad: FloatArray
    by_network: BoolArray

    def reversed(self) -> "Tracked":
        """Return the output in reversed order.

        Returns
        -------
        Tracked
            The output, last sample first.
        """
        return Tracked(
            self.angles_rad[::-1],
            self.std_rad[::-1],
            self.std_growth[::-1],
            self.corrected_rad[::-1],
            self.by_network[::-1],
        )


class Tracking:
    """A running tracker: its state, advanced by any number of samples at a time.

    Parameters
    ----------
    tracker : PostureTracker
        Parameters.
    model : Narx or LinearRecursion
        Propagates the angles; a network must be coupled.
    initial_angles_rad : ndarray, shape (3,), optional
        Known start pose; None if it is unknown.

    Raises
    ------
    UserError
        If the network is not coupled and odd.
    """

    def __init__(
        self,
        tracker: PostureTracker,
        model: Narx | LinearRecursion,
        initial_angles_rad: FloatArray | None,
    ) -> None:
        if isinstance(model, LinearRecursion):
            self.weights, self.hidden = np.array([*model.inputs, *model.outputs]), 0
            input_lags, output_lags = len(model.inputs), len(model.outputs)
        else:
            if not (model.coupled and model.odd):
                raise UserError(
                    "a tracker needs a network with model.coupled=true and model.odd=true"
                )
            self.weights, self.hidden = model.weights.detach().numpy(), model.structure.hidden
            input_lags, output_lags = model.structure.input_lags, model.structure.output_lags
        known = initial_angles_rad is not None
        n = kernel.AIDED_STATES if tracker.aided else kernel.GYROSCOPE_STATES
        self.parameters = tracker.numbers(model)
        self.x = np.zeros(n)
        self.x[kernel.LEAN] = math.radians(tracker.lean_deg_s)
        start, posture, bias = (
            (tracker.known_start_sd_deg, tracker.known_posture_sd_deg, tracker.known_bias_sd_deg_s)
            if known
            else (tracker.start_sd_deg, tracker.posture_sd_deg, tracker.bias_sd_deg_s)
        )
        deviations = [start] * 3 + [posture] * 3 + [bias] * 3
        variances = [math.radians(sd) ** 2 for sd in [*deviations, tracker.lean_sd_deg_s]]
        if tracker.aided:
            self.x[kernel.VELOCITY] = tracker.speed_m_s
            variances += [1.0, 1.0]
        self.covariance = np.diag(variances)
        self.scalars = _new_scalars()
        self.scalars[kernel.IDLE] = tracker.idle_s
        self.scalars[kernel.KNOWN] = float(known)
        if known:
            # a sensor in a known pose is on a leg
            self.scalars[kernel.CUBE] = leg.LEG_SKEWNESS * leg.START_SQUARE**1.5
        self.rates = np.zeros((3, max(input_lags - 1, 1)))
        self.past = np.zeros((3, output_lags))
        if initial_angles_rad is not None:
            self.x[:3] = initial_angles_rad
            self.past[:] = np.asarray(initial_angles_rad)[:, None]

    @property
    def packed(self) -> FloatArray:
        """The state as one vector: estimate, covariance, scalars, past rates and angles."""
        parts = (self.x, self.covariance, self.scalars, self.rates, self.past)
        return np.concatenate([part.ravel() for part in parts])

    def follow(self, axis_rates_rad_s: FloatArray, specific_force_m_s2: FloatArray) -> Tracked:
        """Advance over the next samples.

        Parameters
        ----------
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes; NaN where missing.
        specific_force_m_s2 : ndarray, shape (N, 3)
            Accelerometer in the anatomical frame; used if aided.

        Returns
        -------
        Tracked
            Output for these samples.
        """
        rates = np.ascontiguousarray(axis_rates_rad_s, dtype=np.float64)
        force = np.ascontiguousarray(specific_force_m_s2, dtype=np.float64)
        angles, variances = np.empty_like(rates), np.empty_like(rates)
        growth, by_network = np.empty(len(rates)), np.empty(len(rates), dtype=np.bool_)
        corrected = np.empty_like(rates)
        track(
            rates, force, self.x, self.covariance, self.scalars, self.parameters, self.weights,
            self.hidden, self.rates, self.past, angles, variances, growth,
            corrected, by_network,
        )  # fmt: skip
        std = np.sqrt(np.maximum(variances, 0.0))
        return Tracked(angles, std, growth, corrected, by_network)

    def time_reversed(self) -> "Tracking":
        """Return a tracker that runs backwards in time from the current state.

        Returns
        -------
        Tracking
            Rates, and so bias, lean and velocity, have the opposite sign; angles are unchanged.
        """
        back = copy.copy(self)
        sign = np.ones(len(self.x))
        sign[kernel.BIAS :] = -1.0
        back.x, back.covariance = self.x * sign, self.covariance * np.outer(sign, sign)
        back.parameters = self.parameters.copy()
        back.parameters[kernel.SPEED] *= -1.0
        back.scalars = _new_scalars()
        back.scalars[kernel.KNOWN] = self.scalars[kernel.KNOWN]
        back.rates = -self.rates
        steps = np.arange(self.past.shape[1]) * self.parameters[kernel.INTERVAL]
        back.past = self.past[:, :1] + steps * self.rates[:, :1]
        return back


def _new_scalars() -> FloatArray:
    scalars = np.zeros(kernel.SCALARS)
    scalars[kernel.SCATTER] = 1.0
    scalars[kernel.SQUARE] = leg.START_SQUARE
    # the swing in which a recording begins is not complete, so nothing is learned from it
    scalars[kernel.SINCE] = kernel.LONGEST_SWING_S
    return scalars


def follow(tracking: Tracking, inputs: FloatArray, aided: bool, smoothing: bool) -> Tracked:
    """Run over a whole recording.

    Parameters
    ----------
    tracking : Tracking
        At the start of the recording.
    inputs : ndarray, shape (N, 3) or (N, 6)
        Rates, and the specific force if aided; NaN where missing.
    aided : bool
        Whether the accelerometer is used.
    smoothing : bool
        Also run backwards, and average both passes weighted by their variances.

    Returns
    -------
    Tracked
        Output for all samples.
    """
    rates = inputs[:, :3]
    force = inputs[:, 3:] if aided else rates
    forward = tracking.follow(rates, force)
    if not smoothing:
        return forward
    back = tracking.time_reversed().follow(-rates[::-1], force[::-1]).reversed()
    weight = forward.std_rad**-2 / (forward.std_rad**-2 + back.std_rad**-2)
    return Tracked(
        weight * forward.angles_rad + (1.0 - weight) * back.angles_rad,
        np.minimum(forward.std_rad, back.std_rad),
        # backwards in time the skewness has the opposite sign
        forward.std_growth,
        np.maximum(forward.corrected_rad, back.corrected_rad),
        forward.by_network | back.by_network,
    )
