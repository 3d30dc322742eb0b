"""A network with its tracker in torch operations only, without branches.

The step of `narx.kernels.tracker` in a form that can be scripted and traced as a graph; a test
compares the two. The state is a float64 vector of the estimate, its covariance, the scalars of the
filter, the latest rates of the angles (sagittal, frontal, transverse, each with the newest first)
and the latest angles, in the order of `narx.inference.tracker.Tracking.packed`.
"""

import math

import numpy as np
import torch
from torch import Tensor, nn

from narx.inference.checkpoint import Checkpoint
from narx.inference.tracking import Tracking
from narx.kernels import tracker as kernel
from narx.kernels.limits import COS_FRONTAL_MIN
from narx.network.cell import coupled_rates
from narx.network.model import Narx


class TrackedStep(nn.Module):
    """One step of a network with its tracker.

    Parameters
    ----------
    model : Narx
        The network.
    parameters_of : ndarray, shape (PARAMETERS,)
        From `narx.inference.tracker.PostureTracker.numbers`.
    n_states : int
        `narx.kernels.tracker.GYROSCOPE_STATES` or `AIDED_STATES`.
    """

    p: Tensor
    weights: Tensor
    identity: Tensor

    def __init__(self, model: Narx, parameters_of: np.ndarray, n_states: int) -> None:
        super().__init__()
        structure = model.structure
        self.n = n_states
        self.aided = n_states == kernel.AIDED_STATES
        self.hidden = structure.hidden
        self.n_past = structure.input_lags - 1
        self.n_rates = max(self.n_past, 1)
        self.n_outputs = structure.output_lags
        # scripts can only use numbers that are attributes of the module
        self.smallest_cos_frontal = COS_FRONTAL_MIN
        self.most_bias_square = kernel.MOST_BIAS_RAD_S**2
        self.shortest_swing_s = kernel.SHORTEST_SWING_S
        self.longest_swing_s = kernel.LONGEST_SWING_S
        self.register_buffer("p", torch.from_numpy(parameters_of.copy()))
        self.register_buffer("weights", model.weights.detach().clone())
        self.register_buffer("identity", torch.eye(n_states, dtype=torch.float64))

    def _measured(
        self, x: Tensor, covariance: Tensor, direction: Tensor, variance: Tensor, residual: Tensor,
        applies: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        """Kalman update by one scalar measurement; `applies` (0 or 1) switches it."""
        spread = direction @ covariance
        gain = applies * spread / (variance + spread @ direction)
        return x + gain * residual, covariance - torch.outer(gain, spread)

    def _network(self, rates: Tensor, past: Tensor, about: Tensor) -> Tensor:
        """Angles (3,) of the network about a posture; rates (3, lags), newest first."""
        scaled = torch.cat(
            [
                rates / self.p[kernel.RATE_SCALE],
                (past - about.unsqueeze(-1)) / self.p[kernel.ANGLE_SCALE],
            ],
            dim=-1,
        )
        width = self.n_past + 1 + self.n_outputs
        split = self.hidden * width
        first = self.weights[:split].view(self.hidden, width)
        bias = self.weights[split : split + self.hidden]
        second = self.weights[split + self.hidden : split + 2 * self.hidden]
        output = torch.tanh(scaled @ first.t() + bias) @ second + self.weights[-1]
        return output * self.p[kernel.ANGLE_SCALE] + about

    def forward(self, inputs: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance by one sample.

        Parameters
        ----------
        inputs : Tensor, shape (3,), aided (6,)
            Gyroscope about the sagittal, frontal and transverse axis, rad/s; then the specific
            force, m/s^2.
        state : Tensor
            Packed state; not changed.

        Returns
        -------
        angles : Tensor, shape (3,)
            Angles, rad; NaN where the sample is missing.
        state : Tensor
            State for the next sample; for a missing sample, only its clock has advanced.
        """
        p, n = self.p, self.n
        given = inputs.to(torch.float64)
        there = (torch.abs(given) < float("inf")).all()
        given = torch.where(there, given, torch.zeros_like(given))
        scalars_at = n + n * n
        rates_at = scalars_at + kernel.SCALARS
        past_at = rates_at + 3 * self.n_rates
        x = state[:n]
        covariance = state[n:scalars_at].view(n, n)
        s = state[scalars_at:rates_at]
        rates = state[rates_at:past_at].view(3, self.n_rates)
        past = state[past_at:].view(3, self.n_outputs)

        zero, one = torch.zeros_like(s[0]), torch.ones_like(s[0])
        dt = p[kernel.INTERVAL]
        e = self.identity

        missing = s[kernel.MISSING]
        gap = (missing > 0.0).to(s.dtype)
        stays = 1.0 - gap
        doubt = p[kernel.START_VARIANCE] * torch.clamp(missing, max=1.0) ** 2
        covariance = covariance + torch.diag(doubt * e[:3].sum(0))
        rising, swing = stays * s[kernel.RISING], stays * s[kernel.SWING]
        high, low = stays * s[kernel.HIGH], stays * s[kernel.LOW]
        since, period = stays * s[kernel.SINCE], stays * s[kernel.PERIOD]
        samples, sum_turn = stays * s[kernel.SAMPLES], stays * s[kernel.SUM_TURN]
        sums = stays * s[kernel.SUM_ANGLES : kernel.SUM_ANGLES + 3]
        idle = stays * s[kernel.IDLE] + gap * p[kernel.IDLE_MOST]

        own = given[:3] - x[kernel.BIAS : kernel.BIAS + 3]
        square = own[0] ** 2 + own[1] ** 2 + own[2] ** 2
        away = given[:3] - s[kernel.MEAN_RATE : kernel.MEAN_RATE + 3]
        mean_rate = s[kernel.MEAN_RATE : kernel.MEAN_RATE + 3] + p[kernel.REST_GAIN] * away
        scatter = away[0] ** 2 + away[1] ** 2 + away[2] ** 2
        scatter = s[kernel.SCATTER] + p[kernel.REST_GAIN] * (scatter - s[kernel.SCATTER])
        known_to = torch.maximum(covariance[3, 3], covariance[4, 4])
        works = (idle < p[kernel.IDLE_MOST]) & (known_to < p[kernel.KNOWN_ENOUGH])

        tilt = past[:, 0]
        if self.n_outputs > 1:
            tilt = 2.0 * past[:, 0] - past[:, 1]
        rate = coupled_rates(own, tilt)
        cos_f = torch.clamp(torch.abs(torch.cos(tilt[1])), min=self.smallest_cos_frontal)
        turn = rate[2]
        mean_turn = s[kernel.TURN] + p[kernel.TURN_GAIN] * (turn - s[kernel.TURN])
        lean = x[kernel.LEAN] * mean_turn
        about = x[kernel.CENTRE : kernel.CENTRE + 3] + torch.stack([zero, lean, zero])
        features = torch.cat([rate.unsqueeze(-1), rates[:, : self.n_past]], dim=-1)
        carried = self._network(features, past, about)
        integrated = past[:, 0] + 0.5 * dt * (rate + rates[:, 0])
        carried = torch.where(works, carried, integrated)
        whole = (torch.abs(carried[0]) > math.pi).to(s.dtype) * torch.sign(carried[0])
        wrapped = 2.0 * math.pi * whole * e[0, :3]
        carried, past = carried - wrapped, past - wrapped.unsqueeze(-1)
        rates = torch.cat([rate.unsqueeze(-1), rates[:, : self.n_rates - 1]], dim=-1)

        known = s[kernel.KNOWN] > 0.0
        decay = torch.where(known, one, p[kernel.CENTRE_DECAY])
        noise = torch.where(known, zero, p[kernel.CENTRE_NOISE])
        leak = torch.where(works, p[kernel.LEAK] * dt, zero)
        turns = (torch.abs(mean_turn) > p[kernel.TURN_LEAST]).to(s.dtype)
        coupling = dt * mean_turn * turns
        centres = e[3:5].sum(0)
        x = torch.cat([carried, x[3:5] * decay, x[5:]])
        change = (
            -leak * e[:, :3] @ e[:3]
            + leak * e[:, :3] @ e[3:6]
            - dt * e[:, :3] @ e[6:9]
            - coupling * torch.outer(e[0], e[1])
            + coupling * torch.outer(e[1], e[0])
            + leak * mean_turn * torch.outer(e[1], e[kernel.LEAN])
        )
        if self.aided:
            force = given[3:6]
            sin_s, cos_s = torch.sin(x[0]), torch.cos(x[0])
            sin_f, cos_of_f = torch.sin(x[1]), torch.cos(x[1])
            up = sin_s * force[0] + cos_s * force[2]
            forward = cos_s * force[0] - sin_s * force[2]
            left = cos_of_f * force[1] + sin_f * up
            upright = cos_of_f * up - sin_f * force[1]
            ahead, aside = x[10], x[11]
            x = torch.cat(
                [
                    x[:10],
                    (ahead + dt * (forward + turn * aside)).reshape(1),
                    (aside + dt * (left - turn * ahead)).reshape(1),
                ]
            )
            change = (
                change
                - dt * up * torch.outer(e[10], e[0])
                + dt * turn * torch.outer(e[10], e[11])
                + dt * upright * torch.outer(e[11], e[1])
                - dt * turn * torch.outer(e[11], e[10])
            )
        factor = 1.0 + (decay - 1.0) * centres
        transition = e + change
        covariance = factor.unsqueeze(-1) * covariance * factor
        covariance = transition @ covariance @ transition.t()
        angle_noise = p[kernel.ANGLE_NOISE] + p[kernel.RATE_NOISE] * square / cos_f**2
        diagonal = (
            angle_noise * e[:3].sum(0) + noise * centres + p[kernel.BIAS_NOISE] * e[6:9].sum(0)
        )
        diagonal = diagonal + p[kernel.VELOCITY_NOISE] * e[10:].sum(0)
        covariance = covariance + torch.diag(diagonal)

        mean_square = mean_rate[0] ** 2 + mean_rate[1] ** 2 + mean_rate[2] ** 2
        rests = (scatter < p[kernel.REST_LEAST]) & (mean_square < self.most_bias_square)
        for axis in range(3):
            at = kernel.BIAS + axis
            x, covariance = self._measured(
                x, covariance, e[at], p[kernel.REST_VARIANCE], mean_rate[axis] - x[at],
                rests.to(s.dtype),
            )  # fmt: skip
        since, idle, samples = since + dt, idle + dt, samples + 1.0
        sum_turn, sums = sum_turn + turn, sums + carried
        if self.aided:
            for i in range(2):
                usual = p[kernel.SPEED] if i == 0 else zero
                x, covariance = self._measured(
                    x, covariance, e[10 + i], p[kernel.VELOCITY_VARIANCE + i], usual - x[10 + i],
                    one,
                )  # fmt: skip

        swing = (swing + dt * own[0]) / p[kernel.SWING_DECAY]
        high, low = torch.maximum(high, swing), torch.minimum(low, swing)
        span = s[kernel.SPAN] * p[kernel.SPAN_DECAY]
        least = torch.maximum(p[kernel.SPAN_SHARE] * span, p[kernel.SWING_LEAST])
        begins = (rising == 0.0) & (swing - low > least)
        rising, high = torch.where(begins, one, rising), torch.where(begins, swing, high)
        ends = (rising > 0.0) & (high - swing > least)
        span = torch.where(ends, torch.maximum(span, high - low), span)
        rising, low = torch.where(ends, zero, rising), torch.where(ends, swing, low)
        swung = ends & (since > self.shortest_swing_s) & (since < self.longest_swing_s)
        applies = swung.to(s.dtype)

        swing_turn = sum_turn / samples
        turned = applies * (torch.abs(swing_turn) > p[kernel.TURN_LEAST]).to(s.dtype)
        covariance = covariance + turned * (swing_turn * since) ** 2 * torch.outer(e[5], e[5])
        before = s[kernel.BEFORE : kernel.BEFORE + 2]
        net = (x[0] - before[0]) ** 2 + (x[1] - before[1]) ** 2
        doubt = 1.0 + net / p[kernel.RETURN_VARIANCE]
        lasted = torch.where(period > 0.0, period, one)
        irregular = ((since / lasted - 1.0) / p[kernel.PERIOD_SHARE]) ** 2
        doubt = doubt + torch.where(period > 0.0, irregular, 3.0 * one)
        share = p[kernel.EARLY] / (p[kernel.EARLY] + s[kernel.TRUST])
        odds: list[Tensor] = []
        for axis in range(3):
            direction = e[axis] - e[3 + axis]
            centre = x[3 + axis]
            if axis == 1:
                direction = direction - swing_turn * e[kernel.LEAN]
                centre = centre + x[kernel.LEAN] * swing_turn
            residual = centre - sums[axis] / samples
            variance = p[kernel.CYCLE_VARIANCE + axis] * doubt
            expected = direction @ covariance @ direction + variance
            excess = residual**2 / (p[kernel.OUTLIER] * expected)
            odd = s[kernel.ODD + axis]
            outlier = excess > 1.0
            again = outlier & (odd * residual > 0.0)
            alone = outlier & ~again
            opened = applies * again.to(s.dtype) * residual**2
            covariance = covariance + torch.diag(
                opened * (share * e[axis] + (1.0 - share) * e[3 + axis])
            )
            counts = applies * (~alone).to(s.dtype)
            x, covariance = self._measured(x, covariance, direction, variance, residual, counts)
            odds += [torch.where(swung, torch.where(alone, torch.sign(residual), zero), odd)]
        trust = s[kernel.TRUST] + applies / doubt
        idle = torch.where(swung & (odds[0] == 0.0) & (odds[1] == 0.0), zero, idle)
        period = torch.where(ends, torch.where(swung, since, zero), period)
        since, samples = torch.where(ends, zero, since), torch.where(ends, zero, samples)
        sum_turn, sums = torch.where(ends, zero, sum_turn), torch.where(ends, 0.0 * sums, sums)
        before = torch.where(ends, x[:2], before)

        correction = (x[:3] - carried).unsqueeze(-1)
        past = torch.cat([x[:3].unsqueeze(-1), past[:, : self.n_outputs - 1] + correction], dim=-1)
        scalars = torch.stack(
            [
                mean_turn, swing, high, low, span, rising, since, idle, period, trust, scatter,
                zero, samples, sums[0], sums[1], sums[2], sum_turn, before[0], before[1],
                odds[0], odds[1], odds[2], mean_rate[0], mean_rate[1], mean_rate[2],
                s[kernel.KNOWN],
            ]
        )  # fmt: skip
        after = torch.cat([x, covariance.reshape(-1), scalars, rates.reshape(-1), past.reshape(-1)])
        waited = torch.cat(
            [
                state[: scalars_at + kernel.MISSING],
                (missing + dt).reshape(1),
                state[scalars_at + kernel.MISSING + 1 :],
            ]
        )
        angles = torch.where(there, x[:3], torch.full_like(x[:3], float("nan")))
        return angles, torch.where(there, after, waited)


class ExportedTracked(nn.Module):
    """A trained network with its tracker, scriptable.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network with a tracker.

    Attributes
    ----------
    sampling_rate_hz : float
        Required sampling rate.
    state_size : int
        Length of the state.
    n_inputs : int
        3, or 6 with the accelerometer.
    """

    unknown_start: Tensor
    known_start: Tensor

    def __init__(self, checkpoint: Checkpoint) -> None:
        super().__init__()
        model, tracker = checkpoint.model, checkpoint.tracker
        assert tracker is not None
        unknown, known = (Tracking(tracker, model, pose) for pose in (None, np.zeros(3)))
        self.one_step = TrackedStep(model, tracker.numbers(model), len(unknown.x))
        self.sampling_rate_hz = float(model.sampling_rate_hz)
        self.n_inputs = 6 if tracker.aided else 3
        self.n_outputs = model.structure.output_lags
        self.register_buffer("unknown_start", torch.from_numpy(unknown.packed))
        self.register_buffer("known_start", torch.from_numpy(known.packed))
        self.state_size = len(self.unknown_start)

    @torch.jit.export
    def start(self, initial_angles: Tensor | None = None) -> Tensor:
        """Create the state before the first sample.

        Parameters
        ----------
        initial_angles : Tensor, shape (3,), optional
            Known start pose, rad; standing upright is zero. None if it is unknown.

        Returns
        -------
        Tensor, shape (state_size,)
            State for `step`.
        """
        if initial_angles is None:
            return self.unknown_start.clone()
        state = self.known_start.clone()
        pose = initial_angles.to(torch.float64)
        state[0:3] = pose
        state[state.shape[0] - 3 * self.n_outputs :] = pose.repeat_interleave(self.n_outputs)
        return state

    @torch.jit.export
    def step(self, inputs: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Advance by one sample.

        Parameters
        ----------
        inputs, state : Tensor
            As for `TrackedStep`.

        Returns
        -------
        angles, state : Tensor
            As from `TrackedStep`.
        """
        return self.one_step(inputs, state)

    def forward(self, inputs: Tensor, initial_angles: Tensor | None = None) -> Tensor:
        """Run over a whole recording.

        Parameters
        ----------
        inputs : Tensor, shape (N, n_inputs)
            As for `step`.
        initial_angles : Tensor, shape (3,), optional
            As for `start`.

        Returns
        -------
        Tensor, shape (N, 3)
            Angles, rad.
        """
        state = self.start(initial_angles)
        angles = torch.empty([inputs.shape[0], 3], dtype=torch.float64)
        for k in range(inputs.shape[0]):
            angles[k], state = self.step(inputs[k], state)
        return angles
