"""Tracking of posture, bias and uncertainty, which the network cannot estimate.

A gyroscope has no absolute angle. The walking leg provides one: it returns, so the mean angle of a
swing is that of the posture, and its mean rate is zero. A small Kalman filter (Kalman, J. Basic
Eng. 82, 1960) makes use of both::

    angle' = rate(gyroscope - bias, angle) + noise        propagated by the network in walking
    centre' = -centre / posture_time + noise              centre of the swing
    bias' = noise
    mean angle over a swing = centre + lean * mean turn rate + noise

The last line is a measurement once per swing, so that the swing itself is not mistaken for drift.
`lean` is the lean of the body into a turn, frontal angle per turn rate: speed divided by the
acceleration of gravity. In a turn, a tilt error rotates from one plane into the other while the
posture does not, which separates the two; the covariance couples the planes only in turns, since
smaller movements would add more systematic error than information. A turn is recognised by the mean
turn rate over a stride (`turning_time_s`), in which the leg's own rotation cancels; within it the
planes are coupled by the turn rate of a fraction of a step (`turn_time_s`).
The mean heading turns with the person: in a turn the transverse centre changes at the mean turn
rate, and a heading far from it is taken for a turn that was missed, not for an error of the angle.

Movement other than gait is recognised by the swing: a swing that does not return, or is much longer
or shorter than the previous one, has less weight (`return_sd_deg`, `period_share`). Two successive
swings that agree on a posture far from the expected one reset its uncertainty, and early in a
recording that of the angle. Without a swing for `idle_s` there is no correction: the rates are
integrated, and the standard deviation grows. The same holds after a swing that ends 35 degrees and
more from where it began while the angle is known: the person has sat down or stood up. Once five
good swings have established the posture, the network's share in the angles falls to zero from 45 to
55 degrees away from it, as in sitting, since it would draw them back. It also rises along a line as
the variance of the posture falls below its limit. At rest the mean rate measures the bias. The
swing in which a recording begins is incomplete, so its mean angle is not used. If the start is
unknown, a swing that ends so far from its beginning may also be that of a phone on its way from the
hand into the pocket, whose angle was learned from other motion: it is doubted (`reopened_sd_deg`).

The returned standard deviation s follows from the variance P of the filter, the rate of the angle
and three errors that the filter cannot estimate: the time of an angle; a slip of the sensor or
another change that it takes for drift; and, from a known start only, what calibration and skin
leave::

    filter = std_scale * growth * sqrt(P + (delay_s * rate)^2)
    s = max(sqrt(filter^2 + (c^2 / corrected_sd_deg)^2), alignment_sd_deg)

c is the sum of the corrections of the last 15 s by which network and filter have moved a tilt
angle away from the integrated rates. A gyroscope drifts slowly, so in steady walking it is about a
degree; after a slip of 20 degrees the angle is drawn towards the former posture, and c is half of
the error. Where it adds more than five degrees, the samples are marked as doubtful.

A leg swings forward faster than backward. Where the skewness of the sagittal rate is below that of
a leg, as of an arm, a phone at the ear or a sensor mounted the wrong way round, the standard
deviation is multiplied by up to six; the estimate is unchanged. Which motion it is must be learned
from an unknown start, so the standard deviation is larger in the first strides.

In a gap below 0.35 s the rates are interpolated (`narx.kernels.short_gap`); in a longer one the
motion is unknown.

With an accelerometer (`aided`), the horizontal specific force is integrated to a velocity,
which is bounded in walking: forward about `speed_m_s`, sideways about zero. A wrong tilt makes it
diverge, which gives the correction. Two parameters, `forward_sd_m_s` and `sideways_sd_m_s`, set the
weight of the accelerometer.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from narx.errors import UserError
from narx.kernels import tracker_layout as kernel
from narx.network.model import Narx
from narx.types import FloatArray

# lower limit of the turn rate (23 deg/s) in a turn
_TURN_LEAST_RAD_S = 0.4
# time constants of the swing angle's high-pass and of the decay of the largest recent swing; the
# share of the latter that the next swing must reach
_SWING_TIME_S, _SPAN_TIME_S, _SPAN_SHARE = 0.2, 0.6, 0.2
# residuals beyond three standard deviations are outliers
_OUTLIER = 9.0
# after this number of good swings, an outlier indicates a new posture rather than a wrong angle
_EARLY_SWINGS = 5.0
# no parameter is outside this range, which keeps squares and quotients finite
_SMALLEST, _LARGEST = 1e-9, 1e6
# time constant of the means that tell a leg from other motion: eight strides
_LEG_TIME_S = 8.0
# time over which corrections are summed
_CORRECTED_TIME_S = 15.0
# rest: over half a second, the rate varies by less than 1.5 deg/s
_REST_TIME_S, _REST_RAD_S = 0.5, math.radians(1.5)


@dataclass(frozen=True)
class PostureTracker:
    """Parameters of the Kalman filter that runs with the network.

    Parameters
    ----------
    angle_noise_deg : float
        Growth of the angle's uncertainty in one second, deg / sqrt(s).
    rate_noise : float
        The same, relative to the rate (scale and alignment of the gyroscope), 1 / sqrt(s).
    start_sd_deg : float
        Standard deviation of the angle at an unknown start.
    known_start_sd_deg : float
        The same if the start pose is known: no-one stands, and no sensor is aligned, exactly.
    posture_sd_deg : float
        Standard deviation of the posture about zero if the start is unknown.
    posture_time_s : float
        Time constant of the posture in that case, s.
    known_posture_sd_deg : float
        Standard deviation of the posture if the start pose is known; it is then constant.
    bias_sd_deg_s : float
        Standard deviation of the remaining gyroscope bias at an unknown start.
    known_bias_sd_deg_s : float
        The same if the start pose is known, because the bias is then measured in standing.
    bias_noise_deg_s : float
        Drift of the bias, deg/s / sqrt(s).
    lean_deg_s, lean_sd_deg_s : float
        Lean into a turn, degrees per rad/s, and its standard deviation among people.
    swing_sd_deg : tuple of three floats
        Standard deviation of a swing's mean angle about the posture: sagittal, frontal, transverse.
    return_sd_deg : float
        Difference between the two ends of a swing that doubles its measurement variance.
    period_share : float
        Relative difference between the durations of successive swings that adds as much.
    swing_least_deg : float
        Smaller swings are ignored.
    idle_s : float
        Time without a swing after which the leg is not walking, s.
    known_enough_deg : float
        The network propagates the angle once the posture's standard deviation is below this.
    turn_time_s : float
        Time constant of the turn rate with which the body leans and a tilt error rotates, s.
    turning_time_s : float
        Time constant of the turn rate by which a turn is recognised, about a stride, s.
    reopened_sd_deg : float
        Doubt of the angle after a swing that ends 7 `return_sd_deg` and more from where it began,
        if the start was unknown.
    delay_s : float
        Standard deviation of the time of an angle: the rate times it adds to the returned standard
        deviation.
    alignment_sd_deg : float
        What calibration and skin leave of the error if the start pose is known: the returned
        standard deviation is never smaller.
    corrected_sd_deg : float
        Recent corrections c of a tilt angle add ``c^2 / corrected_sd_deg`` to it. An accelerometer
        corrects all the time, so ``model=aided`` sets 1e6, which adds nothing.
    forward_sd_m_s, sideways_sd_m_s : float
        Standard deviation of the mean velocity over a second, m/s; this and the following only
        with `aided`.
    speed_m_s : float
        Mean forward velocity.
    velocity_noise_m_s : float
        Growth of the velocity's uncertainty in one second, m/s / sqrt(s).
    aided : bool
        Whether the accelerometer is used.
    std_scale : tuple of three floats
        Factor on the returned standard deviations, from training.

    Raises
    ------
    UserError
        If a value is not a number from 1e-9 to 1e6.
    """

    angle_noise_deg: float = 0.15
    rate_noise: float = 0.002
    start_sd_deg: float = 60.0
    known_start_sd_deg: float = 1.5
    posture_sd_deg: float = 2.5
    posture_time_s: float = 50.0
    known_posture_sd_deg: float = 15.0
    bias_sd_deg_s: float = 0.5
    known_bias_sd_deg_s: float = 0.1
    bias_noise_deg_s: float = 0.02
    lean_deg_s: float = 3.0
    lean_sd_deg_s: float = 2.0
    swing_sd_deg: tuple[float, float, float] = (3.0, 2.0, 4.0)
    return_sd_deg: float = 5.0
    period_share: float = 0.4
    swing_least_deg: float = 2.0
    idle_s: float = 1.5
    known_enough_deg: float = 3.5
    turn_time_s: float = 0.2
    turning_time_s: float = 1.0
    reopened_sd_deg: float = 10.0
    delay_s: float = 0.02
    alignment_sd_deg: float = 1.7
    corrected_sd_deg: float = 3.0
    forward_sd_m_s: float = 0.9
    sideways_sd_m_s: float = 0.25
    speed_m_s: float = 0.9
    velocity_noise_m_s: float = 0.1
    aided: bool = False
    std_scale: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "aided":
                if not isinstance(value, bool):
                    raise UserError(f"tracker.aided is {value!r}, expected true or false")
                continue
            several = field.name in ("swing_sd_deg", "std_scale")
            try:
                values = tuple(value) if several else (value,)
            except TypeError:
                values = ()
            if len(values) != (3 if several else 1) or not all(map(_is_positive, values)):
                expected = "three numbers" if several else "a number"
                raise UserError(
                    f"tracker.{field.name} is {value!r}, "
                    f"expected {expected} above zero (1e-9 to 1e6)"
                )
            if several:
                object.__setattr__(self, field.name, values)

    def numbers(self, model: "Narx | LinearRecursion") -> FloatArray:
        """Return the parameters for the compiled recurrence.

        Parameters
        ----------
        model : Narx or LinearRecursion
            Gives the sampling rate, the scales and the leak.

        Returns
        -------
        ndarray, shape (PARAMETERS,)
            In the order of the names in `narx.kernels.tracker`, in rad, s and m.
        """
        dt = 1.0 / model.sampling_rate_hz
        decay = math.exp(-dt / self.posture_time_s)
        posture = math.radians(self.posture_sd_deg)
        rate_scale, angle_scale = 1.0, 1.0
        if isinstance(model, Narx):
            scaled = model.normalisation
            rate_scale, angle_scale = scaled.rate_scale_rad_s, scaled.angle_scale_rad
        values = {
            kernel.INTERVAL: dt,
            kernel.LEAK: leak_rad_s(model),
            kernel.ANGLE_NOISE: math.radians(self.angle_noise_deg) ** 2 * dt,
            kernel.RATE_NOISE: self.rate_noise**2 * dt,
            kernel.CENTRE_DECAY: decay,
            kernel.CENTRE_NOISE: posture**2 * (1.0 - decay**2),
            kernel.BIAS_NOISE: math.radians(self.bias_noise_deg_s) ** 2 * dt,
            kernel.START_VARIANCE: math.radians(self.start_sd_deg) ** 2,
            kernel.KNOWN_ENOUGH: math.radians(self.known_enough_deg) ** 2,
            kernel.TURN_GAIN: dt / (self.turn_time_s + dt),
            kernel.TURN_LEAST: _TURN_LEAST_RAD_S,
            kernel.SWING_DECAY: 1.0 + dt / _SWING_TIME_S,
            kernel.SPAN_DECAY: math.exp(-dt / _SPAN_TIME_S),
            kernel.SPAN_SHARE: _SPAN_SHARE,
            kernel.SWING_LEAST: math.radians(self.swing_least_deg),
            kernel.IDLE_MOST: self.idle_s,
            kernel.RETURN_VARIANCE: math.radians(self.return_sd_deg) ** 2,
            kernel.PERIOD_SHARE: self.period_share,
            kernel.OUTLIER: _OUTLIER,
            kernel.EARLY: _EARLY_SWINGS,
            kernel.REST_GAIN: dt / (_REST_TIME_S + dt),
            kernel.REST_LEAST: _REST_RAD_S**2,
            kernel.REST_VARIANCE: math.radians(0.5) ** 2 / dt,
            kernel.VELOCITY_NOISE: self.velocity_noise_m_s**2 * dt,
            kernel.SPEED: self.speed_m_s,
            kernel.RATE_SCALE: rate_scale,
            kernel.ANGLE_SCALE: angle_scale,
            kernel.VELOCITY_VARIANCE: self.forward_sd_m_s**2 / dt,
            kernel.VELOCITY_VARIANCE + 1: self.sideways_sd_m_s**2 / dt,
            kernel.LEG_GAIN: dt / (_LEG_TIME_S + dt),
            kernel.TURNING_GAIN: dt / (self.turning_time_s + dt),
            kernel.MOST_NET: (kernel.MOST_DOUBT - 1.0) * math.radians(self.return_sd_deg) ** 2,
            kernel.REOPENED: math.radians(self.reopened_sd_deg) ** 2,
            kernel.DELAY_S: self.delay_s,
            kernel.ALIGNMENT: math.radians(self.alignment_sd_deg),
            kernel.CORRECTED_KEPT: math.exp(-dt / _CORRECTED_TIME_S),
            kernel.PER_CORRECTED: 1.0 / math.radians(self.corrected_sd_deg),
        }
        for axis, sd in enumerate(self.swing_sd_deg):
            values[kernel.CYCLE_VARIANCE + axis] = math.radians(sd) ** 2
        return np.array([values[index] for index in range(kernel.PARAMETERS)])


def _is_positive(value: object) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and _SMALLEST <= value <= _LARGEST  # type: ignore[operator]


@dataclass(frozen=True)
class LinearRecursion:
    """A recursion that a tracker can run in the network's place.

    ``p_k = inputs . (v_k, v_{k-1}, ...) + outputs . (p_{k-1}, p_{k-2}, ...)``, the angle p relative
    to the posture.

    Parameters
    ----------
    sampling_rate_hz : float
        Rate for which it holds.
    inputs : tuple of float
        Coefficients of the rates, s.
    outputs : tuple of float
        Coefficients of the angles before.
    """

    sampling_rate_hz: float
    inputs: tuple[float, ...]
    outputs: tuple[float, ...]


def leak_rad_s(model: Narx | LinearRecursion) -> float:
    """Rate at which a recursion forgets a small deviation from its posture.

    Parameters
    ----------
    model : Narx or LinearRecursion
        An odd network, if a network.

    Returns
    -------
    float
        One over its gain to a constant rate, a network's linearised at zero; not below zero.

    Raises
    ------
    UserError
        If its angle does not depend on the rate.
    """
    if isinstance(model, LinearRecursion):
        return _leak(1.0 - sum(model.outputs), sum(model.inputs))
    structure, scaled = model.structure, model.normalisation
    weights = model.weights.detach().numpy()
    first = weights[structure.w1].reshape(structure.hidden, structure.n_features)
    linear = weights[structure.w2] @ first
    inputs = linear[: structure.n_input_features].sum()
    kept = linear[structure.n_input_features :].sum()
    return _leak(
        (1.0 - float(kept)) * scaled.rate_scale_rad_s, float(inputs) * scaled.angle_scale_rad
    )


def _leak(forgotten: float, gain: float) -> float:
    if not 1e-12 < abs(gain) < np.inf:
        raise UserError(
            f"the network's angle changes by {gain:g} of a constant rate, expected more: all "
            "weights of its inputs are zero, or cancel out"
        )
    return max(0.0, forgotten / gain)
