"""Calibrated signals and reference angles of each segment from a recorded trial."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from narx.calibration.axes import frame_from_gravity, up_from_gravity
from narx.calibration.functional import (
    MOVEMENT,
    functional_frame,
    has_own_movement,
    has_whole_leg,
    leg_frame,
    standing_force,
)
from narx.calibration.knee import FrameFinder, turned_by_knee
from narx.calibration.reference import anatomical_reference, rest_heading_rad
from narx.calibration.static_bias import static_bias
from narx.calibration.walking import walking_frame
from narx.kinematics.rate_unit import warn_of_degrees
from narx.kinematics.segment_angles import (
    TRANSVERSE,
    angles_from_orientation,
    clinical_rates,
    mirror_vector,
)
from narx.method import SegmentSignals
from narx.recordings.trial import Trial, kind_of, side_of
from narx.settings import Flag, checked
from narx.types import FloatArray

Mode = Literal["auto", "leg", "knee", "functional", "walking", "sensor"]


# heading errors left by the calibration movements, thigh and shank (docs/recordings.md)
LEG_HEADING_SD_DEG = (5.0, 2.0)

# note of a segment whose bias was left
BIAS_UNKNOWN = "static gyroscope bias unknown, not removed"


@dataclass(frozen=True)
class CalibratedSegment:
    """Calibrated signals and reference of one segment: the input of every method.

    Parameters
    ----------
    signals : SegmentSignals
        Input of a method: rates about the clinical axes and specific force in the
        anatomical frame, left leg mirrored, static bias removed.
    reference_wxyz : ndarray, shape (N, 4), or None
        Orientation of the anatomical frame in the global frame (left leg mirrored), relative to
        the calibration posture; NaN where missing. None without a reference.
    reference_angles_rad : ndarray, shape (N, 3), or None
        The three angles of `reference_wxyz`; transverse is NaN unless the walk is straight.
    sensor_to_anatomical : Rotation
        Maps vectors in the sensor frame to the (not mirrored) anatomical frame.
    static_bias_rad_s : ndarray, shape (3,)
        Gyroscope bias that was subtracted, in the sensor frame, rad/s.
    notes : tuple of str
        Processing applied, as text.
    """

    signals: SegmentSignals
    reference_wxyz: FloatArray | None
    reference_angles_rad: FloatArray | None
    sensor_to_anatomical: Rotation
    static_bias_rad_s: FloatArray
    notes: tuple[str, ...]


@checked
def calibrate(
    trial: Trial, mode: Mode = "auto", *, remove_heading_misalignment: Flag = False
) -> dict[str, CalibratedSegment]:
    """Calibrate all segments of a trial.

    Parameters
    ----------
    trial : Trial
        Trial from a source.
    mode : {"auto", "leg", "knee", "functional", "walking", "sensor"}
        ``functional``: gravity in standing gives z; hip abduction gives x of a thigh, passive
        knee flexion y of a shank (Tham et al., II-A). ``leg``: the same movements, each measured by
        both sensors of the leg (`narx.calibration.functional.leg_frame`). ``knee``: ``leg``,
        rotated about z to minimise knee abduction in walking (`narx.calibration.knee`).
        ``walking``: gravity (in standing if the trial contains it, otherwise over the walk) and the
        principal horizontal axis of the walking gyroscope as y, rotated in the same way if the
        leg has both sensors. ``sensor``: the sensor frame, with the smallest rotation that makes z
        vertical at rest (or over the first second), for segments other than the leg; if the
        reference tracked the sensors, it gives a second sensor the heading of the first at rest,
        so that the joint between them starts at zero. ``auto``: knee, functional or walking, the
        first for which the trial has the recordings; sensor for other segments.
    remove_heading_misalignment : bool
        Whether the constant angle about the vertical between an anatomical reference frame
        (markers) and the calibrated sensor frame is removed; it is estimated from the angular
        rates of the whole trial. This excludes that part of the calibration error, which appears
        as cross-talk between the axes, from the comparison; the notes report it.

    Returns
    -------
    dict of str to CalibratedSegment
        By segment name.

    Raises
    ------
    UserError
        If the mode is unknown.
    RecordingError
        If the trial lacks recordings that the mode needs, or forward and backward cannot be
        distinguished in the walk.

    Notes
    -----
    The static bias is the mean of a ``still`` recording, or else of all standing parts together
    (`narx.calibration.static_bias.static_bias`); without either it is not removed, which the notes
    report.

    Reference: its tilt is relative to gravity. An anatomical reference is made upright in the
    calibration posture, where the trial contains it (its still parts, or its first sample);
    one that tracked the sensor needs no such step, since the sensor's calibration gives it the same
    anatomical frame. The heading of the calibration posture is removed, so the transverse angle
    starts at zero; where the trial does not contain the posture, a straight walk keeps its heading
    (the global x axis is then the direction of the walk, by the source's contract), and any other
    walk has the heading of the first valid sample removed.
    """
    return {
        segment: _calibrate_segment(trial, segment, mode, remove_heading_misalignment)
        for segment in trial.imus
    }


def _calibrate_segment(
    trial: Trial, segment: str, mode: Mode, remove_heading_misalignment: bool
) -> CalibratedSegment:
    warn_of_degrees(trial.imus[segment].gyroscope_rad_s, f"{trial.name}/{segment}")
    still = static_bias(trial, segment)
    bias = np.zeros(3) if still is None else still.bias_rad_s
    notes = [
        BIAS_UNKNOWN
        if still is None
        else f"static gyroscope bias {np.degrees(bias).round(2).tolist()} deg/s "
        f"from {still.where} removed"
    ]
    chosen = _available_mode(trial, segment) if mode == "auto" else mode
    to_anatomical, how = _FIND[chosen](trial, segment)
    notes.append(how)

    signals = signals_in_frame(trial, segment, to_anatomical, bias)
    orientation: FloatArray | None = None
    angles: FloatArray | None = None
    if segment in trial.reference:
        orientation, steps = anatomical_reference(
            trial,
            segment,
            to_anatomical,
            remove_heading_misalignment=remove_heading_misalignment,
        )
        angles = angles_from_orientation(orientation)
        if not trial.straight:
            angles[:, TRANSVERSE] = np.nan
        notes.extend(steps)
    return CalibratedSegment(signals, orientation, angles, to_anatomical, bias, tuple(notes))


def signals_in_frame(
    trial: Trial, segment: str, to_anatomical: Rotation, bias_rad_s: FloatArray
) -> SegmentSignals:
    """Convert a sensor's recording to the input of a method.

    Parameters
    ----------
    trial : Trial
        The trial.
    segment : str
        Which sensor.
    to_anatomical : Rotation
        Maps vectors in the sensor frame to the (not mirrored) anatomical frame.
    bias_rad_s : ndarray, shape (3,)
        Bias of the gyroscope in the sensor frame, rad/s.

    Returns
    -------
    SegmentSignals
        Bias removed, a left leg mirrored.
    """
    imu, side = trial.imus[segment], side_of(segment)
    force = to_anatomical.apply(imu.accelerometer_m_s2)
    return SegmentSignals(
        segment,
        trial.sampling_rate_hz,
        clinical_rates(to_anatomical.apply(imu.gyroscope_rad_s - bias_rad_s), side),
        mirror_vector(force) if side == "left" else force,
        np.zeros(3) if trial.starts_in_calibration_posture else None,
    )


def _knee(trial: Trial, segment: str) -> tuple[Rotation, str]:
    return turned_by_knee(trial, segment, leg_frame, LEG_HEADING_SD_DEG)


def _available_mode(trial: Trial, segment: str) -> Mode:
    """Choose the first mode for which the trial has the recordings."""
    if kind_of(segment) not in MOVEMENT:
        return "sensor"
    if has_whole_leg(trial, segment):
        return "knee"
    return "functional" if has_own_movement(trial, segment) else "walking"


def _upright_sensor(trial: Trial, segment: str) -> tuple[Rotation, str]:
    standing = standing_force(trial, segment)
    if standing is not None:
        force, source = standing, "at rest"
    else:
        first = trial.imus[segment].accelerometer_m_s2[: max(1, int(trial.sampling_rate_hz))]
        force, source = first, "over the first second"
    frame = frame_from_gravity(up_from_gravity(force, f"{trial.name}, '{segment}'"))
    how = f"sensor frame, made upright by the smallest rotation {source}"
    first_segment = next(iter(trial.imus))
    if segment != first_segment:
        own_rad, first_rad = (
            rest_heading_rad(trial, s, f)
            for s, f in (
                (segment, frame),
                (first_segment, _upright_sensor(trial, first_segment)[0]),
            )
        )
        if own_rad is not None and first_rad is not None:
            frame = Rotation.from_euler("Z", own_rad - first_rad) * frame
            how += (
                f", then about the vertical to the heading of '{first_segment}' at rest, which "
                "only the reference provides"
            )
    return frame, how


_FIND: dict[Mode, FrameFinder] = {
    "leg": leg_frame,
    "knee": _knee,
    "functional": functional_frame,
    "walking": walking_frame,
    "sensor": _upright_sensor,
}
