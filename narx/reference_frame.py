"""The reference orientation of a segment, relative to the calibration posture."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from narx.clock_alignment import estimate_misalignment
from narx.recording import FloatArray, Trial, side_of
from narx.segment_angles import mirror_quaternion


def anatomical_reference(
    trial: Trial,
    segment: str,
    sensor_to_anatomical: Rotation,
    static_bias_rad_s: FloatArray,
    *,
    remove_mean_misalignment: bool = False,
) -> tuple[FloatArray, list[str]]:
    """Bring a trial's reference into the frame in which methods estimate.

    Parameters
    ----------
    trial : Trial
        With a reference of this segment.
    segment : str
        Which segment.
    sensor_to_anatomical : Rotation
        The sensor's calibration.
    static_bias_rad_s : ndarray, shape (3,)
        Gyroscope bias in the sensor frame, rad/s.
    remove_mean_misalignment : bool
        Whether the constant rotation between an anatomical reference and the calibrated sensor
        is removed (see `narx.calibration.calibrate`).

    Returns
    -------
    quaternion_wxyz : ndarray, shape (N, 4)
        Orientation of the anatomical frame (left leg mirrored), upright and with zero heading in
        the calibration posture; NaN where missing.
    notes : list of str
        What was done, for people.
    """
    reference = trial.reference[segment]
    quaternion = reference.quaternion_wxyz
    there = np.asarray(np.isfinite(quaternion).all(axis=1))
    result = np.full_like(quaternion, np.nan)
    notes: list[str] = []
    if not there.any():
        return result, [f"reference of '{segment}' is missing throughout"]
    orientation = Rotation.from_quat(quaternion[there], scalar_first=True)
    posture = _posture(trial, there)
    if reference.frame == "sensor":
        orientation = orientation * sensor_to_anatomical.inv()
        notes.append("reference tracked the sensor: the sensor's calibration applies to it")
    else:
        if posture is not None:
            mean = orientation[posture].mean()
            orientation = orientation * mean.inv() * _turn_about_vertical(_heading_rad(mean))
            notes.append("anatomical reference made upright in the calibration posture")
        if remove_mean_misalignment:
            imu = trial.imus[segment]
            found = estimate_misalignment(
                imu.time_s,
                sensor_to_anatomical.apply(imu.gyroscope_rad_s - static_bias_rad_s),
                imu.time_s[there],
                orientation.as_quat(scalar_first=True),
            )
            orientation = orientation * found.body_to_sensor.inv()
            notes.append(
                "constant misalignment of "
                f"{np.degrees(found.body_to_sensor.magnitude()):.1f} deg between reference and "
                "calibrated sensor removed"
            )
    if posture is not None:
        orientation = _turn_about_vertical(-_heading_rad(orientation[posture].mean())) * orientation
        notes.append("heading of the calibration posture removed")
    elif not trial.straight:
        orientation = _turn_about_vertical(-_heading_rad(orientation[0])) * orientation
        notes.append("heading of the first sample removed")
    result[there] = orientation.as_quat(scalar_first=True)
    return (mirror_quaternion(result) if side_of(segment) == "left" else result), notes


def _posture(trial: Trial, there: NDArray[np.bool_]) -> NDArray[np.bool_] | slice | None:
    """Tell which of the samples that are there show the calibration posture."""
    if trial.still_s:
        time = trial.time_s[there]
        begin, end = trial.still_s[0]
        inside = (time >= begin) & (time <= end)
        if inside.any():
            return np.asarray(inside)
    if trial.starts_in_calibration_posture and there[0]:
        return slice(0, 1)
    return None


def _heading_rad(orientation: Rotation) -> float:
    """Heading in the sequence that `narx.segment_angles` decomposes with."""
    return float(orientation.as_euler("ZXY")[0])


def _turn_about_vertical(angle_rad: float) -> Rotation:
    return Rotation.from_euler("Z", angle_rad)
