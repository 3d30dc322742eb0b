"""The reference orientation of a segment, relative to the calibration posture."""

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose
from narx.kinematics.segment_angles import mirror_quaternion
from narx.recordings.clock_alignment import estimate_heading_misalignment
from narx.recordings.trial import Trial, side_of
from narx.types import BoolArray, FloatArray


def anatomical_reference(
    trial: Trial,
    segment: str,
    sensor_to_anatomical: Rotation,
    *,
    remove_heading_misalignment: bool = False,
) -> tuple[FloatArray, list[str]]:
    """Express a trial's reference in the frame of the methods' estimates.

    Parameters
    ----------
    trial : Trial
        Trial with a reference of this segment.
    segment : str
        Name of the segment.
    sensor_to_anatomical : Rotation
        The sensor's calibration.
    remove_heading_misalignment : bool
        Whether the constant angle about the vertical between an anatomical reference and the
        calibrated sensor is removed (see `narx.calibration.calibrate.calibrate`).

    Returns
    -------
    quaternion_wxyz : ndarray, shape (N, 4)
        Orientation of the anatomical frame (left leg mirrored), upright and with zero heading in
        the calibration posture; NaN where missing.
    notes : list of str
        Processing applied, as text.
    """
    reference = trial.reference[segment]
    quaternion = reference.quaternion_wxyz
    valid = np.asarray(np.isfinite(quaternion).all(axis=1))
    result = np.full_like(quaternion, np.nan)
    notes: list[str] = []
    if not valid.any():
        return result, [f"reference of '{segment}' has no valid sample"]
    orientation = Rotation.from_quat(quaternion[valid], scalar_first=True)
    posture = _posture(trial, valid)
    if reference.frame == "sensor":
        orientation = compose(orientation, sensor_to_anatomical.inv())
        notes.append("reference tracked the sensor: the sensor's calibration applies to it")
    else:
        if posture is not None:
            mean = orientation[posture].mean()
            upright = mean.inv() * _turn_about_vertical(_heading_rad(mean))
            orientation = compose(orientation, upright)
            notes.append("anatomical reference made upright in the calibration posture")
        if remove_heading_misalignment:
            imu = trial.imus[segment]
            angle = estimate_heading_misalignment(
                imu.time_s,
                # a constant bias does not matter
                sensor_to_anatomical.apply(imu.gyroscope_rad_s),
                imu.time_s[valid],
                orientation.as_quat(scalar_first=True),
            )
            orientation = compose(orientation, _turn_about_vertical(-angle))
            notes.append(
                f"{np.degrees(angle):.1f} deg about the vertical between reference and calibrated "
                "sensor removed"
            )
    if posture is not None:
        heading = _heading_rad(orientation[posture].mean())
        orientation = compose(_turn_about_vertical(-heading), orientation)
        notes.append("heading of the calibration posture removed")
    elif not trial.straight:
        orientation = compose(_turn_about_vertical(-_heading_rad(orientation[0])), orientation)
        notes.append("heading of the first sample removed")
    result[valid] = orientation.as_quat(scalar_first=True)
    return (mirror_quaternion(result) if side_of(segment) == "left" else result), notes


def rest_heading_rad(trial: Trial, segment: str, sensor_to_upright: Rotation) -> float | None:
    """Return the heading of a tracked sensor in the calibration posture.

    Parameters
    ----------
    trial : Trial
        As from a source.
    segment : str
        Which sensor.
    sensor_to_upright : Rotation
        Frame whose heading is returned.

    Returns
    -------
    float or None
        Heading in the reference's global frame, rad; None where the reference did not track the
        sensor or the trial does not contain the posture.
    """
    reference = trial.reference.get(segment)
    if reference is None or reference.frame != "sensor":
        return None
    valid = np.asarray(np.isfinite(reference.quaternion_wxyz).all(axis=1))
    if not valid.any() or (posture := _posture(trial, valid)) is None:
        return None
    sensor = Rotation.from_quat(reference.quaternion_wxyz[valid], scalar_first=True)[posture]
    return _heading_rad(sensor.mean() * sensor_to_upright.inv())


def _posture(trial: Trial, valid: BoolArray) -> BoolArray | slice | None:
    """Select the valid samples in the calibration posture."""
    if trial.still_s:
        time = trial.time_s[valid]
        begin, end = trial.still_s[0]
        inside = (time >= begin) & (time <= end)
        if inside.any():
            return np.asarray(inside)
    if trial.starts_in_calibration_posture and valid[0]:
        return slice(0, 1)
    return None


def _heading_rad(orientation: Rotation) -> float:
    """Heading in the rotation sequence of `narx.kinematics.segment_angles`."""
    return float(orientation.as_euler("ZXY")[0])


def _turn_about_vertical(angle_rad: float) -> Rotation:
    return Rotation.from_euler("Z", angle_rad)
