"""Processing of recordings with an optically tracked sensor: one clock, one frame, no spikes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.recordings.clock_alignment import estimate_clock_offset, estimate_misalignment
from narx.recordings.resampling import resample_quaternions, resample_vectors, uniform_clock
from narx.recordings.trial import ImuRecording, ReferenceOrientation
from narx.types import FloatArray

# the body cannot turn faster than its gyroscope measures: beyond this factor it is a tracking fault
_SPIKE_FACTOR = 2.0
_SPIKE_MAX_S = 0.2


@dataclass(frozen=True)
class RawSensor:
    """A sensor as published: two tables on the inertial clock, and the body tracked with it.

    Parameters
    ----------
    gyroscope : ndarray, shape (N, 4)
        Time in s, then x, y, z in rad/s.
    accelerometer : ndarray, shape (M, 4)
        Time in s, then specific force x, y, z in m/s^2.
    static_bias_rad_s : ndarray, shape (3,)
        Gyroscope bias, removed for the alignment only, rad/s.
    optical_time_s : ndarray, shape (K,)
        The reference's clock, s.
    body_wxyz : ndarray, shape (K, 4)
        Orientation of the tracked body in the global frame; NaN where missing.
    """

    gyroscope: FloatArray
    accelerometer: FloatArray
    static_bias_rad_s: FloatArray
    optical_time_s: FloatArray
    body_wxyz: FloatArray


@dataclass(frozen=True)
class AlignedSensors:
    """Sensors and references on one uniform clock, the inertial one.

    Parameters
    ----------
    imus : dict of str to ImuRecording
        By segment.
    reference : dict of str to ReferenceOrientation
        By segment, in the sensor frame.
    clock_offset_s : dict of str to float
        Lag of the inertial clock behind the optical one, s.
    notes : tuple of str
        Processing applied, as text.
    """

    imus: dict[str, ImuRecording]
    reference: dict[str, ReferenceOrientation]
    clock_offset_s: dict[str, float]
    notes: tuple[str, ...]


def align_sensors(
    sensors: Mapping[str, RawSensor],
    sampling_rate_hz: float,
    *,
    max_gap_s: float,
    max_optical_gap_s: float,
) -> AlignedSensors:
    """Align tracked sensors that share one inertial clock with their optical reference.

    Parameters
    ----------
    sensors : mapping of str to RawSensor
        By segment.
    sampling_rate_hz : float
        Rate of the uniform clock, Hz.
    max_gap_s, max_optical_gap_s : float
        Longest interval that is interpolated across, inertial and optical, s.

    Returns
    -------
    AlignedSensors
        The inertial clock is kept and the reference shifted to it, by one offset for all.

    Raises
    ------
    RecordingError
        If the recordings do not overlap or do not show the same motion.
    """
    notes = []
    bodies, offsets = {}, []
    for segment, sensor in sensors.items():
        rate = sensor.gyroscope[:, 1:] - sensor.static_bias_rad_s
        body, removed = without_spikes(
            sensor.optical_time_s, sensor.body_wxyz, float(np.nanmax(np.linalg.norm(rate, axis=1)))
        )
        if removed:
            notes.append(f"{segment}: {removed} optical samples are tracking faults, taken out")
        offset, agreement = estimate_clock_offset(
            sensor.gyroscope[:, 0], rate, sensor.optical_time_s, body
        )
        notes.append(
            f"{segment}: inertial clock {offset * 1e3:.1f} ms behind the optical one "
            f"(correlation of angular speeds {agreement:.3f})"
        )
        bodies[segment] = body
        offsets.append(offset)
    shared = float(np.mean(offsets))
    if len(offsets) > 1:
        notes.append(f"one clock offset for all sensors, {shared * 1e3:.1f} ms")
    tables = [
        table[:, 0]
        for sensor in sensors.values()
        for table in (sensor.gyroscope, sensor.accelerometer)
    ] + [sensor.optical_time_s + shared for sensor in sensors.values()]
    clock = uniform_clock(
        max(time[0] for time in tables), min(time[-1] for time in tables), sampling_rate_hz
    )
    imus, reference = {}, {}
    for segment, sensor in sensors.items():
        found = estimate_misalignment(
            sensor.gyroscope[:, 0],
            sensor.gyroscope[:, 1:] - sensor.static_bias_rad_s,
            sensor.optical_time_s,
            bodies[segment],
            offset_s=shared,
        )
        notes.append(
            f"{segment}: tracked body is {np.degrees(found.body_to_sensor.magnitude()):.1f} deg "
            "from the sensor, removed by Kabsch on angular rates; residual "
            f"{np.degrees(found.residual_rad_s):.1f} deg/s RMS an axis over "
            f"{found.inlier_share:.0%} of the samples"
        )
        imus[segment] = on_clock(
            segment, sensor.gyroscope, sensor.accelerometer, clock, max_gap_s=max_gap_s
        )
        in_sensor_frame = turn_frame(bodies[segment], found.body_to_sensor)
        reference[segment] = ReferenceOrientation(
            segment,
            resample_quaternions(
                sensor.optical_time_s + shared, in_sensor_frame, clock, max_gap_s=max_optical_gap_s
            ),
            "sensor",
        )
    return AlignedSensors(imus, reference, dict.fromkeys(sensors, shared), tuple(notes))


def without_spikes(
    time_s: FloatArray, quaternion_wxyz: FloatArray, fastest_rad_s: float
) -> tuple[FloatArray, int]:
    """Remove tracking faults from an orientation.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    quaternion_wxyz : ndarray, shape (N, 4)
        Orientation; NaN where missing.
    fastest_rad_s : float
        Highest rate of the gyroscope, rad/s.

    Returns
    -------
    quaternion_wxyz : ndarray, shape (N, 4)
        A copy with NaN where samples lie between two jumps (turns faster than twice the
        gyroscope's fastest) less than 0.2 s apart.
    removed : int
        Number of samples removed.
    """
    cleaned = quaternion_wxyz.copy()
    valid = np.flatnonzero(np.isfinite(cleaned).all(axis=1))
    if valid.size < 2:
        return cleaned, 0
    rotation = Rotation.from_quat(cleaned[valid], scalar_first=True)
    interval = np.diff(time_s[valid])
    speed = (rotation[:-1].inv() * rotation[1:]).magnitude() / interval
    runs = np.split(valid, np.flatnonzero(speed > _SPIKE_FACTOR * fastest_rad_s) + 1)
    if len(runs) == 1:
        return cleaned, 0
    short = [run for run in runs if time_s[run[-1]] - time_s[run[0]] < _SPIKE_MAX_S]
    for run in short:
        cleaned[run] = np.nan
    return cleaned, sum(run.size for run in short)


def turn_frame(body_wxyz: FloatArray, body_to_sensor: Rotation) -> FloatArray:
    """Convert the orientation of a body to that of a sensor fixed to it.

    Parameters
    ----------
    body_wxyz : ndarray, shape (N, 4)
        Body to global; NaN where missing.
    body_to_sensor : Rotation
        Maps body vectors to sensor vectors.

    Returns
    -------
    ndarray, shape (N, 4)
        Sensor to global; NaN where missing.
    """
    sensor = np.full_like(body_wxyz, np.nan)
    valid = np.isfinite(body_wxyz).all(axis=1)
    if valid.any():
        body = Rotation.from_quat(body_wxyz[valid], scalar_first=True)
        sensor[valid] = (body * body_to_sensor.inv()).as_quat(scalar_first=True)
    return sensor


def on_clock(
    segment: str,
    gyroscope: FloatArray,
    accelerometer: FloatArray,
    clock: FloatArray,
    *,
    max_gap_s: float,
) -> ImuRecording:
    """Resample the two tables of a sensor onto one clock.

    Parameters
    ----------
    segment : str
        Name of the segment.
    gyroscope, accelerometer : ndarray, shape (N, 4)
        Time in s, then x, y, z in SI.
    clock : ndarray, shape (M,)
        Uniform clock, s.
    max_gap_s : float
        Longest interval that is interpolated across, s.

    Returns
    -------
    ImuRecording
        On the uniform clock; NaN in gaps.
    """
    return ImuRecording(
        segment,
        clock,
        resample_vectors(gyroscope[:, 0], gyroscope[:, 1:], clock, max_gap_s=max_gap_s),
        resample_vectors(accelerometer[:, 0], accelerometer[:, 1:], clock, max_gap_s=max_gap_s),
    )
