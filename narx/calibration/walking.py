"""Anatomical frames from walking alone, for recordings without calibration movements.

Gravity gives z, in standing or over the walk; the horizontal axis about which the sensor turns most
gives y; the swing of the leg gives its sign. With sensors on thigh and shank, the knee improves the
headings (`narx.calibration.knee`).
"""

import numpy as np
from scipy.spatial.transform import Rotation

from narx.calibration.axes import (
    MIN_WALK_S,
    frame_from_left,
    principal_horizontal_axis,
    swing_sign,
    up_from_gravity,
    walking_band,
)
from narx.calibration.functional import standing_force
from narx.calibration.knee import turned_by_knee
from narx.errors import RecordingError
from narx.recordings.trial import Trial
from narx.types import BoolArray, FloatArray

# heading errors of frames found from one sensor's walk, thigh and shank (docs/recordings.md)
HEADING_SD_DEG = (5.0, 10.0)
# three strides, fewer do not distinguish the forward swing
_SHORT_S = 3.0
# slower than any walk
_STILL_RAD_S = np.radians(5.0)


def walking_frame(trial: Trial, segment: str) -> tuple[Rotation, str]:
    """Build the frame of one segment from a walk.

    Parameters
    ----------
    trial : Trial
        With a walk of a thigh or a shank, or preferably of both.
    segment : str
        Which sensor.

    Returns
    -------
    sensor_to_anatomical : Rotation
        Maps vectors in the sensor frame to the anatomical frame.
    how : str
        Method used, as text.

    Raises
    ------
    RecordingError
        If the walk is too short, or does not distinguish forward from backward.
    """
    return turned_by_knee(trial, segment, _own_frame, HEADING_SD_DEG)


def _own_frame(trial: Trial, segment: str) -> tuple[Rotation, str]:
    standing = standing_force(trial, segment)
    force = trial.imus[segment].accelerometer_m_s2[_walking_samples(trial)]
    up = up_from_gravity(force if standing is None else standing, f"{trial.name}, '{segment}'")
    walk = _walk(trial, segment)
    if len(walk) < MIN_WALK_S * trial.sampling_rate_hz:
        raise RecordingError(
            f"{trial.name}: {len(walk) / trial.sampling_rate_hz:.1f} s of walking by "
            f"'{segment}' to calibrate from in a recording of "
            f"{trial.n_samples / trial.sampling_rate_hz:.2g} s, expected at least {MIN_WALK_S:g} s"
        )
    left = principal_horizontal_axis(walk, up)
    # what sways in standing may be faster forward than backward
    sign = swing_sign(walk, left) if _speed_rad_s(walk) >= _STILL_RAD_S else 0
    if sign == 0:
        raise RecordingError(f"{trial.name}: {_no_swing(walk, segment, trial.sampling_rate_hz)}")
    source = "mean specific force of the walk" if standing is None else "standing"
    return frame_from_left(up, sign * left), (
        f"walking: z from {source}, y from the principal horizontal axis at 0.5-10 Hz, "
        "sign from the forward swing"
    )


def _speed_rad_s(walk: FloatArray) -> float:
    return float(np.sqrt((walk**2).sum(axis=1).mean()))


def _no_swing(walk: FloatArray, segment: str, rate_hz: float) -> str:
    """Describe why forward and backward cannot be distinguished."""
    speed = _speed_rad_s(walk)
    if speed < _STILL_RAD_S:
        return (
            f"'{segment}' hardly turns ({np.degrees(speed):.2g} deg/s RMS), so there is no walk to "
            "calibrate from; is it walking?"
        )
    if len(walk) < _SHORT_S * rate_hz:
        return (
            f"{len(walk) / rate_hz:.1f} s of walking by '{segment}' are too short to distinguish "
            f"forward from backward, expected at least {_SHORT_S:g} s"
        )
    return (
        f"'{segment}' does not swing forward and back at different speeds, so forward and backward "
        "cannot be distinguished; is it walking?"
    )


def _walking_samples(trial: Trial) -> BoolArray:
    if trial.walking_s is None:
        return np.ones(trial.n_samples, dtype=bool)
    begin, end = trial.walking_s
    return np.asarray((trial.time_s >= begin) & (trial.time_s <= end))


def _walk(trial: Trial, segment: str) -> FloatArray:
    # filtered before it is cut, so that filter transients do not dominate a short walk; the band
    # leaves out a bias
    rate = walking_band(trial.imus[segment].gyroscope_rad_s, trial.sampling_rate_hz)
    walk = rate[_walking_samples(trial)]
    return walk[np.isfinite(walk).all(axis=1)]
