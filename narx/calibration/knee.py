"""Headings of thigh and shank from the knee, measured by both sensors over a walk.

Gravity does not determine the heading of a sensor about the long axis of its segment. A heading
error rotates the assumed flexion axis of the knee, and part of the knee's 60 degrees of flexion
then appears as abduction (cross-talk). Baker et al. (Hum Mov Sci 18:655, 1999) rotate the thigh to
minimise the variance of knee abduction over the walk; here both thigh and shank are rotated, since
each sensor has a heading of its own, and the previous calibration enters with its uncertainty.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from narx.calibration.axes import walking_band
from narx.calibration.functional import leg_of
from narx.calibration.static_bias import static_bias
from narx.errors import RecordingError
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.rotations import compose
from narx.kinematics.segment_angles import clinical_rates
from narx.kinematics.strapdown import strapdown_orientation
from narx.recordings.trial import Trial, side_of
from narx.types import BoolArray, FloatArray

# root mean square of knee abduction over a stride: the order of magnitude measured with bone pins
# (Lafortune et al., J Biomech 25:347, 1992: 5 degrees from stance to swing)
ABDUCTION_DEG = 2.0
# shortest walk, s: two slow strides
_MIN_WALK_S = 3.0
# longest part of the walk that is used, s: many strides, with a drift below a degree or two
_MAX_WALK_S = 60.0
# longest time between the calibration posture and the start of the walk, s
_MAX_WAIT_S = 5.0
# walking is below 10 Hz
_RATE_HZ = 50.0

# (trial, segment) to the frame of a sensor and a description of the method
FrameFinder = Callable[[Trial, str], tuple[Rotation, str]]


def turned_by_knee(
    trial: Trial,
    segment: str,
    find: FrameFinder,
    heading_sd_deg: tuple[float, float],
) -> tuple[Rotation, str]:
    """Determine a frame, and rotate it about z to minimise knee abduction.

    Parameters
    ----------
    trial : Trial
        As from a source.
    segment : str
        Which sensor.
    find : callable
        ``find(trial, segment)`` returns the initial frame and a description of the method.
    heading_sd_deg : tuple of (float, float)
        Standard deviation of the error of such frames about z, thigh and shank, degrees.

    Returns
    -------
    sensor_to_anatomical : Rotation
        Maps vectors in the sensor frame to the anatomical frame.
    how : str
        Method used, as text.

    Raises
    ------
    RecordingError
        As raised by `find`.

    Notes
    -----
    The frame is unchanged without a sensor on the other segment of the leg, or without three
    seconds of walking without gaps that start in the calibration posture.
    """
    frame, how = find(trial, segment)
    turn_rad = _turn_rad(trial, segment, frame, find, heading_sd_deg)
    if turn_rad is None:
        return frame, how
    mirror = -1.0 if side_of(segment) == "left" else 1.0
    return Rotation.from_rotvec([0.0, 0.0, mirror * turn_rad]) * frame, (
        f"{how}; rotated by {np.degrees(turn_rad):.1f} deg about z to minimise knee abduction"
    )


def _turn_rad(
    trial: Trial,
    segment: str,
    own: Rotation,
    find: FrameFinder,
    heading_sd_deg: tuple[float, float],
) -> float | None:
    leg = leg_of(segment)
    if segment not in leg or not all(name in trial.imus for name in leg):
        return None
    rates = []
    for name in leg:
        still = static_bias(trial, name)
        bias = np.zeros(3) if still is None else still.bias_rad_s
        try:
            frame = own if name == segment else find(trial, name)[0]
        except RecordingError:
            # a leg whose other sensor has no usable data is treated like one without it
            return None
        rate = frame.apply(trial.imus[name].gyroscope_rad_s - bias)
        rates.append(clinical_rates(rate, side_of(name)))
    steps = _first_steps(trial, np.asarray(np.isfinite(np.hstack(rates)).all(axis=1)))
    if steps.size < _MIN_WALK_S * trial.sampling_rate_hz:
        return None
    thigh, shank = (rate[steps] for rate in rates)
    turns = knee_headings(thigh, shank, trial.sampling_rate_hz, heading_sd_deg)
    return float(turns[leg.index(segment)])


def _first_steps(trial: Trial, valid: BoolArray) -> NDArray[np.intp]:
    """Select the walk from the calibration posture to the first gap."""
    time = trial.time_s
    begin, end = trial.walking_s or (time[0], time[-1])
    if trial.still_s:
        posture_s = trial.still_s[0][1]
    elif trial.starts_in_calibration_posture:
        posture_s = time[0]
    else:
        return np.arange(0)
    if not begin - _MAX_WAIT_S <= posture_s < end:
        return np.arange(0)
    samples = np.flatnonzero(
        (time >= posture_s) & (time <= min(end, max(begin, posture_s) + _MAX_WALK_S))
    )
    gaps = np.flatnonzero(~valid[samples])
    return samples[: gaps[0]] if gaps.size else samples


def knee_headings(
    thigh_rad_s: FloatArray,
    shank_rad_s: FloatArray,
    sampling_rate_hz: float,
    heading_sd_deg: tuple[float, float],
) -> FloatArray:
    """Find the rotations of thigh and shank about z that minimise knee abduction.

    Parameters
    ----------
    thigh_rad_s, shank_rad_s : ndarray, shape (N, 3)
        Rates about the clinical axes (`narx.kinematics.segment_angles.axis_rates`) in the initial
        frames, without bias and without a gap, rad/s, of a walk that starts in the calibration
        posture.
    sampling_rate_hz : float
        Samples per second.
    heading_sd_deg : tuple of (float, float)
        Standard deviation of the heading errors of the initial frames of thigh and shank, degrees.

    Returns
    -------
    ndarray, shape (2,)
        Rotations about z of the (mirrored) anatomical frames of thigh and shank, rad: vectors in
        the improved frame are those in the initial frame, rotated by this.

    Notes
    -----
    Least squares: the knee's abduction at 0.5-10 Hz against `ABDUCTION_DEG`, the whole walk
    counting as one observation since its strides are alike, and both rotations against
    `heading_sd_deg`. The latter preserves true abduction that accompanies flexion, and prevents
    large rotations of thigh and shank that nearly cancel each other.
    """
    every = max(1, int(sampling_rate_hz / _RATE_HZ))
    thigh, shank = (
        _integrated(rates, sampling_rate_hz)[::every] for rates in (thigh_rad_s, shank_rad_s)
    )

    def residual(turns_rad: FloatArray) -> FloatArray:
        knee = grood_suntay(
            *(
                # the calibration posture is zero in any frame, so the rotation acts on both sides
                compose(turn, orientation, turn.inv()).as_quat(scalar_first=True)
                for turn, orientation in zip(
                    Rotation.from_euler("Z", turns_rad[:, None]), (thigh, shank), strict=True
                )
            )
        )
        abduction = np.degrees(walking_band(knee[:, 1:2], sampling_rate_hz / every)[:, 0])
        return np.concatenate(
            [
                abduction / (ABDUCTION_DEG * np.sqrt(len(abduction))),
                np.degrees(turns_rad) / heading_sd_deg,
            ]
        )

    return np.asarray(least_squares(residual, np.zeros(2), diff_step=1e-3, x_scale=0.1).x)


def _integrated(axis_rates_rad_s: FloatArray, sampling_rate_hz: float) -> Rotation:
    """Orientation from the gyroscope alone, starting at zero."""
    mean_rates = 0.5 * (axis_rates_rad_s[1:] + axis_rates_rad_s[:-1])
    quaternions = strapdown_orientation(mean_rates, 1.0 / sampling_rate_hz, np.zeros(3))
    return Rotation.from_quat(quaternions, scalar_first=True)
