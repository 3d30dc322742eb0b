"""A network and its tracker in torch: their numbers, and their state as one vector.

In the order of `narx.inference.tracking.Tracking.packed`: the estimate, its covariance, the scalars
beside it, the latest rates of the angles (sagittal, frontal, transverse, newest first each) and the
latest angles; with two differences for the sake of float32. The covariance is that of the angles
relative to the posture (`narx.export.tracker_numbers.relative`): of a heading that nothing bounds
only the relative one counts, and its digits would be lost in the other's. After the scalars come
the part of the heading that is taken off in steps, the digits of the posture and of its variances
that their slow changes would lose, and whether the network gave the angles.
"""

import math

import numpy as np
import torch
from torch import Tensor, nn

from narx.export.neurons import physical_weights
from narx.export.tracker_numbers import (
    between_samples,
    changes,
    exported_numbers,
    posture_growth,
    relative,
)
from narx.inference.checkpoint import Checkpoint
from narx.inference.tracking import Tracking
from narx.kernels import leg
from narx.kernels import tracker_layout as kernel
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.kernels.short_gap import BRIDGED_RAD_S2, LONGEST_BRIDGED_S

# subtracts without rounding
_HEADING_STEP_RAD = 2.0
# tanh(z) - z = z^3 (s0 + s1 z^2 + ...), below the limit to the last digit of float64
_SERIES_LIMIT = 0.2
_SERIES = (-1 / 3, 2 / 15, -17 / 315, 62 / 2835, -1382 / 155925, 21844 / 6081075)


class TrackedState(nn.Module):
    """A network and its tracker as buffers, and the packed state of sensors.

    Parameters
    ----------
    checkpoint : Checkpoint
        What to carry; it has a tracker.

    Attributes
    ----------
    state_size : int
        Length of the state.
    """

    p: Tensor
    cos_frontal_min: Tensor
    most_bias_square: Tensor
    shortest_swing_s: Tensor
    longest_swing_s: Tensor
    pi: Tensor
    longest_gap_s: Tensor
    longest_bridged_s: Tensor
    bridged_rad_s2: Tensor
    most_doubt: Tensor
    far_rad: Tensor
    per_far_rad: Tensor
    doubt_span: Tensor
    leg_skewness: Tensor
    std_growth: Tensor
    most_growth: Tensor
    doubtful_growth: Tensor
    most_corrected: Tensor
    std_scale: Tensor
    centre_loss: Tensor
    span_loss: Tensor
    swing_loss: Tensor
    swing_gain_s: Tensor
    swing_time_s: Tensor
    first_layer: Tensor
    first_bias: Tensor
    second_layer: Tensor
    slope: Tensor
    offset_rad: Tensor
    series: Tensor
    series_limit: Tensor
    identity: Tensor
    changes: Tensor
    growth: Tensor
    postures: Tensor
    only_postures: Tensor
    tilt: Tensor
    lossy: Tensor
    lags: Tensor
    unknown_start: Tensor
    known_start: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        model, tracker = checkpoint.model, checkpoint.tracker
        assert tracker is not None
        structure, interval_s = model.structure, 1.0 / model.sampling_rate_hz
        unknown, known = (Tracking(tracker, model, pose) for pose in (None, np.zeros(3)))
        n = len(unknown.x)
        self.n = n
        self.aided = n == kernel.AIDED_STATES
        self.n_past = structure.input_lags - 1
        self.n_rates = max(self.n_past, 1)
        self.n_outputs = structure.output_lags
        # scripts take numbers from the module alone
        self.heading_step = _HEADING_STEP_RAD
        self.n_series = len(_SERIES)
        self.n_scalars = kernel.SCALARS + 6
        self.heading_at, self.lower_at = kernel.SCALARS, kernel.SCALARS + 1
        self.by_network_at = kernel.SCALARS + 5
        postures = np.stack([posture_growth(axis, n) for axis in range(3)])
        blocks = ((0, 3), (kernel.BIAS, kernel.BIAS + 3), (kernel.VELOCITY, n))
        growth = [np.diag((np.arange(n) >= begin) & (np.arange(n) < end)) for begin, end in blocks]
        # what the tilt of the posture loses, the relative angle gains
        lossy = np.zeros((n, n))
        for axis in range(2):
            lossy[axis, kernel.CENTRE + axis] = 1.0
            lossy[kernel.CENTRE + axis, kernel.CENTRE + axis] = -1.0
        starts = []
        for tracking in (unknown, known):
            tracking.covariance = relative(tracking.covariance)
            at = n + n * n + kernel.SCALARS
            starts.append(np.insert(tracking.packed, at, np.zeros(6)))
        numbers = exported_numbers(tracker, model)
        swing_kept = 1.0 / float(numbers[kernel.SWING_DECAY])
        w1, b1, w2, b2 = physical_weights(checkpoint)
        slope = w2 @ w1
        slope[structure.input_lags] -= 1.0
        # as tensors, since graph formats round plain numbers to float32
        for name, value in (
            ("p", numbers),
            ("cos_frontal_min", COS_FRONTAL_MIN),
            ("most_bias_square", kernel.MOST_BIAS_RAD_S**2),
            ("shortest_swing_s", between_samples(kernel.SHORTEST_SWING_S, interval_s, above=True)),
            ("longest_swing_s", between_samples(kernel.LONGEST_SWING_S, interval_s, above=False)),
            ("pi", math.pi),
            ("longest_gap_s", kernel.LONGEST_GAP_S),
            ("longest_bridged_s", between_samples(LONGEST_BRIDGED_S, interval_s, above=False)),
            ("bridged_rad_s2", BRIDGED_RAD_S2),
            ("most_doubt", kernel.MOST_DOUBT),
            ("far_rad", kernel.FAR_RAD),
            ("per_far_rad", 1.0 / (kernel.FAR_RAD - kernel.NEAR_RAD)),
            ("doubt_span", kernel.DOUBT_SPAN),
            ("leg_skewness", leg.LEG_SKEWNESS),
            ("std_growth", leg.STD_GROWTH),
            ("most_growth", leg.MOST_GROWTH),
            ("doubtful_growth", leg.DOUBTFUL_GROWTH),
            ("most_corrected", kernel.MOST_CORRECTED_RAD),
            ("std_scale", tracker.std_scale),
            # what is lost in a sample: a share close to one has few digits of it
            ("centre_loss", 1.0 - float(numbers[kernel.CENTRE_DECAY])),
            ("span_loss", 1.0 - float(numbers[kernel.SPAN_DECAY])),
            ("swing_loss", 1.0 - swing_kept),
            ("swing_gain_s", interval_s * swing_kept),
            ("swing_time_s", interval_s / (float(numbers[kernel.SWING_DECAY]) - 1.0)),
            ("first_layer", w1),
            ("first_bias", b1),
            ("second_layer", w2),
            ("slope", slope),
            ("offset_rad", w2 @ b1 + b2),
            ("series", _SERIES),
            ("series_limit", _SERIES_LIMIT),
            ("identity", np.eye(n)),
            ("changes", changes(n, interval_s)),
            ("growth", np.stack([growth[0], postures[:2].sum(0), *growth[1:]])),
            ("postures", postures),
            ("only_postures", [np.diag(np.eye(n)[kernel.CENTRE + axis]) for axis in range(2)]),
            ("tilt", np.diag(np.arange(n) < 2)),
            ("lossy", lossy),
            ("lags", np.arange(max(self.n_rates, self.n_outputs))),
            ("unknown_start", starts[0]),
            ("known_start", starts[1]),
        ):
            self.register_buffer(name, torch.from_numpy(np.array(value, dtype=np.float64)))
        self.state_size = len(self.unknown_start)

    def start(self, initial_angles: Tensor, known: Tensor) -> Tensor:
        """Make the state before the first sample.

        Parameters
        ----------
        initial_angles : Tensor, shape (..., 3)
            Start pose, rad; zero where it is not known.
        known : Tensor, shape (..., 1)
            1 where the start pose is known, else 0.

        Returns
        -------
        Tensor, shape (..., state_size)
            For `advance`.
        """
        state = self.unknown_start + known * (self.known_start - self.unknown_start)
        past = torch.repeat_interleave(initial_angles, self.n_outputs, dim=-1)
        between = state[..., 3 : self.state_size - 3 * self.n_outputs]
        return torch.cat([initial_angles + 0.0 * known, between, past + 0.0 * known], dim=-1)

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
        at = self.n + self.n * self.n + self.heading_at
        return torch.cat([state[..., :2], state[..., 2:3] + state[..., at : at + 1]], dim=-1)

    def lose(self, lost_s: Tensor, state: Tensor) -> Tensor:
        """Count time of which nothing is known.

        Parameters
        ----------
        lost_s : Tensor, shape (..., 1)
            s.
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., state_size)
            State.
        """
        at = self.n + self.n * self.n + kernel.MISSING
        return torch.cat(
            [state[..., :at], state[..., at : at + 1] + lost_s, state[..., at + 1 :]], dim=-1
        )

    def deviations(self, state: Tensor) -> Tensor:
        """Give the standard deviations of the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., 3)
            rad, with the growth for motion that does not resemble the swing of a leg.
        """
        scalars_at = self.n + self.n * self.n
        rates_at = scalars_at + self.n_scalars
        rates = state[..., rates_at : rates_at + 3 * self.n_rates].unflatten(-1, [3, self.n_rates])
        known = state[..., scalars_at + kernel.KNOWN : scalars_at + kernel.KNOWN + 1]
        covariance = state[..., self.n : self.n + self.n * self.n].unflatten(-1, [self.n, self.n])
        angles = covariance[..., :3, :] + covariance[..., 3:6, :]
        both = angles[..., :3] + angles[..., 3:6]
        delayed = self.p[kernel.DELAY_S] * rates[..., 0]
        variances = torch.clamp(torch.diagonal(both, dim1=-2, dim2=-1) + delayed**2, min=0.0)
        deviations = self._growth(state) * self.std_scale * torch.sqrt(variances)
        deviations = torch.sqrt(deviations**2 + self._corrected(state) ** 2)
        return torch.maximum(deviations, known * self.p[kernel.ALIGNMENT])

    def by_network(self, state: Tensor) -> Tensor:
        """Tell whether the network gave the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor of bool, shape (..., 1)
            False where the rates were integrated.
        """
        at = self.n + self.n * self.n + self.by_network_at
        return state[..., at : at + 1] > 0.0

    def doubtful(self, state: Tensor) -> Tensor:
        """Tell whether the motion does not resemble the swing of a leg, or was corrected much.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor of bool, shape (..., 1)
            True if the standard deviations are more than doubled for that, or if the recent
            corrections add more than five degrees to them.
        """
        corrected = torch.amax(self._corrected(state), dim=-1, keepdim=True)
        return (self._growth(state) > self.doubtful_growth) | (corrected > self.most_corrected)

    def _corrected(self, state: Tensor) -> Tensor:
        """What the recent corrections add to the standard deviations (..., 3), rad."""
        at = self.n + self.n * self.n + kernel.CORRECTED
        added = state[..., at : at + 2] ** 2 * self.p[kernel.PER_CORRECTED]
        return torch.cat([added, torch.zeros_like(added[..., :1])], dim=-1)

    def _growth(self, state: Tensor) -> Tensor:
        """Factor on the standard deviations (..., 1), as `narx.kernels.leg.std_growth`."""
        at = self.n + self.n * self.n + kernel.SQUARE
        square, cube = state[..., at : at + 1], state[..., at + 1 : at + 2]
        lacking = 1.0 - cube / (square * torch.sqrt(square)) / self.leg_skewness
        growth = 1.0 + self.std_growth * torch.clamp(lacking, min=0.0)
        return torch.minimum(growth, self.most_growth)
