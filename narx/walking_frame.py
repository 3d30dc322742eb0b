"""Anatomical frames from walking alone, for who did no calibration movements.

Gravity gives z, in standing or over the walk; the horizontal axis about which the sensor turns most
gives y; the way a leg swings gives its sign. A leg with a sensor on thigh and shank shows more: its
knee (`narx.knee_axis`).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from narx.anatomical_frame import (
    MIN_WALK_S,
    frame_from_left,
    principal_horizontal_axis,
    swing_sign,
    up_from_gravity,
    walking_band,
)
from narx.errors import RecordingError
from narx.functional_frame import leg_of, standing_force
from narx.knee_axis import MAX_WALK_S, MIN_STRIDES_S, knee_headings
from narx.recording import FloatArray, Trial, side_of
from narx.segment_angles import axis_rates, mirror_angular_rate
from narx.static_bias import static_bias

# the posture is taken to last until the walk begins, if not for longer than this
_MAX_WAIT_S = 5.0


def walking_frame(trial: Trial, segment: str, bias_rad_s: FloatArray) -> tuple[Rotation, str]:
    """Build the frame of one segment from a walk.

    Parameters
    ----------
    trial : Trial
        With a walk of a thigh or a shank; of both of a leg, where it can be had.
    segment : str
        Which sensor.
    bias_rad_s : ndarray, shape (3,)
        Its gyroscope's bias, rad/s.

    Returns
    -------
    sensor_to_anatomical : Rotation
        Takes vectors in the sensor frame to the anatomical frame.
    how : str
        What was done, for people.

    Raises
    ------
    RecordingError
        If the walk is too short, or does not tell forward from backward.
    """
    frame, how = _own_frame(trial, segment, bias_rad_s)
    turn_rad = _turn_by_knee(trial, segment)
    if turn_rad is None:
        return frame, how
    mirror = -1.0 if side_of(segment) == "left" else 1.0
    return Rotation.from_rotvec([0.0, 0.0, mirror * turn_rad]) * frame, (
        f"{how}; turned by {np.degrees(turn_rad):.1f} deg about z for the knee to abduct least"
    )


def _own_frame(trial: Trial, segment: str, bias_rad_s: FloatArray) -> tuple[Rotation, str]:
    standing = standing_force(trial, segment)
    force = trial.imus[segment].accelerometer_m_s2[_walking_samples(trial)]
    up = up_from_gravity(force if standing is None else standing, f"{trial.name}, '{segment}'")
    walk = _walk(trial, segment, bias_rad_s)
    if len(walk) < MIN_WALK_S * trial.sampling_rate_hz:
        raise RecordingError(
            f"{trial.name}: {len(walk) / trial.sampling_rate_hz:.1f} s of walking by "
            f"'{segment}' to calibrate from, expected at least {MIN_WALK_S:g} s"
        )
    left = principal_horizontal_axis(walk, up)
    sign = swing_sign(walk, left)
    if sign == 0:
        raise RecordingError(
            f"{trial.name}: '{segment}' does not swing forward and back at different speeds, "
            "so forward cannot be told from backward; is it walking?"
        )
    source = "mean specific force of the walk" if standing is None else "standing"
    return frame_from_left(up, sign * left), (
        f"walking: z from {source}, y from the principal horizontal axis at 0.5-10 Hz, "
        "sign from the forward swing"
    )


def _turn_by_knee(trial: Trial, segment: str) -> float | None:
    """By how much the knee would have the segment turned; None where there is none to see."""
    leg = leg_of(segment)
    if segment not in leg or not all(name in trial.imus for name in leg):
        return None
    rates = []
    for name in leg:
        still = static_bias(trial, name)
        bias = np.zeros(3) if still is None else still.bias_rad_s
        try:
            frame, _ = _own_frame(trial, name, bias)
        except RecordingError:
            # a leg whose other sensor shows no walk is as good as one without it
            return None
        rate = frame.apply(trial.imus[name].gyroscope_rad_s - bias)
        rates.append(axis_rates(mirror_angular_rate(rate) if side_of(name) == "left" else rate))
    piece = _first_steps(trial, np.asarray(np.isfinite(np.hstack(rates)).all(axis=1)))
    if piece.size < MIN_STRIDES_S * trial.sampling_rate_hz:
        return None
    thigh, shank = (rate[piece] for rate in rates)
    turns = knee_headings(thigh, shank, trial.sampling_rate_hz)
    return float(turns[leg.index(segment)])


def _first_steps(trial: Trial, there: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Samples of the walk from the calibration posture on, up to the first gap."""
    time = trial.time_s
    begin, end = trial.walking_s or (time[0], time[-1])
    if trial.still_s:
        posture_s = trial.still_s[0][1]
    elif trial.starts_in_calibration_posture:
        posture_s = time[0]
    else:
        return np.empty(0, dtype=np.intp)
    if not begin - _MAX_WAIT_S <= posture_s < end:
        return np.empty(0, dtype=np.intp)
    inside = (time >= posture_s) & (time <= min(end, max(begin, posture_s) + MAX_WALK_S))
    samples = np.flatnonzero(inside)
    gaps = np.flatnonzero(~there[samples])
    return samples[: gaps[0]] if gaps.size else samples


def _walking_samples(trial: Trial) -> NDArray[np.bool_]:
    if trial.walking_s is None:
        return np.ones(trial.n_samples, dtype=bool)
    begin, end = trial.walking_s
    return np.asarray((trial.time_s >= begin) & (trial.time_s <= end))


def _walk(trial: Trial, segment: str, bias: FloatArray) -> FloatArray:
    # filtered as a whole, then cut, so that a short walk is not all filter transient
    rate = walking_band(trial.imus[segment].gyroscope_rad_s - bias, trial.sampling_rate_hz)
    walk = rate[_walking_samples(trial)]
    return walk[np.isfinite(walk).all(axis=1)]
