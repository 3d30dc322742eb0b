"""Segment and joint angles from several sensors of one session."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from narx.calibration.calibrate import BIAS_UNKNOWN, CalibratedSegment, Mode, calibrate
from narx.calibration.static_bias import static_bias
from narx.errors import RecordingError, UserError
from narx.gait.phases import gait_phases
from narx.gait.straight_walk import walk_before_turn_s
from narx.inference.bias import declared_rest, remove_static_bias
from narx.inference.filled_gaps import filled_gap_std_rad
from narx.inference.findings import (
    check_consistency,
    doubtful_note,
    exchanged_note,
    gap_notes,
    start_up_note,
)
from narx.inference.narx_method import NarxMethod
from narx.inference.predict import MAX_GAP_S
from narx.kinematics.joints import JOINTS, joint_between
from narx.kinematics.segment_angles import SAGITTAL
from narx.recordings.gaps import on_clock
from narx.recordings.plausibility import admit, check_gravity
from narx.recordings.resampling import uniform_clock
from narx.recordings.rest import first_rest_s
from narx.recordings.session_clock import Alignment, clock_offsets_s
from narx.recordings.trial import ImuRecording, Trial, kind_of, side_of
from narx.settings import Span, checked
from narx.types import FloatArray

SessionStart = Literal["auto", "known", "unknown"]

# shortest rest, s, that counts as standing
_MIN_REST_S = 0.5
# segments whose axes are found from walking; a pelvis keeps the heading of its sensor
_SWINGING = ("thigh", "shank")


@dataclass(frozen=True)
class SessionPrediction:
    """Angles of segments and joints on one uniform clock.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        The first sensor's clock, s.
    sampling_rate_hz : float
        Its rate.
    angles_rad : mapping of str to ndarray, shape (N, 3)
        Angles of the segments, then of the joints: sagittal (flexion +), frontal (abduction +) and
        transverse (internal rotation +), rad; NaN where missing.
    std_rad : mapping of str to ndarray, shape (N, 3)
        Predicted standard deviation of the error, rad, if the network provides it. In a joint, the
        variances of its two segments add up, which assumes that their errors are independent.
    quality : mapping of str to ndarray of int8, shape (N,)
        By segment, a `narx.inference.stream.Quality` for each sample.
    contacts_s : mapping of str to ndarray, shape (C,)
        Times of the foot contacts of each side on the same clock, detected on the thigh; empty
        without walking.
    notes : tuple of str
        Processing applied, as text.
    """

    time_s: FloatArray
    sampling_rate_hz: float
    angles_rad: Mapping[str, FloatArray]
    std_rad: Mapping[str, FloatArray]
    quality: Mapping[str, NDArray[np.int8]]
    contacts_s: Mapping[str, FloatArray]
    notes: tuple[str, ...]


@checked
def predict_session(
    recordings: Mapping[str, ImuRecording],
    method: NarxMethod,
    *,
    calibration: Mode = "auto",
    parts: Mapping[str, Mapping[str, ImuRecording]] | None = None,
    start_pose: SessionStart = "auto",
    still_s: Sequence[Span] | None = None,
    walking_s: Span | None = None,
    align: Alignment | Mapping[str, float] = "auto",
    where: str = "session",
) -> SessionPrediction:
    """Estimate the angles of a leg, or of both, from sensors worn together.

    Parameters
    ----------
    recordings : mapping of str to ImuRecording
        Recording of each segment: ``thigh_right``, ``shank_right``, ``foot_right``, the same for
        the left, ``pelvis``; each with an accelerometer, which gives the vertical.
    method : NarxMethod
        Trained network.
    calibration : {"auto", "leg", "knee", "functional", "walking", "sensor"}
        Calibration of thighs and shanks (`narx.calibration.calibrate`). A foot is calibrated by its
        swing in walking; for a pelvis only the vertical is aligned, the heading is the sensor's.
    parts : mapping of str to mapping of str to ImuRecording, optional
        Calibration recordings by part (``standing``, ``hip_abduction_right``, ...), by segment.
    start_pose : {"auto", "known", "unknown"}
        ``known``: the recording begins with upright standing, which defines zero angles.
        ``auto``: known if the recording begins with half a second of rest.
    still_s : sequence of tuple of (float, float), optional
        Parts in which the wearer stood still, s on the first sensor's clock; by default the rests
        at the beginning and the end.
    walking_s : tuple of (float, float), optional
        Part with straight walking for the calibration, s; by default from the rest at the start to
        the first turn, or the whole recording.
    align : {"auto", "stamps", "correlation"}, or mapping of str to float
        How the sensors' clocks are aligned (`narx.recordings.session_clock`); a mapping gives the
        time of one event on each sensor's clock, s.
    where : str
        Name of the session, for messages.

    Returns
    -------
    SessionPrediction
        All segments, and all joints for which both segments have a sensor.

    Raises
    ------
    UserError
        If an option or a segment's name is unknown.
    RecordingError
        If a recording cannot be from a leg, or the sensors' recordings do not overlap.
    """
    _check_segments(recordings)
    admitted = {s: admit(one, f"{where}: {s}") for s, one in recordings.items()}
    offsets, notes = clock_offsets_s(admitted, align, where)
    for segment, one in admitted.items():
        notes += [f"{segment}: {note}" for note in (*one.notes, *gap_notes(one, MAX_GAP_S))]
    trial = _on_one_clock(admitted, offsets, where)
    rest_s = first_rest_s([i.gyroscope_rad_s for i in trial.imus.values()], trial.sampling_rate_hz)
    known = start_pose == "known" or (start_pose == "auto" and rest_s >= _MIN_REST_S)
    if start_pose == "known" and rest_s < _MIN_REST_S:
        raise RecordingError(
            f"{where}: start_pose=known needs the recording to begin with standing still, it moves "
            f"after {max(0.0, rest_s):.2f} s, expected {_MIN_REST_S:g} s"
        )
    stands = _rests(trial, rest_s) if still_s is None else tuple(still_s)
    for begin, end in still_s or ():
        for segment, imu in trial.imus.items():
            declared_rest(imu, begin, end, f"{where}: {segment}")
    notes.append(
        "begins in upright standing, where all angles are zero"
        if known
        else "start unknown: angles swing about zero, and joints have no offset"
    )
    if walking_s is None and stands:
        walking_s = walk_before_turn_s(trial, stands[0])
        if walking_s is not None:
            notes.append(f"walk before the first turn: {walking_s[0]:.2f}-{walking_s[1]:.2f} s")
    trial = replace(
        trial,
        still_s=stands,
        walking_s=walking_s,
        starts_in_calibration_posture=known,
        calibration=parts or {},
    )
    trial, bias_notes = _without_bias(trial, where)
    notes += [f"{segment}: {note}" for segment, note in bias_notes.items()]
    segments = _calibrated(trial, calibration, where)
    angles, std, quality = {}, {}, {}
    for segment, calibrated in segments.items():
        imu = trial.imus[segment]
        notes += [
            f"{segment}: {note}"
            for note in calibrated.notes
            if note != BIAS_UNKNOWN or segment not in bias_notes
        ]
        notes += check_consistency(
            imu.gyroscope_rad_s,
            imu.accelerometer_m_s2,
            trial.sampling_rate_hz,
            is_leg=kind_of(segment) in _SWINGING,
            where=f"{where}: {segment}",
        )
        found = method.run(calibrated.signals)
        quality[segment] = found.quality
        found_notes = start_up_note(method, found.quality, trial.sampling_rate_hz)
        if kind_of(segment) in _SWINGING:
            found_notes += doubtful_note(found.quality)
        notes += [f"{segment}: {note}" for note in found_notes]
        angles[segment] = found.angles_rad
        if found.std_rad is not None:
            one = admitted[segment]
            times_s = one.time_s + offsets[segment]
            filled = (times_s, one.gyroscope_rad_s, trial.time_s, MAX_GAP_S)
            std[segment] = np.hypot(found.std_rad, filled_gap_std_rad(*filled))
    for name, joint in JOINTS.items():
        if joint.proximal in segments and joint.distal in segments:
            angles[name] = joint_between(name, angles[joint.proximal], angles[joint.distal])
            if kind_of(name) == "knee":
                thigh, shank = (
                    segments[one].signals.axis_rates_rad_s[:, SAGITTAL]
                    for one in (joint.proximal, joint.distal)
                )
                found_notes = exchanged_note(thigh, shank, angles[name][:, SAGITTAL])
                notes += [f"{name}: {note}" for note in found_notes]
            if joint.proximal in std and joint.distal in std:
                std[name] = np.hypot(std[joint.proximal], std[joint.distal])
    return SessionPrediction(
        trial.time_s,
        trial.sampling_rate_hz,
        angles,
        std,
        quality,
        _contacts_s(segments, float(trial.time_s[0])),
        tuple(notes),
    )


def _check_segments(recordings: Mapping[str, ImuRecording]) -> None:
    known = {segment for joint in JOINTS.values() for segment in (joint.proximal, joint.distal)}
    for segment in recordings:
        if segment not in known:
            raise UserError(f"segment '{segment}', expected some of {', '.join(sorted(known))}")
    if not recordings:
        raise UserError("no recording given, expected one per segment")


def _on_one_clock(
    recordings: Mapping[str, ImuRecording], offsets_s: Mapping[str, float], where: str
) -> Trial:
    first = next(iter(recordings.values()))
    # further digits are only rounding errors of time stamps written as decimals
    rate_hz = float(f"{first.sampling_rate_hz:.6g}")
    times = {segment: one.time_s + offsets_s[segment] for segment, one in recordings.items()}
    begin, end = max(t[0] for t in times.values()), min(t[-1] for t in times.values())
    clock = uniform_clock(begin, end, rate_hz, where)
    imus = {}
    for segment, one in recordings.items():
        gyroscope, force = (
            on_clock(times[segment], values, clock, rate_hz, MAX_GAP_S)
            for values in (one.gyroscope_rad_s, one.accelerometer_m_s2)
        )
        if not np.isfinite(force).all(axis=1).any():
            raise RecordingError(
                f"{where}: '{segment}' has no accelerometer for the vertical; expected its three "
                "columns"
            )
        check_gravity(force, f"{where}: {segment}")
        imus[segment] = ImuRecording(segment, clock, gyroscope, force)
    return Trial("", "", "", "", rate_hz, imus)


def _rests(trial: Trial, first_s: float) -> tuple[tuple[float, float], ...]:
    """Find the standing parts at the beginning and the end."""
    begin, end = float(trial.time_s[0]), float(trial.time_s[-1])
    rates = [imu.gyroscope_rad_s[::-1] for imu in trial.imus.values()]
    last_s = first_rest_s(rates, trial.sampling_rate_hz)
    stands = ((begin, begin + first_s), (end - last_s, end))
    return tuple(stand for stand in stands if stand[1] - stand[0] >= _MIN_REST_S)


def _without_bias(trial: Trial, where: str) -> tuple[Trial, dict[str, str]]:
    """Remove the bias, measured in the quietest part, of the sensors without a standing part."""
    imus, notes = dict(trial.imus), {}
    for segment, imu in trial.imus.items():
        if static_bias(trial, segment) is not None:
            continue  # the calibration removes it
        bias, notes[segment] = remove_static_bias(imu, True, None, f"{where}: {segment}")
        rate = imu.gyroscope_rad_s - (0.0 if bias is None else bias)
        imus[segment] = replace(imu, gyroscope_rad_s=rate)
    return replace(trial, imus=imus), notes


def _calibrated(trial: Trial, mode: Mode, where: str) -> dict[str, CalibratedSegment]:
    """Calibrate thighs and shanks together, and the other segments as far as possible."""
    found: dict[str, CalibratedSegment] = {}
    groups: dict[Mode, list[str]] = {}
    for segment in trial.imus:
        own: Mode = mode
        if kind_of(segment) == "foot":
            own = "walking"
        elif kind_of(segment) not in _SWINGING:
            own = "sensor"
        groups.setdefault(own, []).append(segment)
    for own, segments in groups.items():
        part = replace(trial, imus={segment: trial.imus[segment] for segment in segments})
        try:
            found |= calibrate(part, own)
        except RecordingError as error:
            raise RecordingError(str(error).replace(trial.name, where)) from error
    return {segment: found[segment] for segment in trial.imus}


def _contacts_s(segments: Mapping[str, CalibratedSegment], begin_s: float) -> dict[str, FloatArray]:
    contacts: dict[str, FloatArray] = {}
    for segment, calibrated in segments.items():
        side = side_of(segment)
        if kind_of(segment) != "thigh" or side is None:
            continue
        signals = calibrated.signals
        try:
            found = gait_phases(signals.axis_rates_rad_s[:, SAGITTAL], signals.sampling_rate_hz)
        except UserError:
            continue
        times = found.times_s["b"]
        contacts[side] = times[np.isfinite(times)] + begin_s
    return contacts
