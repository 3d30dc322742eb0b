"""Stability of a trained network: poles, gain, contraction, bounds.

The tanh bounds the output for any input, so a network with a pole outside the unit circle can still
have a small training error; poles and contraction reveal this instability.
"""

import itertools
import math
import warnings
from dataclasses import dataclass

import numpy as np
import torch

from narx.network.model import Narx
from narx.types import FloatArray


@dataclass(frozen=True)
class StabilityStatement:
    """Stability of a network; plain numbers, serialisable as JSON.

    Parameters
    ----------
    operating_point_rad : float or None
        Angle at rest (rate zero) of a single axis; None if the loop does not settle.
    poles : list of [float, float]
        Real and imaginary parts of the poles of the loop linearised at that point.
    largest_pole : float
        Largest magnitude of the poles: stable below 1.
    time_constant_s : float or None
        Time constant of that pole; None if it is not stable.
    gain_at_zero_frequency_s : float or None
        Angle per constant rate, rad/(rad/s): an integrator's would be infinite, a leaky one's is
        its time constant. None if it is infinite.
    rate_range_rad_s, angle_range_rad : float
        Training range: rates up to this magnitude are simulated, as long as their integral stays
        within this angle. (A leg does not rotate steadily at its peak rate.)
    contraction_bound : float
        Largest factor by which one step of one axis can increase the distance of two states, in the
        norm of the operating point, for any hidden activations: a value below 1 proves that all
        states of an axis with given rates converge; a value above 1 proves nothing. It does not
        apply to coupled axes, whose rates depend on the states.
    coupled_rates_tried, coupled_rates_apart : int
        Simulation of coupled axes: number of constant rates, drawn within 20 deg/s about all three
        axes, and number of these for which two random initial states do not converge (more than a
        tenth of their initial distance remains after `contraction_s`). 0 and 0 without coupling.
    coupled_rate_apart_rad_s : list of float or None
        The first of these rates; None if all states converge.
    contraction_ratio : float
        Largest distance of two initial states of all axes after `contraction_s`, relative to
        the first, over constant, oscillating and random rates within the range.
    contraction_s : float
        That duration, s: eight time constants, at least 10 s, at most 300 s.
    contracts : bool
        The ratio is below 1 %, which eight time constants reach with a margin.
    output_bound_rad : float
        Bound of the angle (relative to the posture) for any rates.
    excursion_rad : float
        Largest angle at rates of ten times the range.
    recovery_ratio : float
        Distance from the operating point after the excursion and `contraction_s` of rest,
        relative to the excursion.
    recovers : bool
        That ratio is below 1 %.
    stable : bool
        Poles inside the unit circle, contracting and recovering.
    """

    operating_point_rad: float | None
    poles: list[list[float]]
    largest_pole: float
    time_constant_s: float | None
    gain_at_zero_frequency_s: float | None
    rate_range_rad_s: float
    angle_range_rad: float
    contraction_bound: float
    coupled_rates_tried: int
    coupled_rates_apart: int
    coupled_rate_apart_rad_s: list[float] | None
    contraction_ratio: float
    contraction_s: float
    contracts: bool
    output_bound_rad: float
    excursion_rad: float
    recovery_ratio: float
    recovers: bool
    stable: bool


_MET = 0.01
# constant rates about all axes, an endless tilted turn, do not occur in walking
_CONSTANT_RATES, _CONSTANT_RATE_RAD_S, _APART = 100, math.radians(20.0), 0.1


def stability_statement(model: Narx, n_levels: int = 9, seed: int = 0) -> StabilityStatement:
    """Analyse a network at rest, within its training range, and outside.

    Parameters
    ----------
    model : Narx
        Trained network.
    n_levels : int
        Number of constant rates, and of frequencies of oscillating ones.
    seed : int
        Seed of the random rates and initial states.

    Returns
    -------
    StabilityStatement
        Poles, gain and bounds by formula; contraction and recovery by simulation.
    """
    linear = _Linearised(model)
    scaled = model.normalisation
    # a min_max scale is the range itself; peaks of gait are about three times its RMS
    rate_range = max(abs(scaled.rate_scale_rad_s), 3.0 * scaled.rate_rms_rad_s)
    angle_range = min(3.0 * abs(scaled.angle_scale_rad), 1.0)
    magnitudes = np.abs(linear.poles)
    largest = float(magnitudes.max())
    time_constant = None
    if 0.0 < largest < 1.0:
        time_constant = -1.0 / (math.log(largest) * model.sampling_rate_hz)
    duration = min(max(8.0 * (time_constant or 40.0), 10.0), 300.0)
    leak = 1.0 / (time_constant or duration)
    rates = _rates(model.sampling_rate_hz, duration, rate_range, angle_range, leak, n_levels, seed)
    ratio = _contraction(model, rates, seed)
    apart = _apart(model, duration, seed)
    excursion, recovery = _excursion(model, rates, duration)
    gain = linear.gain()
    contracts, recovers = ratio < _MET, recovery < _MET
    return StabilityStatement(
        operating_point_rad=linear.operating_point_rad,
        poles=[[float(p.real), float(p.imag)] for p in linear.poles],
        largest_pole=largest,
        time_constant_s=time_constant,
        gain_at_zero_frequency_s=gain,
        rate_range_rad_s=float(rate_range),
        angle_range_rad=float(angle_range),
        contraction_bound=linear.contraction_bound(),
        coupled_rates_tried=_CONSTANT_RATES if model.coupled else 0,
        coupled_rates_apart=len(apart),
        coupled_rate_apart_rad_s=apart[0] if apart else None,
        contraction_ratio=ratio,
        contraction_s=duration,
        contracts=contracts,
        output_bound_rad=linear.output_bound_rad,
        excursion_rad=excursion,
        recovery_ratio=recovery,
        recovers=recovers,
        stable=bool(largest < 1.0 and contracts and recovers),
    )


class _Linearised:
    """One axis at rest: ``p_k = sum b_i v_{k-i} + sum a_m p_{k-m}`` about its fixed point."""

    def __init__(self, model: Narx) -> None:
        structure, scaled = model.structure, model.normalisation
        w = model.weights.detach().numpy()
        self._scaled = scaled
        self._n_out = structure.output_lags
        self._w1 = w[structure.w1].reshape(structure.hidden, structure.n_features)
        self._b1, self._w2, b2 = w[structure.b1], w[structure.w2], w[structure.b2]
        n_in = structure.n_input_features
        rest = -scaled.rate_offset_rad_s / scaled.rate_scale_rad_s
        at_rest = self._b1 + self._w1[:, :n_in].sum(axis=1) * rest
        feedback = self._w1[:, n_in:].sum(axis=1)
        # the fixed point satisfies |p| <= |b2| + sum |w2|; of several, the one nearest zero is used
        self._bound = abs(b2) + np.abs(self._w2).sum()
        grid = np.linspace(-1.0, 1.0, 20001) * self._bound
        error = b2 + np.tanh(at_rest + grid[:, None] * feedback) @ self._w2 - grid
        crossing = np.flatnonzero(np.diff(np.signbit(error)) | (error[:-1] == 0.0))
        p = 0.0
        if len(crossing):
            p = float(grid[crossing[np.argmin(np.abs(grid[crossing]))]])
            for _ in range(50):  # Newton, from within a grid step
                h = np.tanh(at_rest + p * feedback)
                slope = (self._w2 * (1 - h * h)) @ feedback - 1.0
                if slope == 0.0:
                    break
                p -= float((b2 + h @ self._w2 - p) / slope)
        h = np.tanh(at_rest + p * feedback)
        gradient = (self._w2 * (1 - h * h)) @ self._w1
        self._from_inputs, self._a = gradient[:n_in], gradient[n_in:]
        self.poles = np.roots(np.concatenate([[1.0], -self._a]))
        if len(self.poles) < self._n_out:  # np.roots omits roots at the origin
            missing = np.zeros(self._n_out - len(self.poles))
            self.poles = np.concatenate([self.poles, missing])
        self.operating_point_rad = p * scaled.angle_scale_rad + scaled.angle_offset_rad
        self.output_bound_rad = float(
            self._bound * abs(scaled.angle_scale_rad) + abs(scaled.angle_offset_rad)
        )

    def gain(self) -> float | None:
        """Angle per constant rate, s."""
        leak = 1.0 - self._a.sum()
        if leak == 0.0:
            return None
        units = self._scaled.angle_scale_rad / self._scaled.rate_scale_rad_s
        return float(self._from_inputs.sum() / leak * units)

    def contraction_bound(self) -> float:
        """Bound the expansion of a step for any activations.

        The step's derivative is linear in the slopes 1 - h^2, each between 0 and 1, so a norm of it
        is largest at a vertex. The norm is that of the eigenvectors at the operating point.
        """
        n_in = self._w1.shape[1] - self._n_out
        shift = np.eye(self._n_out, k=-1)

        def companion(slopes: FloatArray) -> FloatArray:
            matrix = shift.copy()
            matrix[0] = (self._w2 * slopes) @ self._w1[:, n_in:]
            return matrix

        matrix = shift.copy()
        matrix[0] = self._a
        _, vectors = np.linalg.eig(matrix)
        if np.linalg.cond(vectors) > 1e12:
            vectors = np.eye(self._n_out)
        inverse = np.linalg.inv(vectors)
        corners = itertools.product((0.0, 1.0), repeat=len(self._w2))
        norms = [
            np.linalg.norm(inverse @ companion(np.array(corner)) @ vectors, 2)
            for corner in itertools.islice(corners, 4096)
        ]
        return float(max(norms)) if len(self._w2) <= 12 else math.inf


def _rates(
    rate_hz: float,
    duration_s: float,
    rate_range: float,
    angle_range: float,
    leak: float,
    n: int,
    seed: int,
) -> torch.Tensor:
    """Constant, oscillating and random rates of three axes, (3 n, N, 3), rad/s."""
    rng = np.random.default_rng(seed)
    n_samples = math.ceil(duration_s * rate_hz)
    time_s = np.arange(n_samples)[:, None] / rate_hz
    kinds = []
    for level in np.linspace(-1.0, 1.0, n):
        size = min(rate_range, leak * angle_range)
        kinds.append(np.broadcast_to(size * level * rng.choice([-1.0, 1.0], 3), (n_samples, 3)))
    for frequency_hz in np.geomspace(0.05, min(10.0, rate_hz / 4), n):
        size = min(rate_range, math.hypot(leak, 2 * np.pi * frequency_hz) * angle_range)
        phase = rng.uniform(0, 2 * np.pi, 3)
        kinds.append(size * np.sin(2 * np.pi * frequency_hz * time_s + phase))
    # white noise rates: their integral, leaky or not, stays small
    for size in np.linspace(0.0, rate_range, n):
        kinds.append(size * np.clip(rng.standard_normal((n_samples, 3)) / 3.0, -1.0, 1.0))
    return torch.from_numpy(np.stack(kinds))


def _contraction(model: Narx, rates: torch.Tensor, seed: int) -> float:
    ratio = float(_distances_left(model, rates, np.random.default_rng(seed)).max())
    return ratio if math.isfinite(ratio) else math.inf


def _apart(model: Narx, duration_s: float, seed: int) -> list[list[float]]:
    """Find constant rates for which two states of coupled axes do not converge."""
    if not model.coupled:
        return []
    rng = np.random.default_rng([seed, 1])
    constant = rng.uniform(-_CONSTANT_RATE_RAD_S, _CONSTANT_RATE_RAD_S, (_CONSTANT_RATES, 1, 3))
    n_samples = math.ceil(duration_s * model.sampling_rate_hz)
    rates = torch.from_numpy(np.repeat(constant, n_samples, axis=1))
    left = _distances_left(model, rates, rng)
    met = left.numpy() <= _APART  # negated, so that NaN counts as not converged
    return [rate.tolist() for rate in constant[~met, 0]]


def _distances_left(model: Narx, rates: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Distance (B,) of two random states after the rates (B, N, 3), relative to the initial one."""
    shape = (2, len(rates), 3, model.structure.n_state)
    # within +-1 in normalised units: the range of training
    states = torch.from_numpy(rng.uniform(-1.0, 1.0, shape))
    n_past = model.structure.n_input_state
    first = (states[0] - states[1])[..., n_past:].abs().amax(dim=(1, 2))
    with torch.no_grad():
        _, one = model(rates, states[0])
        _, other = model(rates, states[1])
    return (one - other)[..., n_past:].abs().amax(dim=(1, 2)) / first


def _excursion(model: Narx, rates: torch.Tensor, duration_s: float) -> tuple[float, float]:
    n_rest = math.ceil(duration_s * model.sampling_rate_hz)
    with torch.no_grad(), warnings.catch_warnings():
        # no leg is as fast, on purpose
        warnings.simplefilter("ignore", UserWarning)
        away, state = model(10.0 * rates[:, : math.ceil(10.0 * model.sampling_rate_hz)])
        after, _ = model(torch.zeros(len(rates), n_rest, 3, dtype=rates.dtype), state)
        rest, _ = model(torch.zeros(1, n_rest, 3, dtype=rates.dtype))
    excursion = float(away.abs().max())
    left = float((after[:, -1] - rest[:, -1]).abs().max())
    ratio = left / excursion if excursion > 0 else 0.0
    return excursion, ratio if math.isfinite(ratio) else math.inf
