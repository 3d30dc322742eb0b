"""Angles of a user's recording by a trained network."""

import os
import warnings
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.errors import RecordingError
from narx.inference.bias import check_known_start, remove_static_bias
from narx.inference.clocks import ClockConversion
from narx.inference.filled_gaps import filled_gap_std_rad
from narx.inference.findings import (
    check_consistency,
    doubtful_note,
    gap_notes,
    start_up_note,
)
from narx.inference.mounting import mounting_note
from narx.inference.narx_method import NarxMethod
from narx.inference.pretrained import load_or_pretrained
from narx.kernels.clock import MISSING
from narx.kinematics.segment_angles import clinical_rates, mirror_vector
from narx.method import SegmentSignals
from narx.recordings.plausibility import admit, check_gravity
from narx.recordings.rest import first_rest_s
from narx.recordings.stamps import checked_rate_hz
from narx.recordings.trial import ImuRecording, Trial
from narx.settings import Flag, SamplesLike, Span, checked
from narx.types import BoolArray, FloatArray

Frame = Literal["auto", "anatomical", "walking", "sensor"]
Side = Literal["right", "left"]
StartPose = Literal["known", "unknown"]

# Longest gap that is filled. In recorded walks this leaves less of an error than a pause of the
# network does, less than half for 0.6 s (docs/interruptions.py).
MAX_GAP_S = 1.1
# rate, bias and frame are noted for every recording; further notes are exceptions
_USUAL_NOTES = 3
# shortest standing, s, that is sufficient to measure the direction of gravity
_MIN_STANDING_S = 0.5


@dataclass(frozen=True)
class Prediction:
    """Angles of one segment at the recording's own sampling times.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times as recorded, s.
    angles_rad : ndarray, shape (N, 3)
        Sagittal (flexion +), frontal (abduction +) and transverse (internal rotation +) angle,
        rad; NaN where the recording is missing.
    std_rad : ndarray, shape (N, 3), or None
        Standard deviation of the error expected from training, rad; None if unknown.
    quality : ndarray of int8, shape (N,)
        A `narx.inference.stream.Quality` each: what stands behind the angles.
    bias_rad_s : ndarray, shape (3,), or None
        Static bias that was removed, in the sensor frame, rad/s; None if no bias was removed.
    notes : tuple of str
        Processing applied to the recording, as text.
    """

    time_s: FloatArray
    angles_rad: FloatArray
    std_rad: FloatArray | None
    quality: NDArray[np.int8]
    bias_rad_s: FloatArray | None
    notes: tuple[str, ...]


@checked
def predict(
    recording: ImuRecording,
    method: NarxMethod,
    *,
    frame: Frame = "auto",
    side: Side = "right",
    start_pose: StartPose = "unknown",
    remove_bias: Flag = True,
    still_s: Span | None = None,
    bias_rad_s: SamplesLike | None = None,
    where: str = "recording",
) -> Prediction:
    """Estimate the angles of a segment from its recording.

    Parameters
    ----------
    recording : ImuRecording
        Sensor on the segment; sampling times regular or not, accelerometer NaN if there is none.
    method : NarxMethod
        Trained network.
    frame : {"auto", "anatomical", "walking", "sensor"}
        ``anatomical``: the sensor's axes are the segment's, x forward, y to the left, z up.
        ``walking``: arbitrary orientation of the sensor on a thigh or shank; up comes from the
        accelerometer, forward from the swing of the leg, so there must be some steps
        (`narx.calibration.calibrate`). ``sensor``: the sensor's axes, with the smallest rotation
        that makes z vertical at the start. ``auto``: walking if there is an accelerometer,
        otherwise anatomical.
    side : {"right", "left"}
        Leg; decides the signs of abduction and internal rotation.
    start_pose : {"known", "unknown"}
        ``known``: the first sample is upright standing, which defines the zero of all angles.
        ``unknown``: the angles swing about zero after the start-up.
    remove_bias : bool
        Whether the gyroscope's static bias is removed.
    still_s : tuple of (float, float), optional
        Part in which the sensor was at rest, s on the recording's clock: its mean rate is the
        bias. By default the bias is measured over the quietest 5, 2 or 1 s, the longest of these
        that is at rest (gyroscope scatter below 2 deg/s, mean below 10 deg/s). If there is none,
        the bias is not removed, a note reports this, and a network with a tracker starts with a
        larger uncertainty of the bias.
    bias_rad_s : array_like, shape (3,), optional
        Known bias in the sensor frame.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    Prediction
        Angles at the recording's sampling times.

    Raises
    ------
    UserError
        If an option is unknown, or the recording lacks required data.

        Notes
    -----
    The recording is first checked (`narx.recordings.plausibility`): time stamps are converted to
    sampling times, faults to missing samples, and implausible leg motion is refused. It is then
    resampled to a uniform clock at its own median rate and the angles back to its sampling times,
    both by cubic splines. Gaps of up to a second are filled (`narx.recordings.bridging`); during
    longer ones the network pauses, and the angles continue from their last values.
    """
    recording = admit(recording, where)
    conversion = ClockConversion(recording.time_s, MAX_GAP_S, where)
    rate_hz = conversion.sampling_rate_hz
    bias, bias_note = remove_static_bias(recording, remove_bias, still_s, where, bias_rad_s)
    if remove_bias and bias is None:
        method = method.with_doubtful_bias()
    corrected = recording.gyroscope_rad_s - (0.0 if bias is None else bias)
    gyroscope = conversion.to_clock(corrected)
    if not np.isfinite(gyroscope).any():
        raise RecordingError(f"{where}: no two gyroscope samples within {MAX_GAP_S:g} s")
    if start_pose == "known":
        check_known_start(recording.time_s, corrected, where)
    more = [*recording.notes, *gap_notes(recording, MAX_GAP_S)]
    has_accelerometer = bool(np.isfinite(recording.accelerometer_m_s2).all(axis=1).any())
    if has_accelerometer:
        force = conversion.to_clock(recording.accelerometer_m_s2)
        more += check_consistency(gyroscope, force, rate_hz, is_leg=frame != "sensor", where=where)
        if frame != "anatomical" or method.needs_accelerometer:
            check_gravity(force, where)
    to_anatomical: Rotation | None = None
    is_assumed = frame == "auto"
    if frame == "auto":
        frame = "walking" if has_accelerometer else "anatomical"
    if frame == "anatomical":
        frame_note = "frame anatomical: axes taken as x forward, y left, z up"
        more[:0] = mounting_note(
            gyroscope,
            rate_hz,
            has_accelerometer=has_accelerometer,
            is_assumed=is_assumed,
            where=where,
        )
    elif has_accelerometer:
        imu = ImuRecording(f"leg_{side}", conversion.clock_s, gyroscope, force)
        to_anatomical, frame_note = _sensor_to_anatomical(imu, rate_hz, frame, start_pose, where)
        gyroscope = to_anatomical.apply(gyroscope)
    else:
        raise RecordingError(
            f"{where}: frame={frame} needs an accelerometer for the vertical; expected its "
            "three columns, or frame=anatomical"
        )
    rates = clinical_rates(gyroscope, side)
    specific_force = np.full_like(rates, np.nan)
    if method.needs_accelerometer:
        if not has_accelerometer:
            raise RecordingError(f"{where}: a network with aided=true needs an accelerometer")
        specific_force = force if to_anatomical is None else to_anatomical.apply(force)
        specific_force = mirror_vector(specific_force) if side == "left" else specific_force
    signals = SegmentSignals(
        f"leg_{side}",
        rate_hz,
        rates,
        specific_force,
        np.zeros(3) if start_pose == "known" else None,
    )
    there: BoolArray = np.asarray(np.isfinite(recording.gyroscope_rad_s).all(axis=1))
    found = method.run(signals)
    std = found.std_rad
    if std is not None:
        filled = (recording.time_s, corrected, conversion.clock_s, MAX_GAP_S)
        std = np.hypot(std, filled_gap_std_rad(*filled))
        # a spline overshoots at a step, such as that at the end of the start-up
        bounds = np.fmin.reduce(std, axis=0), np.fmax.reduce(std, axis=0)
        std = np.clip(conversion.to_samples(std, there), *bounds)
    more += [*start_up_note(method, found.quality, rate_hz), *doubtful_note(found.quality)]
    return Prediction(
        recording.time_s,
        conversion.to_samples(found.angles_rad, there),
        std,
        np.where(there, found.quality[conversion.nearest_ticks()], MISSING).astype(np.int8),
        bias,
        (f"{rate_hz:g} Hz", bias_note, frame_note, *more),
    )


@checked
def angles_from_gyroscope(
    gyroscope_rad_s: SamplesLike,
    sampling_rate_hz: float,
    *,
    accelerometer_m_s2: SamplesLike | None = None,
    frame: Frame = "auto",
    side: Side = "right",
    start_pose: StartPose = "unknown",
    remove_bias: Flag = True,
    still_s: Span | None = None,
    smoothing: Flag = False,
    checkpoint: str | os.PathLike[str] | None = None,
) -> FloatArray:
    """Convert a gyroscope's samples to the three angles of the segment that carries it.

    Parameters
    ----------
    gyroscope_rad_s : array_like, shape (N, 3)
        Angular rate x, y, z in rad/s (``np.radians`` of deg/s); NaN where missing.
    sampling_rate_hz : float
        Samples per second; need not be the network's.
    accelerometer_m_s2 : array_like, shape (N, 3), optional
        Specific force x, y, z in m/s^2. Used only to find the segment's axes in the sensor, which
        allows an arbitrary orientation. Without it the gyroscope's axes must be the segment's: x
        forward, y to the left, z up along it.
    frame : {"auto", "anatomical", "walking", "sensor"}
        How the axes are found, see `predict`; by default from walking if there is an accelerometer.
    side : {"right", "left"}
        Leg; decides the signs of abduction and internal rotation.
    start_pose : {"known", "unknown"}
        ``known`` if the first sample is upright standing, which defines the zero of all angles.
        ``unknown``: the angles swing about zero.
    remove_bias : bool
        Whether the gyroscope's static bias is removed; False if it already is.
    still_s : tuple of (float, float), optional
        Part in which the sensor was at rest, s from the first sample, for the bias; by default it
        is detected, with a warning if there is none.
    smoothing : bool
        Average a forward and a backward pass: smaller errors (docs/generalisation.md), but every
        angle then depends on later samples.
    checkpoint : path-like, optional
        Network from `narx.inference.checkpoint.save`; the shipped one by default.

    Returns
    -------
    ndarray, shape (N, 3)
        Sagittal (flexion +), frontal (abduction +) and transverse (internal rotation +) angle
        in rad; NaN where a sample is missing.

    Raises
    ------
    UserError
        If an option is unknown, or the recording lacks required data.

        Examples
    --------
    >>> angles_deg = np.degrees(angles_from_gyroscope(gyroscope_rad_s, 100.0))  # doctest: +SKIP
    """
    sampling_rate_hz = checked_rate_hz(sampling_rate_hz, "sampling_rate_hz")
    gyroscope = np.atleast_1d(np.asarray(gyroscope_rad_s))
    force = (
        np.full(gyroscope.shape, np.nan)
        if accelerometer_m_s2 is None
        else np.asarray(accelerometer_m_s2)
    )
    prediction = predict(
        ImuRecording("segment", np.arange(len(gyroscope)) / sampling_rate_hz, gyroscope, force),
        load_or_pretrained(checkpoint).method(smoothing),
        frame=frame,
        side=side,
        start_pose=start_pose,
        remove_bias=remove_bias,
        still_s=still_s,
    )
    doubts = list(prediction.notes[_USUAL_NOTES:])
    if remove_bias and prediction.bias_rad_s is None:
        doubts.append(prediction.notes[1])
    if doubts:
        warnings.warn("; ".join(doubts), UserWarning, stacklevel=3)
    return prediction.angles_rad


def _sensor_to_anatomical(
    imu: ImuRecording, rate_hz: float, mode: Literal["walking", "sensor"], start: str, where: str
) -> tuple[Rotation, str]:
    standing: tuple[tuple[float, float], ...] = ()
    if start == "known":
        rest_s = first_rest_s([imu.gyroscope_rad_s], rate_hz)
        if rest_s < _MIN_STANDING_S:
            raise RecordingError(
                f"{where}: start_pose=known with frame={mode} needs the recording to begin with "
                f"standing still, it moves after {rest_s:.2f} s, expected {_MIN_STANDING_S:g} s"
            )
        standing = ((float(imu.time_s[0]), float(imu.time_s[0]) + rest_s),)
    trial = Trial("", "", "", "", rate_hz, {imu.segment: imu}, still_s=standing)
    try:
        calibrated = calibrate(trial, mode)[imu.segment]
    except RecordingError as error:
        raise RecordingError(str(error).replace(trial.name, where)) from error
    return calibrated.sensor_to_anatomical, f"frame {calibrated.notes[1]}"
