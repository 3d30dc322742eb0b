"""The method's equations in torch operations only, so that they run without this package.

Start-up, hand-over, network and washout of `narx.inference.recursion.NarxRecursion`, as one step of
a packed state, for any batch of sensors. Every export except C is built from this module, and all
are compared with the package (`narx.export.verification`). Lost samples and timing are handled in
`narx.export.clocked`.

The state is a vector:

======== ==================================================================
indices  content
======== ==================================================================
0-2      angles, rad
3-5      latest rates of the angles in the start-up, rad/s
6-8      weighted sum of angles, for the posture, rad
9        sum of those weights
10       samples since the start
11       samples in movement: the network takes over once there are enough
12       mean square of the rates over the latest second, rad^2/s^2
13       1 if the start pose is known, otherwise 0
14-16    posture: angle about which the network swings, rad
17-19    slow mean of the network's deviation from it, which is subtracted, rad
20       1 if the network gave the angles, 0 if the start-up did
21-      the network's past inputs and outputs, normalised, axis by axis
======== ==================================================================

Indices 3 to 16 no longer change once the network has taken over. The network's part is updated
during the start-up as well, so the hand-over only switches the equations. Samples are counted,
because an accumulated time loses digits in float32.
"""

import math

import numpy as np
import torch
from torch import Tensor, nn

from narx.errors import MethodNotApplicableError
from narx.inference.checkpoint import Checkpoint
from narx.inference.start_up import StartUp
from narx.inference.washout import washout_gain
from narx.kernels.start_up import MOVEMENT_RAD_S, MOVEMENT_TIME_CONSTANT_S, STATE_SIZE
from narx.network.cell import coupled_rates
from narx.types import FloatArray

_NETWORK = STATE_SIZE + 7


def samples_in_movement(start_up: StartUp, interval_s: float) -> int:
    """Count the samples in movement after which the network takes over.

    Parameters
    ----------
    start_up : StartUp
        Settings of the start-up.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    int
        Counted in the package's arithmetic, so that rounding in float32 cannot shift the hand-over.
    """
    enough = math.ceil(max(start_up.duration_s, 0.0) / interval_s) + 2
    moving_s = np.cumsum([0.0] + [interval_s] * enough)
    return int(np.argmax(moving_s >= start_up.duration_s))


def refuse_own_scaling(checkpoint: Checkpoint) -> None:
    """Refuse a network that needs the whole recording before its first sample.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.

    Raises
    ------
    MethodNotApplicableError
        If its axes are scaled by their own amplitude.
    """
    if checkpoint.axis_scaling != "training":
        raise MethodNotApplicableError(
            f"export: the network's axis_scaling is '{checkpoint.axis_scaling}', which needs "
            "the whole recording; only axis_scaling=training runs sample by sample"
        )


def known_stds_rad(checkpoint: Checkpoint) -> FloatArray:
    """Return the standard deviations of a network without a tracker.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.

    Returns
    -------
    ndarray, shape (2, 3)
        After and during the start-up, rad; NaN where not known.
    """
    stds_rad = checkpoint.method().stds_rad()
    return np.full((2, 3), np.nan) if stds_rad is None else stds_rad


class Recurrence(nn.Module):
    """A trained network with its start-up, scriptable and traceable, without a branch.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.

    Attributes
    ----------
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
    moving_samples: Tensor
    averaged_from_s: Tensor
    averaging_s: Tensor
    movement_gain: Tensor
    movement_square: Tensor
    pi: Tensor
    washout_gain: Tensor
    stds_rad: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        refuse_own_scaling(checkpoint)
        model, start_up = checkpoint.model, checkpoint.start_up
        interval_s = 1.0 / model.sampling_rate_hz
        self.cell = model.cell()
        self.coupled = model.coupled
        # tensors, since graph formats round plain numbers to float32
        for name, value in (
            ("interval_s", interval_s),
            ("leak_rad_s", start_up.leak_rad_s),
            ("settling_gain", start_up.settling_gain),
            ("settling_s", start_up.settling_s),
            ("moving_samples", samples_in_movement(start_up, interval_s)),
            ("averaged_from_s", start_up.averaged_from_s),
            ("averaging_s", start_up.averaging_s),
            ("movement_gain", interval_s / (MOVEMENT_TIME_CONSTANT_S + interval_s)),
            ("movement_square", MOVEMENT_RAD_S**2),
            ("pi", math.pi),
            ("washout_gain", washout_gain(checkpoint.washout_s, interval_s)),
            ("stds_rad", known_stds_rad(checkpoint)),
        ):
            self.register_buffer(name, torch.tensor(value, dtype=torch.float64))
        self.input_lags = model.structure.input_lags
        self.output_lags = model.structure.output_lags
        self.state_size = _NETWORK + 3 * model.structure.n_state

    def rates_of_angles(self, axis_rates: Tensor, angles: Tensor) -> Tensor:
        """Convert the gyroscope's rates to those of the angles if the network is coupled.

        Parameters
        ----------
        axis_rates : Tensor, shape (..., 3)
            Gyroscope about the clinical axes, rad/s.
        angles : Tensor, shape (..., 3)
            Angles at that time, rad.

        Returns
        -------
        Tensor, shape (..., 3)
            Rates, rad/s.
        """
        if self.coupled:
            return coupled_rates(axis_rates, angles)
        return axis_rates

    def start(self, initial_angles: Tensor, known: Tensor) -> Tensor:
        """Create the state before the first sample.

        Parameters
        ----------
        initial_angles : Tensor, shape (..., 3)
            Start pose, rad; zero if unknown. Without a start-up, the network starts from zero in
            both cases, as in the package.
        known : Tensor, shape (..., 1)
            1 if the start pose is known, otherwise 0.

        Returns
        -------
        Tensor, shape (..., state_size)
            State for `advance`.
        """
        zero = [torch.zeros_like(known)]
        return torch.cat([initial_angles] + zero * 10 + [known] + zero * (self.state_size - 14), -1)

    def angles(self, state: Tensor) -> Tensor:
        """Give the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., 3)
            rad.
        """
        return state[..., 0:3]

    def deviations(self, state: Tensor) -> Tensor:
        """Give the standard deviations of the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., 3)
            rad; NaN where the checkpoint has none.
        """
        return torch.where(self.by_network(state), self.stds_rad[0], self.stds_rad[1])

    def by_network(self, state: Tensor) -> Tensor:
        """Tell whether the network gave the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor of bool, shape (..., 1)
            False during the start-up.
        """
        return state[..., 20:21] > 0.0

    def doubtful(self, state: Tensor) -> Tensor:
        """Tell whether the motion is doubtful, which only a tracker recognises.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor of bool, shape (..., 1)
            False.
        """
        return torch.zeros_like(state[..., 0:1]) > 0.0

    def lose(self, lost_s: Tensor, state: Tensor) -> Tensor:
        """Take no notice of time of which nothing is known: the recurrence pauses.

        Parameters
        ----------
        lost_s : Tensor, shape (..., 1)
            s.
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., state_size)
            The same.
        """
        return state

    def advance(self, axis_rates: Tensor, state: Tensor) -> Tensor:
        """Advance by one sampling interval.

        Parameters
        ----------
        axis_rates : Tensor, shape (..., 3)
            Gyroscope about the sagittal, frontal and transverse axis without bias, rad/s, finite.
        state : Tensor, shape (..., state_size)
            From `start` or the previous sample; not changed.

        Returns
        -------
        Tensor, shape (..., state_size)
            State for the next sample; its first three elements are the angles.
        """
        starting = state[..., 11:12] < self.moving_samples
        if torch.jit.is_scripting():  # a shortcut that a graph without branches cannot take
            if bool(starting.all()):
                return self._start_up_step(axis_rates, state)
            if not bool(starting.any()):
                return self._network_step(axis_rates, state)
        return torch.where(
            starting, self._start_up_step(axis_rates, state), self._network_step(axis_rates, state)
        )

    def _start_up_step(self, axis_rates: Tensor, state: Tensor) -> Tensor:
        latest, latest_rates, known = state[..., 0:3], state[..., 3:6], state[..., 13:14]
        rates = self.rates_of_angles(axis_rates, latest + self.interval_s * latest_rates)
        samples = state[..., 10:11] + 1.0
        # summed in the package's order: the last digit can decide whether a sample is in movement
        square = axis_rates[..., 0:1] ** 2 + axis_rates[..., 1:2] ** 2 + axis_rates[..., 2:3] ** 2
        mean_square = state[..., 12:13] + (square - state[..., 12:13]) * self.movement_gain
        in_movement = (mean_square > self.movement_square).to(state.dtype)
        moving = state[..., 11:12] + in_movement
        leak = self.leak_rad_s + self.settling_gain / (samples * self.interval_s + self.settling_s)
        damping = 1.0 + (1.0 - known) * self.interval_s * leak
        angles = (latest + 0.5 * self.interval_s * (rates + latest_rates)) / damping
        into = moving * self.interval_s - self.averaged_from_s
        averaged = (into > 0.0) & (into < self.averaging_s)
        hann = torch.sin(self.pi * into / self.averaging_s) ** 2
        weight = torch.where(averaged, hann, torch.zeros_like(hann))
        posture_sum = state[..., 6:9] + weight * angles
        posture_weight = state[..., 9:10] + weight
        nonzero = torch.where(posture_weight > 0.0, posture_weight, torch.ones_like(posture_weight))
        posture = known * posture_sum / nonzero
        deviation = angles - posture
        earlier = deviation - self.interval_s * rates
        cell = self.cell
        network = [(rates - cell.rate_offset) / cell.rate_scale] * (self.input_lags - 1)
        network += [(deviation - cell.angle_offset) / cell.angle_scale]
        network += [(earlier - cell.angle_offset) / cell.angle_scale] * (self.output_lags - 1)
        return torch.cat(
            [
                angles, rates, posture_sum, posture_weight, samples, moving, mean_square, known,
                posture, state[..., 17:20], torch.zeros_like(known),
                torch.stack(network, dim=-1).flatten(-2),
            ],
            dim=-1,
        )  # fmt: skip

    def _network_step(self, axis_rates: Tensor, state: Tensor) -> Tensor:
        posture, mean = state[..., 14:17], state[..., 17:20]
        past = state[..., 21:].unflatten(-1, [3, -1])
        angles, network = self.cell(axis_rates, past, posture)
        mean = mean + self.washout_gain * (angles - posture - mean)
        by_network = torch.ones_like(state[..., 20:21])
        return torch.cat(
            [angles - mean, state[..., 3:17], mean, by_network, network.flatten(-2)], dim=-1
        )
