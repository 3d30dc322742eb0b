"""A network and its tracker in torch: their numbers, and their state as one vector.

In the order of `narx.inference.tracking.Tracking.packed`: the estimate, its covariance, the scalars
beside it, the latest rates of the angles (sagittal, frontal, transverse, newest first each) and the
latest angles; with two differences for the sake of float32. The covariance is that of the angles
relative to the posture (`narx.export.tracker_numbers.relative`): of a heading that nothing bounds
only the relative one counts, and its digits would be lost in the other's. After the scalars come
the part of the heading that is taken off in steps, and the digits of the posture that its slow
decay would lose.
"""

import math

import numpy as np
import torch
from torch import Tensor, nn

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
    weights: Tensor
    identity: Tensor
    changes: Tensor
    growth: Tensor
    postures: Tensor
    lossy: Tensor
    limits: Tensor
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
        self.hidden = structure.hidden
        self.n_past = structure.input_lags - 1
        self.n_rates = max(self.n_past, 1)
        self.n_outputs = structure.output_lags
        # scripts take numbers from the module alone
        self.heading_step = _HEADING_STEP_RAD
        self.n_scalars = kernel.SCALARS + 3
        self.heading_at, self.lower_at = kernel.SCALARS, kernel.SCALARS + 1
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
            starts.append(np.insert(tracking.packed, at, np.zeros(3)))
        # as tensors, since graph formats round plain numbers to float32
        limits = (
            COS_FRONTAL_MIN,
            kernel.MOST_BIAS_RAD_S**2,
            between_samples(kernel.SHORTEST_SWING_S, interval_s, above=True),
            between_samples(kernel.LONGEST_SWING_S, interval_s, above=False),
            math.pi,
            kernel.LONGEST_GAP_S,
            1.0 - float(tracker.numbers(model)[kernel.CENTRE_DECAY]),
            between_samples(LONGEST_BRIDGED_S, interval_s, above=False),
            BRIDGED_RAD_S2,
            kernel.MOST_DOUBT,
            leg.LEG_SKEWNESS,
            leg.STD_GROWTH,
            leg.MOST_GROWTH,
            kernel.FAR_RAD,
        )
        for name, value in (
            ("p", exported_numbers(tracker, model)),
            ("identity", np.eye(n)),
            ("changes", changes(n, interval_s)),
            ("growth", np.stack([growth[0], postures[:2].sum(0), *growth[1:]])),
            ("postures", postures),
            ("lossy", lossy),
            ("limits", np.array(limits)),
            ("lags", np.arange(max(self.n_rates, self.n_outputs))),
            ("unknown_start", starts[0]),
            ("known_start", starts[1]),
        ):
            self.register_buffer(name, torch.from_numpy(np.array(value, dtype=np.float64)))
        self.register_buffer("weights", model.weights.detach().clone())
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

    @torch.jit.export
    def variances(self, state: Tensor) -> Tensor:
        """Give the variances of the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., 3)
            rad^2, before the checkpoint's `std_scale`, with the growth for motion that does not
            resemble the swing of a leg.
        """
        covariance = state[..., self.n : self.n + self.n * self.n].unflatten(-1, [self.n, self.n])
        angles = covariance[..., :3, :] + covariance[..., 3:6, :]
        both = angles[..., :3] + angles[..., 3:6]
        at = self.n + self.n * self.n + kernel.SQUARE
        square, cube = state[..., at : at + 1], state[..., at + 1 : at + 2]
        lacking = 1.0 - cube / (square * torch.sqrt(square)) / self.limits[10]
        growth = 1.0 + self.limits[11] * torch.clamp(lacking, min=0.0)
        growth = torch.minimum(growth, self.limits[12])
        return growth**2 * torch.diagonal(both, dim1=-2, dim2=-1)
