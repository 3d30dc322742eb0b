"""A network with its tracker in torch operations only, without branches.

The step of `narx.kernels.tracker`, of which this is the other form: scriptable, traceable as a
graph, for any batch of sensors, and compared with it by a test. The state is that of
`narx.export.tracked_state`.
"""

import torch
from torch import Tensor

from narx.export.tracked_state import TrackedState
from narx.kernels import tracker_layout as kernel
from narx.network.cell import coupled_rates


class TrackedRecurrence(TrackedState):
    """A network with its tracker, a step of a packed state at a time.

    Parameters
    ----------
    checkpoint : Checkpoint
        Network to export, with a tracker.
    """

    def _measured(
        self, x: Tensor, covariance: Tensor, at: int, variance: Tensor, residual: Tensor,
        applies: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        """Kalman update by a measurement of one state."""
        spread = covariance[..., at]
        return self._updated(x, covariance, spread, spread[..., at] + variance, residual, applies)

    def _updated(
        self, x: Tensor, covariance: Tensor, spread: Tensor, total: Tensor, residual: Tensor,
        applies: Tensor,
    ) -> tuple[Tensor, Tensor]:  # fmt: skip
        """Kalman update by one number (...), where it applies (0 or 1); spread (..., n)."""
        gain = (applies / total).unsqueeze(-1) * spread
        moved = covariance - gain.unsqueeze(-1) * spread.unsqueeze(-2)
        absolute = torch.cat([gain[..., :3] + gain[..., 3:6], gain[..., 3:]], dim=-1)
        return x + absolute * residual.unsqueeze(-1), moved

    def _network(self, rates: Tensor, past: Tensor, about: Tensor) -> Tensor:
        """Angles (..., 3) of the network about a posture; rates (..., 3, lags), newest first.

        Computed as a change of the latest angles: the network's weight of these is close to one,
        and its rounding, a share of the leak, would add up in the heading.
        """
        features = torch.cat([rates, past - about.unsqueeze(-1)], dim=-1)
        sums = features @ self.first_layer.t() + self.first_bias
        square = sums * sums
        series = torch.zeros_like(square)
        for k in range(self.n_series - 1, -1, -1):
            series = self.series[k] + square * series
        # what each neuron's tanh lacks of its argument
        small = torch.abs(sums) < self.series_limit
        curved = torch.where(small, sums * square * series, torch.tanh(sums) - sums)
        change = features @ self.slope + self.offset_rad + curved @ self.second_layer
        return past[..., 0] + change

    def advance(self, inputs: Tensor, state: Tensor) -> Tensor:
        """Advance by one sampling interval.

        Parameters
        ----------
        inputs : Tensor, shape (..., 3), aided (..., 6)
            Gyroscope about the sagittal, frontal and transverse axis, rad/s; then the specific
            force, m/s^2; finite.
        state : Tensor, shape (..., state_size)
            From `start` or the sample before; not changed.

        Returns
        -------
        Tensor, shape (..., state_size)
            For the next sample.
        """
        p, n = self.p, self.n
        scalars_at = n + n * n
        rates_at = scalars_at + self.n_scalars
        past_at = rates_at + 3 * self.n_rates
        x = state[..., :n]
        covariance = state[..., n:scalars_at].unflatten(-1, [n, n])
        s = state[..., scalars_at:rates_at]
        rates = state[..., rates_at:past_at].unflatten(-1, [3, self.n_rates])
        past = state[..., past_at:].unflatten(-1, [3, self.n_outputs])
        zero, one = torch.zeros_like(s[..., 0]), torch.ones_like(s[..., 0])
        dt, e = p[kernel.INTERVAL], self.identity

        own = inputs[..., :3] - x[..., kernel.BIAS : kernel.BIAS + 3]
        missing = s[..., kernel.MISSING]
        bridged = (missing > 0.0) & (missing < self.longest_bridged_s)
        gap = ((missing > 0.0) & ~bridged).to(s.dtype)
        stays = 1.0 - gap
        doubt = gap * p[kernel.START_VARIANCE] * torch.minimum(missing, self.longest_gap_s) ** 2
        covariance = covariance + doubt.unsqueeze(-1).unsqueeze(-1) * self.growth[0]
        rising, swing = stays * s[..., kernel.RISING], stays * s[..., kernel.SWING]
        high, low = stays * s[..., kernel.HIGH], stays * s[..., kernel.LOW]
        since, period = stays * s[..., kernel.SINCE], stays * s[..., kernel.PERIOD]
        samples, sum_turn = stays * s[..., kernel.SAMPLES], stays * s[..., kernel.SUM_TURN]
        sums = stays.unsqueeze(-1) * s[..., kernel.SUM_ANGLES : kernel.SUM_ANGLES + 3]
        idle = stays * s[..., kernel.IDLE] + gap * p[kernel.IDLE_MOST]

        # over a short gap the rates are interpolated linearly, up to the sample before this one
        short = torch.where(bridged, missing, zero)
        whole, lost = short + dt, short / dt
        last, begin = rates[..., 0], past[..., 0]
        slope = (coupled_rates(own, begin) - last) / whole.unsqueeze(-1)
        half = 0.5 * whole.unsqueeze(-1)
        thirds = ((whole + short) / 6.0).unsqueeze(-1)
        sums = sums + lost.unsqueeze(-1) * (begin + half * (last + slope * thirds))
        sum_turn = sum_turn + lost * (last + half * slope)[..., 2]
        since, idle, samples = since + short, idle + short, samples + lost
        since_lost = (short.unsqueeze(-1) - dt * self.lags[: self.n_outputs]).unsqueeze(-2)
        on_line = last.unsqueeze(-1) + 0.5 * slope.unsqueeze(-1) * since_lost
        joins = bridged.unsqueeze(-1).unsqueeze(-1)
        past = torch.where(joins, begin.unsqueeze(-1) + since_lost * on_line, past)
        since_lost = (short.unsqueeze(-1) - dt * self.lags[: self.n_rates]).unsqueeze(-2)
        rates = torch.where(joins, last.unsqueeze(-1) + slope.unsqueeze(-1) * since_lost, rates)
        kept = torch.exp(-short / self.swing_time_s)
        mean = 0.5 * (last + rates[..., 0])[..., 0]
        swing = kept * swing + (1.0 - kept) * self.swing_time_s * mean
        doubt = (self.bridged_rad_s2 * short**2) ** 2
        covariance = covariance + doubt.unsqueeze(-1).unsqueeze(-1) * self.growth[0]

        square = own[..., 0] ** 2 + own[..., 1] ** 2 + own[..., 2] ** 2
        mean_rate = s[..., kernel.MEAN_RATE : kernel.MEAN_RATE + 3]
        away = inputs[..., :3] - mean_rate
        mean_rate = mean_rate + p[kernel.REST_GAIN] * away
        scatter = away[..., 0] ** 2 + away[..., 1] ** 2 + away[..., 2] ** 2
        scatter = s[..., kernel.SCATTER] + p[kernel.REST_GAIN] * (scatter - s[..., kernel.SCATTER])
        known_to = torch.maximum(covariance[..., 3, 3], covariance[..., 4, 4])
        walks = idle < p[kernel.IDLE_MOST]
        gain = walks.to(s.dtype) * p[kernel.LEG_GAIN]
        own_square = own[..., 0] ** 2
        leg_square, leg_cube = s[..., kernel.SQUARE], s[..., kernel.CUBE]
        leg_square = leg_square + gain * (own_square - leg_square)
        leg_cube = leg_cube + gain * (own_square * own[..., 0] - leg_cube)
        away = torch.abs(past[..., :2, 0] - x[..., kernel.CENTRE : kernel.CENTRE + 2])
        # the network's share: a threshold would amplify rounding errors
        near = (self.far_rad - torch.maximum(away[..., 0], away[..., 1])) * self.per_far_rad
        near = torch.where(s[..., kernel.TRUST] <= p[kernel.EARLY], one, near.clamp(0.0, 1.0))
        sure = (p[kernel.KNOWN_ENOUGH] - known_to) / (self.doubt_span * p[kernel.KNOWN_ENOUGH])
        share = torch.where(walks, sure.clamp(0.0, 1.0) * near, zero)
        works = share > 0.0

        tilt = past[..., 0]
        if self.n_outputs > 1:
            tilt = 2.0 * past[..., 0] - past[..., 1]
        rate = coupled_rates(own, tilt)
        cos_f = torch.maximum(torch.abs(torch.cos(tilt[..., 1])), self.cos_frontal_min)
        turn = rate[..., 2]
        turning = s[..., kernel.TURNING]
        turning = turning + p[kernel.TURNING_GAIN] * (turn - turning)
        mean_turn = s[..., kernel.TURN] + p[kernel.TURN_GAIN] * (turn - s[..., kernel.TURN])
        lean = x[..., kernel.LEAN] * mean_turn
        about = x[..., kernel.CENTRE : kernel.CENTRE + 3] + lean.unsqueeze(-1) * e[1, :3]
        features = torch.cat([rate.unsqueeze(-1), rates[..., : self.n_past]], dim=-1)
        carried = self._network(features, past, about)
        integrated = past[..., 0] + 0.5 * dt * (rate + rates[..., 0])
        part = share.unsqueeze(-1)
        partly = torch.where(part > 0.0, integrated + part * (carried - integrated), integrated)
        carried = torch.where(part < 1.0, partly, carried)
        corrected = s[..., kernel.CORRECTED : kernel.CORRECTED + 2]
        corrected = p[kernel.CORRECTED_KEPT] * corrected + (carried - integrated)[..., :2]
        turned = carried[..., 0]
        whole = (torch.abs(turned) > self.pi).to(s.dtype) * torch.sign(turned)
        wrapped = (2.0 * self.pi * whole).unsqueeze(-1) * e[0, :3]
        carried, past = carried - wrapped, past - wrapped.unsqueeze(-1)
        rates = torch.cat([rate.unsqueeze(-1), rates[..., : self.n_rates - 1]], dim=-1)
        heading = carried[..., 2]
        step = (torch.abs(heading) > self.heading_step).to(s.dtype) * torch.sign(heading)
        step = self.heading_step * step
        on_heading = step.unsqueeze(-1) * e[2, :3]
        carried, past = carried - on_heading, past - on_heading.unsqueeze(-1)
        sums = sums - (samples * step).unsqueeze(-1) * e[2, :3]
        x = x - step.unsqueeze(-1) * e[5]
        heading = s[..., self.heading_at] + step

        known = s[..., kernel.KNOWN] > 0.0
        loss = torch.where(known, zero, self.centre_loss)
        noise = torch.where(known, zero, p[kernel.CENTRE_NOISE])
        leak = share * p[kernel.LEAK] * dt
        coupling = torch.where(torch.abs(turning) > p[kernel.TURN_LEAST], dt * mean_turn, zero)
        # the tilt of the posture comes back; what rounding leaves of it is kept for the next time
        # the variance crosses a limit slowly: rounding would change the sample at which it does
        slow = torch.cat([x[..., 3:5], torch.diagonal(covariance, dim1=-2, dim2=-1)[..., 3:5]], -1)
        shares = torch.stack([loss, loss, loss * (2.0 - loss), loss * (2.0 - loss)], dim=-1)
        grows = torch.stack([zero, zero, noise, noise], dim=-1)
        lower = s[..., self.lower_at : self.lower_at + 4] + (grows - shares * slow)
        slowly = slow + lower
        lower = lower - (slowly - slow)
        moved = slowly[..., :2]
        # the mean heading turns with the person; a threshold would amplify rounding errors
        turns = torch.clamp(torch.abs(turning) / p[kernel.TURN_LEAST] - 1.0, 0.0, 1.0)
        turned_by = (dt * mean_turn * turns).unsqueeze(-1) * e[5, 5:]
        x = torch.cat([carried, moved, x[..., 5:] + turned_by], dim=-1)
        factors = [leak, one, coupling, leak * mean_turn]
        if self.aided:
            force_x, force_y, force_z = inputs[..., 3], inputs[..., 4], inputs[..., 5]
            sin_s, cos_s = torch.sin(x[..., 0]), torch.cos(x[..., 0])
            sin_f, cos_of_f = torch.sin(x[..., 1]), torch.cos(x[..., 1])
            up = sin_s * force_x + cos_s * force_z
            forward = cos_s * force_x - sin_s * force_z
            left = cos_of_f * force_y + sin_f * up
            ahead, aside = x[..., kernel.VELOCITY], x[..., kernel.VELOCITY + 1]
            velocity = [ahead + dt * (forward + turn * aside), aside + dt * (left - turn * ahead)]
            x = torch.cat([x[..., : kernel.VELOCITY], torch.stack(velocity, dim=-1)], dim=-1)
            factors += [up, turn, cos_of_f * up - sin_f * force_y]
        else:
            factors += [zero, zero, zero]
        factors += [one]
        transition = (torch.stack(factors, dim=-1).unsqueeze(-1).unsqueeze(-1) * self.changes).sum(
            -3
        )
        transition = transition @ (e + loss.unsqueeze(-1).unsqueeze(-1) * self.lossy)
        covariance = transition @ covariance @ transition.transpose(-1, -2)
        angle_noise = p[kernel.ANGLE_NOISE] + p[kernel.RATE_NOISE] * square / cos_f**2
        noises = [angle_noise, noise, p[kernel.BIAS_NOISE] * one, p[kernel.VELOCITY_NOISE] * one]
        noise = torch.stack(noises, dim=-1).unsqueeze(-1).unsqueeze(-1)
        covariance = covariance + (noise * self.growth).sum(-3)
        for axis in range(2):
            at = kernel.CENTRE + axis
            rounded = slowly[..., 2 + axis] - covariance[..., at, at]
            covariance = covariance + rounded.unsqueeze(-1).unsqueeze(-1) * self.only_postures[axis]

        mean_square = mean_rate[..., 0] ** 2 + mean_rate[..., 1] ** 2 + mean_rate[..., 2] ** 2
        rests = (scatter < p[kernel.REST_LEAST]) & (mean_square < self.most_bias_square)
        resting = rests.to(s.dtype)
        for axis in range(3):
            at = kernel.BIAS + axis
            x, covariance = self._measured(
                x,
                covariance,
                at,
                p[kernel.REST_VARIANCE],
                mean_rate[..., axis] - x[..., at],
                resting,
            )
        since, idle, samples = since + dt, idle + dt, samples + 1.0
        sum_turn, sums = sum_turn + turn, sums + carried
        if self.aided:
            for i in range(2):
                at = kernel.VELOCITY + i
                usual = p[kernel.SPEED] if i == 0 else zero
                x, covariance = self._measured(
                    x, covariance, at, p[kernel.VELOCITY_VARIANCE + i], usual - x[..., at], one
                )

        swing = swing + (self.swing_gain_s * own[..., 0] - self.swing_loss * swing)
        high, low = torch.maximum(high, swing), torch.minimum(low, swing)
        span = s[..., kernel.SPAN] - self.span_loss * s[..., kernel.SPAN]
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
        opened = (turned * (swing_turn * since) ** 2).unsqueeze(-1).unsqueeze(-1)
        covariance = covariance + opened * self.postures[2]
        before = s[..., kernel.BEFORE : kernel.BEFORE + 2]
        net = (x[..., 0] - before[..., 0]) ** 2 + (x[..., 1] - before[..., 1]) ** 2
        moved = applies * ((net > p[kernel.MOST_NET]) & ~known).to(s.dtype) * p[kernel.REOPENED]
        covariance = covariance + moved.unsqueeze(-1).unsqueeze(-1) * self.tilt
        doubt = 1.0 + net / p[kernel.RETURN_VARIANCE]
        lasted = torch.where(period > 0.0, period, one)
        irregular = ((since / lasted - 1.0) / p[kernel.PERIOD_SHARE]) ** 2
        doubt = doubt + torch.where(period > 0.0, irregular, 3.0 * one)
        unknown = torch.maximum(covariance[..., 0, 0], covariance[..., 1, 1])
        walks = (doubt < self.most_doubt) | (unknown > p[kernel.KNOWN_ENOUGH])
        share = (p[kernel.EARLY] / (p[kernel.EARLY] + s[..., kernel.TRUST])) ** 2
        odds: list[Tensor] = []
        for axis in range(3):
            direction = e[axis] + torch.zeros_like(x)
            centre = x[..., 3 + axis]
            if axis == 1:
                direction = direction - swing_turn.unsqueeze(-1) * e[kernel.LEAN]
                centre = centre + x[..., kernel.LEAN] * swing_turn
            residual = centre - sums[..., axis] / samples
            variance = p[kernel.CYCLE_VARIANCE + axis] * doubt
            spread = (covariance * direction.unsqueeze(-2)).sum(-1)
            expected = (spread * direction).sum(-1) + variance
            excess = residual**2 / (p[kernel.OUTLIER] * expected)
            odd = s[..., kernel.ODD + axis]
            outlier = excess > 1.0
            again = outlier & (odd * residual > 0.0)
            alone = outlier & ~again
            wider = applies * again.to(s.dtype) * residual**2
            # a heading far from the mean is a turn, never an error
            error = wider * share if axis < 2 else torch.zeros_like(wider)
            of_angle = error.unsqueeze(-1).unsqueeze(-1)
            of_posture = (wider - error).unsqueeze(-1).unsqueeze(-1)
            covariance = covariance + of_angle * torch.outer(e[axis], e[axis])
            covariance = covariance + of_posture * self.postures[axis]
            counts = applies * (~alone).to(s.dtype)
            spread = (covariance * direction.unsqueeze(-2)).sum(-1)
            total = (spread * direction).sum(-1) + variance
            x, covariance = self._updated(x, covariance, spread, total, residual, counts)
            odds += [torch.where(swung, torch.where(alone, torch.sign(residual), zero), odd)]
        trust = s[..., kernel.TRUST] + applies / doubt
        walks = swung & walks & (odds[0] == 0.0) & (odds[1] == 0.0)
        idle = torch.where(walks, zero, idle)
        period = torch.where(ends, torch.where(swung, since, zero), period)
        since, samples = torch.where(ends, zero, since), torch.where(ends, zero, samples)
        sum_turn = torch.where(ends, zero, sum_turn)
        sums = torch.where(ends.unsqueeze(-1), 0.0 * sums, sums)
        before = torch.where(ends.unsqueeze(-1), x[..., :2], before)

        correction = (x[..., :3] - carried).unsqueeze(-1)
        corrected = corrected + part * correction[..., :2, 0]
        past = torch.cat(
            [x[..., :3].unsqueeze(-1), past[..., : self.n_outputs - 1] + correction], dim=-1
        )
        swinging = torch.stack(
            [
                mean_turn, swing, high, low, span, rising, since, idle, period, trust, scatter,
                zero, samples,
            ],
            dim=-1,
        )  # fmt: skip
        scalars = torch.cat(
            [
                swinging,
                sums,
                sum_turn.unsqueeze(-1),
                before,
                torch.stack(odds, dim=-1),
                mean_rate,
                s[..., kernel.KNOWN : kernel.KNOWN + 1],
                torch.stack([leg_square, leg_cube, turning], dim=-1),
                corrected,
                heading.unsqueeze(-1),
                lower,
                works.to(s.dtype).unsqueeze(-1),
            ],
            dim=-1,
        )
        return torch.cat(
            [
                x,
                covariance.flatten(-2),
                scalars,
                rates.flatten(-2),
                past.flatten(-2),
            ],
            dim=-1,
        )
