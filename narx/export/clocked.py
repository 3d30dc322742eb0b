"""Lost samples and jitter in the recurrence of an export, handled as in the package.

`narx.kernels.clock` in torch operations: gaps of up to `narx.method.MAX_GAP_S` are filled along
straight lines once the next sample is there, in longer ones the recurrence pauses (one with a
tracker counts the time), and samples that
come at other times than the network's ticks are brought there by their intervals.

The state is the recurrence's, followed by the latest sample (3 or 6), 1 once there was one, the
time since it, the time by which it came after its tick (s), the digits that these two lose, and how
the present sample arrived (a `narx.inference.stream.Quality`). Without these digits two precisions
would, after some thousand samples with jitter, differ in whether a sample is before a tick.
"""

import torch
from torch import Tensor, nn

from narx.export.recurrence import Recurrence
from narx.export.tracked import TrackedRecurrence
from narx.export.tracker_numbers import upper_part
from narx.inference.checkpoint import Checkpoint
from narx.kernels.clock import AFTER_PAUSE, ARRIVED, DOUBTFUL, MISSING, ON_TICK, STARTING
from narx.kernels.limits import FORCE_LIMIT_M_S2
from narx.network.cell import coupled_rates


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
    interval_upper_s: Tensor
    interval_lower_s: Tensor
    max_gap_s: Tensor
    longest_pause_s: Tensor
    lost_most: Tensor
    on_tick: Tensor
    limits: Tensor
    codes: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        tracked = checkpoint.tracker is not None
        self.recurrence = (TrackedRecurrence if tracked else Recurrence)(checkpoint)
        method = checkpoint.method()
        numbers = method.clock_numbers(1.0 / checkpoint.model.sampling_rate_hz)
        self.n_inputs = 6 if method.needs_accelerometer else 3
        limits = [numbers.limit_rad_s] * 3 + [FORCE_LIMIT_M_S2] * (self.n_inputs - 3)
        # multiples of the upper part are exact in float32, too: ticks would drift otherwise
        upper_s = upper_part(numbers.interval_s)
        for name, value in (
            ("interval_s", numbers.interval_s),
            ("interval_upper_s", upper_s),
            ("interval_lower_s", numbers.interval_s - upper_s),
            ("max_gap_s", numbers.max_gap_s),
            ("longest_pause_s", numbers.longest_pause_s),
            ("lost_most", float(numbers.lost_most)),
            ("on_tick", ON_TICK),
            ("limits", limits),
            ("codes", (ARRIVED, AFTER_PAUSE, MISSING, STARTING, DOUBTFUL)),
        ):
            self.register_buffer(name, torch.tensor(value, dtype=torch.float64))
        self.state_size = self.recurrence.state_size + self.n_inputs + 5

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
        clock = torch.cat([torch.zeros_like(known)] * (self.n_inputs + 5), dim=-1)
        return torch.cat([self.recurrence.start(initial_angles, known), clock], dim=-1)

    def arrive(
        self, inputs: Tensor, interval_s: Tensor, state: Tensor
    ) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Take a sample in, before the recurrence goes on.

        Parameters
        ----------
        inputs : Tensor, shape (..., n_inputs)
            Rates, rad/s, and forces, m/s^2; missing where not finite or beyond the limits.
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
            How far two ticks are apart, in the same shares.
        lost_s : Tensor, shape (..., 1)
            Time of a gap that the recurrence is given before it advances, s.
        clock : Tensor, shape (..., n_inputs + 5)
            The clock's state afterwards.
        """
        clock, latest_at = state[..., self.recurrence.state_size :], self.n_inputs
        latest, seen = clock[..., :latest_at], clock[..., latest_at : latest_at + 1]
        before = clock[..., latest_at + 1 : latest_at + 2]
        late = clock[..., latest_at + 2 : latest_at + 3]
        timely = interval_s > 0.0
        there = (torch.abs(inputs) <= self.limits).all(-1, keepdim=True) & timely
        passed = torch.where(timely, interval_s, torch.zeros_like(interval_s))
        since = before + passed
        lower = clock[..., latest_at + 3 : latest_at + 4] + _lost_digits(before, passed, since)
        lower = torch.where(since < self.longest_pause_s, lower, torch.zeros_like(lower))
        since = torch.minimum(since, self.longest_pause_s)
        paused = (seen == 0.0) | (since > self.max_gap_s * (1.0 + self.on_tick))
        elapsed = late + since
        due = torch.floor(elapsed / self.interval_s + self.on_tick)
        whole = elapsed - due * self.interval_upper_s
        digits = (lower + _lost_digits(late, since, elapsed)) - due * self.interval_lower_s
        rest = whole + digits
        digits = digits - (rest - whole)
        on_tick = paused | (rest < self.on_tick * self.interval_s)
        rest = torch.where(on_tick, torch.zeros_like(rest), rest)
        digits = torch.where(on_tick, torch.zeros_like(digits), digits)
        due = torch.where(paused, torch.ones_like(due), due)
        share = 1.0 / torch.where(paused | ~there, torch.ones_like(since), since)
        # after a pause there is nothing to interpolate from: the sample is used unchanged
        share = torch.where(paused, torch.zeros_like(share), share)
        lost = torch.floor(since / self.interval_s + 0.5) - 1.0
        lost = torch.minimum(torch.maximum(lost, torch.zeros_like(lost)), self.lost_most)
        lost = torch.where(paused & there, lost, torch.zeros_like(lost))
        flag = there.to(state.dtype)
        arrived = torch.where(paused & (seen > 0.0), self.codes[1], self.codes[0])
        after = torch.cat(
            [
                torch.where(there, inputs, latest),
                torch.maximum(seen, flag),
                torch.where(there, torch.zeros_like(since), since),
                torch.where(there, rest, late),
                torch.where(there, digits, lower),
                torch.where(there, arrived, self.codes[2]),
            ],
            dim=-1,
        )
        return (
            flag, flag * due, rest * share, self.interval_s * share, lost * self.interval_s, after
        )  # fmt: skip

    def most(self, ticks: Tensor) -> Tensor:
        """Give the number of ticks of the sensor with most of them.

        Parameters
        ----------
        ticks : Tensor, shape (..., 1)
            From `arrive`.

        Returns
        -------
        Tensor, shape ()
            0 without a sensor.
        """
        none = torch.zeros([1], dtype=ticks.dtype, device=ticks.device)
        return torch.cat([ticks.reshape([-1]), none]).max()

    def lose(self, lost_s: Tensor, state: Tensor) -> Tensor:
        """Give the recurrence the time of a gap.

        Parameters
        ----------
        lost_s : Tensor, shape (..., 1)
            From `arrive`.
        state : Tensor, shape (..., state_size)
            State.

        Returns
        -------
        Tensor, shape (..., state_size)
            State.
        """
        size = self.recurrence.state_size
        lost = self.recurrence.lose(lost_s, state[..., :size])
        return torch.cat([lost, state[..., size:]], dim=-1)

    def tick(
        self,
        number: Tensor,
        ticks: Tensor,
        back: Tensor,
        apart: Tensor,
        inputs: Tensor,
        state: Tensor,
    ) -> Tensor:
        """Advance the recurrence by one of the due ticks.

        Parameters
        ----------
        number : Tensor, shape ()
            Number of the tick, from 1.
        ticks, back, apart : Tensor, shape (..., 1)
            From `arrive`; batch rows with fewer ticks stay as they are.
        inputs : Tensor, shape (..., n_inputs)
            The sample.
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
        latest = clock[..., : self.n_inputs]
        between = torch.where(due, inputs - before * (inputs - latest), latest)
        advanced = self.recurrence.advance(between, state[..., :size])
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
        at_tick = self.recurrence.angles(state[..., : self.recurrence.state_size])
        late = clock[..., self.n_inputs + 2 : self.n_inputs + 3]
        angles = at_tick + late * coupled_rates(clock[..., 0:3], at_tick)
        nothing = torch.full_like(angles, float("nan"))
        after = torch.cat([state[..., : self.recurrence.state_size], clock], dim=-1)
        return torch.where(there > 0.0, angles, nothing), after

    def quality(self, state: Tensor) -> Tensor:
        """Tell what the latest angles are worth.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State after a sample.

        Returns
        -------
        Tensor of int8, shape (...)
            A `narx.inference.stream.Quality`.
        """
        recurrence = state[..., : self.recurrence.state_size]
        arrived = state[..., -1:]
        doubtful = torch.where(self.recurrence.doubtful(recurrence), self.codes[4], self.codes[0])
        regular = torch.where(self.recurrence.by_network(recurrence), doubtful, self.codes[3])
        quality = torch.where(arrived == self.codes[0], regular, arrived)
        return quality.squeeze(-1).to(torch.int8)

    def standard_deviation(self, state: Tensor) -> Tensor:
        """Give the standard deviations of the latest angles.

        Parameters
        ----------
        state : Tensor, shape (..., state_size)
            State after a sample.

        Returns
        -------
        Tensor, shape (..., 3)
            rad; NaN where the sample is missing, or the network has none.
        """
        deviations = self.recurrence.deviations(state[..., : self.recurrence.state_size])
        missing = state[..., -1:] == self.codes[2]
        return torch.where(missing, torch.full_like(deviations, float("nan")), deviations)


def _lost_digits(one: Tensor, other: Tensor, total: Tensor) -> Tensor:
    """Give what the rounded sum of two numbers lacks, exactly (Knuth's two-sum)."""
    added = total - one
    return (one - (total - added)) + (other - added)
