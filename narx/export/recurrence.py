"""The whole method in torch operations alone, so that it runs where this package is not.

Start-up, hand-over and network of `narx.inference.narx_method.NarxMethod`, at the network's own
sampling rate, as one step on one packed state. Every export is made from this module or compared
with it.

The state is a float64 vector:

======== ==================================================================
indices  content
======== ==================================================================
0-2      angles, rad
3-5      latest rates of the angles, rad/s
6-8      weighted sum of angles, from which the posture comes, rad
9        sum of those weights
10       time since the start, s
11       time in movement, s: the network takes over once it is long enough
12       mean square of the rates over the latest second, rad^2/s^2
13       1 where the start pose is known, else 0
14-16    posture: angle about which the network swings, rad
17-19    slow mean of the network's deviation from it, which is taken off, rad
20-      the network's past inputs and outputs, normalised, axis by axis
======== ==================================================================

The first 14 are those of `narx.inference.start_up.StartUp`, and stay as they are once the network
works. The network's part follows along during the start-up, so handing over is nothing but going on
with the other equations.
"""

import math

import torch
from torch import Tensor, nn

from narx.errors import MethodNotApplicableError
from narx.inference.checkpoint import Checkpoint
from narx.inference.washout import washout_gain
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S, MOVING_S, STATE_SIZE
from narx.network.cell import coupled_rates

_NETWORK = STATE_SIZE + 6


class ExportedNarx(nn.Module):
    """A trained network with its start-up, scriptable.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry.

    Attributes
    ----------
    sampling_rate_hz : float
        Rate at which samples must come.
    start_up_s : float
        Time in movement before the network takes over, s.
    state_size : int
        Length of the state.

    Raises
    ------
    MethodNotApplicableError
        If the axes are scaled by their own amplitude, which needs the whole recording.
    """

    interval_s: Tensor
    leak_rad_s: Tensor
    settling_gain: Tensor
    settling_s: Tensor
    duration_s: Tensor
    averaged_from_s: Tensor
    averaging_s: Tensor
    movement_time_constant_s: Tensor
    movement_square: Tensor
    pi: Tensor
    washout_gain: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        if checkpoint.axis_scaling != "training":
            raise MethodNotApplicableError(
                f"export: the network's axis_scaling is '{checkpoint.axis_scaling}', which needs "
                "the whole recording; only axis_scaling=training runs sample by sample"
            )
        model, start_up = checkpoint.model, checkpoint.start_up
        self.cell = model.cell()
        self.coupled = model.coupled
        self.sampling_rate_hz = float(model.sampling_rate_hz)
        self.n_inputs = 3
        self.start_up_s = float(start_up.duration_s)
        # as float64 tensors, since graph formats may round plain numbers to float32
        for name, value in (
            ("interval_s", 1.0 / self.sampling_rate_hz),
            ("leak_rad_s", start_up.leak_rad_s),
            ("settling_gain", start_up.settling_gain),
            ("settling_s", start_up.settling_s),
            ("duration_s", start_up.duration_s),
            ("averaged_from_s", start_up.averaged_from_s),
            ("averaging_s", start_up.averaging_s),
            ("movement_time_constant_s", MOVEMENT_TIME_CONSTANT_S),
            ("movement_square", MOVEMENT_RAD_S**2),
            ("pi", math.pi),
            ("washout_gain", washout_gain(checkpoint.washout_s, 1.0 / self.sampling_rate_hz)),
        ):
            self.register_buffer(name, torch.tensor(value, dtype=torch.float64))
        self.input_lags = model.structure.input_lags
        self.output_lags = model.structure.output_lags
        self.state_size = _NETWORK + 3 * model.structure.n_state

    @torch.jit.export
    def start(self, initial_angles: Tensor | None = None) -> Tensor:
        """Make the state before the first sample.

        Parameters
        ----------
        initial_angles : Tensor, shape (3,), optional
            Known start pose, rad; standing upright is zero. None where it is unknown. Without a
            start-up the network starts from zero either way, as in the package.

        Returns
        -------
        Tensor, shape (state_size,)
            For `step`.
        """
        state = torch.zeros(self.state_size, dtype=torch.float64)
        if initial_angles is not None:
            state[0:3] = initial_angles.to(torch.float64)
            state[13] = 1.0
        return state

    @torch.jit.export
    def step(self, axis_rates: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance by one sample.

        Parameters
        ----------
        axis_rates : Tensor, shape (3,)
            Gyroscope about the sagittal, frontal and transverse axis without bias, rad/s.
        state : Tensor, shape (state_size,)
            From `start` or the sample before; not changed.

        Returns
        -------
        angles : Tensor, shape (3,)
            Sagittal, frontal and transverse angle, rad; NaN where the sample is missing.
        state : Tensor, shape (state_size,)
            For the next sample; the same where the sample is missing.
        """
        rates = axis_rates.to(torch.float64)
        if not bool(torch.isfinite(rates).all()):
            return torch.full_like(rates, float("nan")), state
        if bool(state[11] < self.duration_s):
            return self.start_up_step(rates, state)
        return self.network_step(rates, state)

    def forward(self, axis_rates: Tensor, initial_angles: Tensor | None = None) -> Tensor:
        """Run over a whole recording.

        Parameters
        ----------
        axis_rates : Tensor, shape (N, 3)
            As for `step`.
        initial_angles : Tensor, shape (3,), optional
            As for `start`.

        Returns
        -------
        Tensor, shape (N, 3)
            Angles, rad.
        """
        state = self.start(initial_angles)
        angles = torch.empty(axis_rates.shape, dtype=torch.float64)
        for k in range(axis_rates.shape[0]):
            angles[k], state = self.step(axis_rates[k], state)
        return angles

    @torch.jit.export
    def start_up_step(self, axis_rates: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance the start-up, without looking whether it is over or the sample there.

        Parameters
        ----------
        axis_rates, state : Tensor
            As for `step`.

        Returns
        -------
        angles, state : Tensor
            As from `step`.
        """
        latest, latest_rates, known = state[0:3], state[3:6], state[13:14]
        rates = axis_rates
        if self.coupled:
            rates = coupled_rates(axis_rates, latest + self.interval_s * latest_rates)
        time = state[10:11] + self.interval_s
        # summed in the package's order: movement counts or not by the last digit
        square = axis_rates[0:1] ** 2 + axis_rates[1:2] ** 2 + axis_rates[2:3] ** 2
        change = (square - state[12:13]) * self.interval_s
        mean_square = state[12:13] + change / (self.movement_time_constant_s + self.interval_s)
        in_movement = (mean_square > self.movement_square).to(state.dtype)
        moving = state[11:12] + in_movement * self.interval_s
        leak = self.leak_rad_s + self.settling_gain / (time + self.settling_s)
        damping = 1.0 + (1.0 - known) * self.interval_s * leak
        angles = (latest + 0.5 * self.interval_s * (rates + latest_rates)) / damping
        into = moving - self.averaged_from_s
        averaged = (into > 0.0) & (into < self.averaging_s)
        hann = torch.sin(self.pi * into / self.averaging_s) ** 2
        weight = torch.where(averaged, hann, torch.zeros_like(hann))
        posture_sum = state[6:9] + weight * angles
        posture_weight = state[9:10] + weight
        nonzero = torch.where(posture_weight > 0.0, posture_weight, torch.ones_like(posture_weight))
        posture = known * posture_sum / nonzero
        deviation = angles - posture
        earlier = deviation - self.interval_s * rates
        network = [(rates - self.cell.rate_offset) / self.cell.rate_scale] * (self.input_lags - 1)
        network += [(deviation - self.cell.angle_offset) / self.cell.angle_scale]
        network += [(earlier - self.cell.angle_offset) / self.cell.angle_scale] * (
            self.output_lags - 1
        )
        new_state = torch.cat(
            [
                angles, rates, posture_sum, posture_weight, time, moving, mean_square, known,
                posture, state[17:20], torch.stack(network, dim=-1).reshape(-1),
            ]
        )  # fmt: skip
        return angles, new_state

    @torch.jit.export
    def network_step(self, axis_rates: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance the network, without looking whether the start-up is over or the sample there.

        Parameters
        ----------
        axis_rates, state : Tensor
            As for `step`.

        Returns
        -------
        angles, state : Tensor
            As from `step`.
        """
        posture, mean = state[14:17], state[17:20]
        angles, network = self.cell(axis_rates, state[20:].reshape(3, -1), posture)
        mean = mean + self.washout_gain * (angles - posture - mean)
        return angles - mean, torch.cat([state[:17], mean, network.reshape(-1)])


class StepGraph(nn.Module):
    """The same step without a branch, for formats that hold a graph of operations.

    Parameters
    ----------
    narx : ExportedNarx
        What to carry.
    """

    def __init__(self, narx: ExportedNarx) -> None:
        super().__init__()
        self.narx = narx

    def forward(self, axis_rates: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance by one sample: both sets of equations, of which one is chosen.

        Parameters
        ----------
        axis_rates, state : Tensor
            As for `ExportedNarx.step`.

        Returns
        -------
        angles, state : Tensor
            As from `ExportedNarx.step`.
        """
        # a missing sample must not reach either set, or NaN would get into the state
        there = (torch.abs(axis_rates) < float("inf")).all()
        rates = torch.where(there, axis_rates, torch.zeros_like(axis_rates))
        first_angles, first_state = self.narx.start_up_step(rates, state)
        later_angles, later_state = self.narx.network_step(rates, state)
        starting = state[MOVING_S] < self.narx.duration_s
        angles = torch.where(starting, first_angles, later_angles)
        new_state = torch.where(starting, first_state, later_state)
        nothing = torch.full_like(angles, float("nan"))
        return torch.where(there, angles, nothing), torch.where(there, new_state, state)


def description(narx: ExportedNarx) -> dict[str, object]:
    """Say what a user of the bare step must know.

    Parameters
    ----------
    narx : ExportedNarx
        What is carried.

    Returns
    -------
    dict
        Plain numbers and strings: rate, units and the state to start from.
    """
    return {
        "sampling_rate_hz": narx.sampling_rate_hz,
        "axes": "sagittal, frontal, transverse",
        "axis_rates_unit": "rad/s",
        "angles_unit": "rad",
        "start_state": narx.start().tolist(),
        "known_start": "put the three start angles into state[0:3] and 1 into state[13]",
    }
