"""Anatomical frames from calibration movements: segment by segment, or the whole leg together.

Gravity in standing gives z; what remains is the direction of y in the horizontal plane of the
sensor. It is perpendicular to the rotation axis of a hip abduction, and parallel to that of a
passive knee flexion (Tham et al. 2020, section II-A: one movement per segment). A leg that is
abducted with a straight knee moves as one rigid body, so both of its sensors measure the same axis
at the same time (Favre et al., J Biomech 41:1029, 2008, align two sensors with it).
"""

from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from narx.calibration.axes import (
    excursion_rad,
    frame_from_left,
    principal_horizontal_axis,
    up_from_gravity,
)
from narx.calibration.static_bias import static_bias
from narx.errors import RecordingError
from narx.recordings.trial import ImuRecording, Trial, kind_of, side_of
from narx.types import FloatArray

Movement = Literal["hip_abduction", "knee_flexion"]

# calibration movement of a body segment, as Tham et al. choose them
MOVEMENT: dict[str, Movement] = {"thigh": "hip_abduction", "shank": "knee_flexion"}
_MIN_EXCURSION_RAD = np.radians(3.0)


def standing_force(trial: Trial, segment: str) -> FloatArray | None:
    """Return the accelerometer in the calibration posture.

    Parameters
    ----------
    trial : Trial
        With a ``standing`` recording or `still_s`.
    segment : str
        Which sensor.

    Returns
    -------
    ndarray, shape (N, 3), or None
        Specific force in the sensor frame, m/s^2; None where the trial has no such part.
    """
    recording = trial.calibration.get("standing", {}).get(segment)
    if recording is not None:
        return recording.accelerometer_m_s2
    if not trial.still_s:
        return None
    begin, end = trial.still_s[0]
    inside = (trial.time_s >= begin) & (trial.time_s <= end)
    return trial.imus[segment].accelerometer_m_s2[inside]


def movement_recording(trial: Trial, segment: str, movement: Movement) -> ImuRecording | None:
    """Return the recording of a calibration movement of the segment's own leg.

    Parameters
    ----------
    trial : Trial
        As from a source.
    segment : str
        Which sensor.
    movement : {"hip_abduction", "knee_flexion"}
        Which movement.

    Returns
    -------
    ImuRecording or None
        None where the trial has no such recording.
    """
    side = side_of(segment)
    part = movement if side is None else f"{movement}_{side}"
    return trial.calibration.get(part, {}).get(segment)


def has_own_movement(trial: Trial, segment: str) -> bool:
    """Return whether the trial has the recordings for `functional_frame`.

    Parameters
    ----------
    trial : Trial
        As from a source.
    segment : str
        Which sensor.

    Returns
    -------
    bool
        Whether there is a standing part and the segment's own movement.
    """
    movement = MOVEMENT.get(kind_of(segment))
    return (
        movement is not None
        and movement_recording(trial, segment, movement) is not None
        and standing_force(trial, segment) is not None
    )


def has_whole_leg(trial: Trial, segment: str) -> bool:
    """Return whether the trial has the recordings for `leg_frame`.

    Parameters
    ----------
    trial : Trial
        As from a source.
    segment : str
        Which sensor, a thigh's or a shank's.

    Returns
    -------
    bool
        Whether both sensors of the leg have a standing part and an abduction, and the shank a
        flexion.
    """
    thigh, shank = leg_of(segment)
    return (
        has_own_movement(trial, thigh)
        and has_own_movement(trial, shank)
        and movement_recording(trial, shank, "hip_abduction") is not None
    )


def functional_frame(trial: Trial, segment: str) -> tuple[Rotation, str]:
    """Build the frame of one segment from its own movement (Tham et al. 2020, section II-A).

    Parameters
    ----------
    trial : Trial
        With a standing part, and hip abduction (thigh) or passive knee flexion (shank).
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
        If a part is missing or the movement is too small.
    """
    if not has_own_movement(trial, segment):
        lacking = (
            "standing part"
            if standing_force(trial, segment) is None
            else "hip abduction or knee flexion"
        )
        raise RecordingError(
            f"{trial.name}: no {lacking} of '{segment}' for functional calibration; "
            "calibration mode 'walking' does without"
        )
    up = _up(trial, segment)
    movement = MOVEMENT[kind_of(segment)]
    left = _left(trial, segment, movement, up)
    shown = "x hip abduction" if movement == "hip_abduction" else "y passive knee flexion"
    return frame_from_left(up, left), f"functional: z standing, {shown}"


def leg_frame(trial: Trial, segment: str) -> tuple[Rotation, str]:
    """Build the frame of one segment from all movements of its leg.

    Parameters
    ----------
    trial : Trial
        With a standing part, hip abduction with a straight knee and passive knee flexion.
    segment : str
        Which sensor, a thigh's or a shank's.

    Returns
    -------
    sensor_to_anatomical : Rotation
        Maps vectors in the sensor frame to the anatomical frame.
    how : str
        Method used, as text.

    Raises
    ------
    RecordingError
        If a part is missing or a movement is too small.

    Notes
    -----
    The shank takes part in both movements, and each gives an estimate of y. A leg is never abducted
    exactly sideways, nor a knee flexed exactly about one axis, and the two errors are independent:
    y of the shank is half way between the two. The correction to the abduction axis is an error of
    the leg's movement, so the thigh's axis is rotated by the same angle. Thigh and shank then agree
    about the movement that they made together, apart from the motion of the thigh's soft tissue.
    """
    if not has_whole_leg(trial, segment):
        raise RecordingError(
            f"{trial.name}: the leg of '{segment}' lacks a standing part, hip abduction or knee "
            "flexion of thigh and shank for calibration mode 'leg'; 'functional' needs one "
            "movement per segment"
        )
    thigh, shank = leg_of(segment)
    up = {name: _up(trial, name) for name in (thigh, shank)}
    abduction = _left(trial, shank, "hip_abduction", up[shank])
    flexion = _left(trial, shank, "knee_flexion", up[shank])
    apart_rad = float(np.arctan2(up[shank] @ np.cross(abduction, flexion), abduction @ flexion))
    left = _left(trial, segment, "hip_abduction", up[segment])
    left = Rotation.from_rotvec(0.5 * apart_rad * up[segment]).apply(left)
    return frame_from_left(up[segment], left), (
        "leg: z standing, y half way between hip abduction and passive knee flexion, which differ "
        f"by {np.degrees(apart_rad):.1f} deg about z"
    )


def leg_of(segment: str) -> tuple[str, str]:
    """Name the segments that meet in a knee.

    Parameters
    ----------
    segment : str
        Any segment of the leg.

    Returns
    -------
    tuple of (str, str)
        Thigh and shank of its side.
    """
    suffix = segment.removeprefix(kind_of(segment))
    return f"thigh{suffix}", f"shank{suffix}"


def _up(trial: Trial, segment: str) -> FloatArray:
    standing = standing_force(trial, segment)
    assert standing is not None  # callers have checked
    return up_from_gravity(standing, f"{trial.name}, standing, '{segment}'")


def _left(trial: Trial, segment: str, movement: Movement, up: FloatArray) -> FloatArray:
    """Direction of y in the sensor frame from one movement."""
    recording = movement_recording(trial, segment, movement)
    assert recording is not None  # callers have checked
    still = static_bias(trial, segment)
    rate = recording.gyroscope_rad_s - (0.0 if still is None else still.bias_rad_s)
    rate = rate[np.isfinite(rate).all(axis=1)]
    axis = principal_horizontal_axis(rate, up)
    abduction = movement == "hip_abduction"
    # the movement starts from the neutral posture: the leg is lifted to its own side, which is
    # about -x on the right and +x on the left; the dangling foot is swung forward, about -y
    positive = abduction and side_of(segment) == "left"
    angle = excursion_rad(rate, axis, recording.sampling_rate_hz)
    if abs(angle) < _MIN_EXCURSION_RAD:
        raise RecordingError(
            f"{trial.name}: calibration movement of '{segment}' leads {np.degrees(angle):.1f} deg "
            "away from the neutral posture on average, expected at least "
            f"{np.degrees(_MIN_EXCURSION_RAD):.0f} deg (begin in neutral, lift the leg outwards or "
            "swing the foot forwards)"
        )
    axis = axis if (angle > 0.0) == positive else -axis
    return np.cross(up, axis) if abduction else axis
