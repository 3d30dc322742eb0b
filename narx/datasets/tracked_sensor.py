"""Processing of recordings with an optically tracked sensor: one clock, one frame, no spikes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.datasets.tracking_faults import tracked_poses, without_spikes
from narx.errors import RecordingError
from narx.recordings.clock_alignment import (
    Misalignment,
    estimate_clock_offset,
    estimate_misalignment,
)
from narx.recordings.resampling import resample_quaternions, resample_vectors, uniform_clock
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, ReferenceOrientation
from narx.types import FloatArray

# agreement of sensor and tracked body: published recordings have slopes of 0.9 to 1.1
_SLOPES = (0.5, 2.0)
_MIN_EXPLAINED = 0.5
# a reflection leaves less unexplained than any rotation, by this factor
_MIRRORED = 2.5
# mean specific force from the global z axis: 0.4 to 1.6 degrees in published recordings
_MAX_TILT_RAD = np.radians(15.0)
# of gravity, the mean specific force along that axis: 0.98 to 1.01 in published joints
_MIN_VERTICAL = 0.8


@dataclass(frozen=True)
class RawSensor:
    """A published recording: two tables on the inertial clock, and the tracked body.

    Parameters
    ----------
    gyroscope : ndarray, shape (N, 4)
        Time in s, then x, y, z in rad/s.
    accelerometer : ndarray, shape (M, 4)
        Time in s, then specific force x, y, z in m/s^2.
    static_bias_rad_s : ndarray, shape (3,)
        Gyroscope bias, removed for the alignment of the clocks only, rad/s.
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
    where: str = "",
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
    where : str
        File, for messages; a caller that adds it itself leaves it out.

    Returns
    -------
    AlignedSensors
        The inertial clock is kept and the reference shifted to it, by one offset for all.

    Raises
    ------
    RecordingError
        If the recordings do not overlap or do not show the same motion, sensor and reference
        contradict each other, or z of the reference is not up; the message names the file and the
        segment.
    """
    try:
        return _aligned(sensors, sampling_rate_hz, max_gap_s, max_optical_gap_s)
    except RecordingError as error:
        if not where:
            raise
        raise RecordingError(f"{where}: {error}") from error


def _aligned(
    sensors: Mapping[str, RawSensor],
    sampling_rate_hz: float,
    max_gap_s: float,
    max_optical_gap_s: float,
) -> AlignedSensors:
    notes = []
    bodies, offsets = {}, []
    for segment, sensor in sensors.items():
        rate = sensor.gyroscope[:, 1:] - sensor.static_bias_rad_s
        tracked, lost = tracked_poses(segment, sensor.optical_time_s, sensor.body_wxyz)
        notes += lost
        speed = np.linalg.norm(rate, axis=1)
        if not np.isfinite(speed).any():
            raise RecordingError(f"'{segment}': no sample of the gyroscope has all three axes")
        body, removed = without_spikes(sensor.optical_time_s, tracked, float(np.nanmax(speed)))
        if removed:
            notes.append(f"{segment}: {removed} optical samples are tracking faults, taken out")
        try:
            offset, agreement = estimate_clock_offset(
                sensor.gyroscope[:, 0], rate, sensor.optical_time_s, body
            )
        except RecordingError as error:
            raise RecordingError(f"'{segment}': {error}") from error
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
            sensor.gyroscope[:, 1:],
            sensor.optical_time_s,
            bodies[segment],
            offset_s=shared,
        )
        refuse_contradiction(segment, found)
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
        refuse_tilted(imus[segment], reference[segment])
    return AlignedSensors(imus, reference, dict.fromkeys(sensors, shared), tuple(notes))


def refuse_contradiction(
    segment: str, found: Misalignment, *, mirrored_factor: float = _MIRRORED
) -> None:
    """Refuse a sensor and a body that no constant rotation brings together.

    Parameters
    ----------
    segment : str
        Its name, for messages.
    found : Misalignment
        Fit of the rates of both.
    mirrored_factor : float
        A reflection that leaves less unexplained than the rotation by this factor is refused.

    Raises
    ------
    RecordingError
        If rotation and slope explain too little, a reflection explains more, or the slope is
        that of another unit.
    """
    mirrored = 1.0 - found.explained > mirrored_factor * (1.0 - found.explained_mirrored)
    if found.explained < _MIN_EXPLAINED or mirrored:
        raise RecordingError(
            f"'{segment}': the gyroscope does not turn as its reference does (a constant rotation "
            f"explains {found.explained:.0%} and leaves "
            f"{np.degrees(found.residual_rad_s):.0f} deg/s): exchanged or mirrored axes, exchanged "
            "sensors, or conjugate quaternions?"
        )
    if not _SLOPES[0] < found.slope < _SLOPES[1]:
        guess = "; deg/s in a column of rad/s?" if 20 < found.slope < 200 else ""
        raise RecordingError(
            f"'{segment}': the gyroscope turns {found.slope:.3g} times as fast as its "
            f"reference{guess}"
        )


def refuse_tilted(imu: ImuRecording, reference: ReferenceOrientation) -> None:
    """Refuse a reference whose global z axis is not up, according to the mean specific force.

    Rates alone do not show conjugate quaternions or axes in another order if the motion is about
    one axis: they are then the same motion, seen from a frame that is turned.

    Parameters
    ----------
    imu : ImuRecording
        The sensor.
    reference : ReferenceOrientation
        Orientation of the sensor's own frame, on the same clock.

    Raises
    ------
    RecordingError
        If the mean specific force in the global frame is not gravity along z.
    """
    turned, force = reference.quaternion_wxyz, imu.accelerometer_m_s2
    valid = np.isfinite(turned).all(axis=1) & np.isfinite(force).all(axis=1)
    if not valid.any():
        return
    mean = Rotation.from_quat(turned[valid], scalar_first=True).apply(force[valid]).mean(axis=0)
    tilt = np.arctan2(np.hypot(mean[0], mean[1]), mean[2])
    if tilt > _MAX_TILT_RAD:
        found = f"puts gravity {np.degrees(tilt):.0f} deg from z"
    elif mean[2] < _MIN_VERTICAL * GRAVITY_M_S2:
        # of a person who turns round, the horizontal part of a mistaken direction is zero
        found = f"leaves {mean[2]:.1f} of {GRAVITY_M_S2:.2f} m/s^2 of gravity along z"
    else:
        return
    raise RecordingError(
        f"the orientation of '{imu.segment}' {found}; "
        "expected a global frame with z up: axes in another order, or conjugate quaternions?"
    )


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
