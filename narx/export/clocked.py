"""Lost samples and jitter in the recurrence of an export, handled as in the package.

`narx.kernels.clock` in torch operations: gaps of up to `narx.method.MAX_GAP_S` are interpolated
linearly once the next sample has arrived, the recurrence pauses during longer ones, and samples
between the network's ticks are interpolated to the ticks by their intervals.

The state is that of the recurrence, followed by six numbers: the latest sample (3), 1 once there
was one, the time since it, and the time from its tick to the sample (s).
"""

import torch
from torch import Tensor, nn

from narx.export.recurrence import Recurrence
from narx.inference.checkpoint import Checkpoint
from narx.kernels.clock import ON_TICK
from narx.method import RATE_LIMIT_RAD_S, longest_gap_s
from narx.network.cell import coupled_rates

_CLOCK = 6


class ClockedRecurrence(nn.Module):
    """The recurrence with its clock, scriptable and traceable.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export.

    Attributes
    ----------
    state_size : int
        Length of the state.
    """

    interval_s: Tensor
    max_gap_s: Tensor
    on_tick: Tensor
    rate_limit_rad_s: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        self.recurrence = Recurrence(checkpoint)
        interval_s = 1.0 / checkpoint.model.sampling_rate_hz
        for name, value in (
            ("interval_s", interval_s),
            ("max_gap_s", longest_gap_s(interval_s)),
            ("on_tick", ON_TICK),
            ("rate_limit_rad_s", RATE_LIMIT_RAD_S),
        ):
            self.register_buffer(name, torch.tensor(value, dtype=torch.float64))
        self.state_size = self.recurrence.state_size + _CLOCK

    def start(self, initial_angles: Tensor, known: Tensor) -> Tensor:
        """Create the state before the first sample.

        Parameters
        ----------
        initial_angles : Tensor, shape (..., 3)
            Start pose, rad; zero if unknown.
        known : Tensor, shape (..., 1)
            1 if the start pose is known, otherwise 0.

        Returns
        -------
        Tensor, shape (..., state_size)
            State.
        """
        clock = torch.cat([torch.zeros_like(known)] * 6, dim=-1)
        return torch.cat([self.recurrence.start(initial_angles, known), clock], dim=-1)

    def arrive(
        self, axis_rates: Tensor, interval_s: Tensor, state: Tensor
    ) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Register a sample, before the recurrence advances.

        Parameters
        ----------
        axis_rates : Tensor, shape (..., 3)
            Gyroscope, rad/s; a sample is missing if not finite or beyond the limit.
        interval_s : Tensor, shape (..., 1)
            Time since the previous sample, missing or not, s.
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        there : Tensor, shape (..., 1)
            1 if the sample is not missing, otherwise 0.
        ticks : Tensor, shape (..., 1)
            Number of ticks by which the recurrence advances.
        back : Tensor, shape (..., 1)
            Time from the newest tick to the sample, as a fraction of the time since the
            previous sample.
        apart : Tensor, shape (..., 1)
            Time between two ticks, as a fraction of the same time.
        clock : Tensor, shape (..., 6)
            The clock's state afterwards.
        """
        clock = state[..., self.recurrence.state_size :]
        latest, seen = clock[..., 0:3], clock[..., 3:4]
        timely = interval_s > 0.0
        there = (torch.abs(axis_rates) <= self.rate_limit_rad_s).all(-1, keepdim=True) & timely
        passed = torch.where(timely, interval_s, torch.zeros_like(interval_s))
        since = torch.minimum(clock[..., 4:5] + passed, 2.0 * self.max_gap_s)
        paused = (seen == 0.0) | (since > self.max_gap_s * (1.0 + self.on_tick))
        elapsed = clock[..., 5:6] + since
        due = torch.floor(elapsed / self.interval_s + self.on_tick)
        rest = elapsed - due * self.interval_s
        rest = torch.where(rest < self.on_tick * self.interval_s, torch.zeros_like(rest), rest)
        rest = torch.where(paused, torch.zeros_like(rest), rest)
        due = torch.where(paused, torch.ones_like(due), due)
        share = 1.0 / torch.where(paused | ~there, torch.ones_like(since), since)
        # after a pause there is nothing to interpolate from: the sample is used unchanged
        share = torch.where(paused, torch.zeros_like(share), share)
        flag = there.to(state.dtype)
        after = torch.cat(
            [
                torch.where(there, axis_rates, latest),
                torch.maximum(seen, flag),
                torch.where(there, torch.zeros_like(since), since),
                torch.where(there, rest, clock[..., 5:6]),
            ],
            dim=-1,
        )
        return flag, flag * due, rest * share, self.interval_s * share, after

    def tick(
        self,
        number: Tensor,
        ticks: Tensor,
        back: Tensor,
        apart: Tensor,
        axis_rates: Tensor,
        state: Tensor,
    ) -> Tensor:
        """Advance the recurrence by one of the due ticks.

        Parameters
        ----------
        number : Tensor, shape ()
            Number of the tick, from 1.
        ticks, back, apart : Tensor, shape (..., 1)
            From `arrive`; batch rows with fewer ticks are unchanged.
        axis_rates : Tensor, shape (..., 3)
            The sample, rad/s.
        state : Tensor, shape (..., state_size)
            State, with its clock as before the sample.

        Returns
        -------
        Tensor, shape (..., state_size)
            State.
        """
        size = self.recurrence.state_size
        clock = state[..., size:]
        due = number <= ticks
        before = back + (ticks - number) * apart
        latest = clock[..., 0:3]
        rates = torch.where(due, axis_rates - before * (axis_rates - latest), latest)
        advanced = self.recurrence.advance(rates, state[..., :size])
        return torch.cat([torch.where(due, advanced, state[..., :size]), clock], dim=-1)

    def depart(self, there: Tensor, clock: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Compute the angles at the sample, after the recurrence has advanced.

        Parameters
        ----------
        there, clock : Tensor
            From `arrive`.
        state : Tensor, shape (..., state_size)
            State from the last `tick`.

        Returns
        -------
        angles : Tensor, shape (..., 3)
            Angles, rad; NaN where the sample is missing.
        state : Tensor, shape (..., state_size)
            State for the next sample.
        """
        at_tick = state[..., 0:3]
        angles = at_tick + clock[..., 5:6] * coupled_rates(clock[..., 0:3], at_tick)
        nothing = torch.full_like(angles, float("nan"))
        after = torch.cat([state[..., : self.recurrence.state_size], clock], dim=-1)
        return torch.where(there > 0.0, angles, nothing), after
