"""From a user's own recording to three angles, with a trained network."""

import os
import warnings
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from narx.calibration import calibrate
from narx.errors import RecordingError, UserError
from narx.method import SegmentSignals
from narx.network_method import NarxMethod
from narx.recording import ImuRecording, Trial
from narx.resampling import contiguous_pieces, resample_vectors
from narx.segment_angles import axis_rates, mirror_angular_rate
from narx.shipped import checkpoint_or_shipped
from narx.static_bias import first_rest_s, quietest_window

FloatArray = NDArray[np.float64]
Frame = Literal["auto", "anatomical", "walking", "sensor"]
Side = Literal["right", "left"]
StartPose = Literal["known", "unknown"]

# a few lost samples are interpolated across, a lost part of a stride is not
MAX_GAP_S = 0.05
# a person who stands still sways less, and no gyroscope of today is off by more
_MAX_UNREST_RAD_S = np.radians(2.0)
_MAX_BIAS_RAD_S = np.radians(10.0)
# enough for the direction of gravity
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
        Standard deviation of the error that training expects, rad; None where it is not known.
    bias_rad_s : ndarray, shape (3,), or None
        Static bias that was removed, in the sensor frame, rad/s; None if none was.
    notes : tuple of str
        What was done to the recording, for people.
    """

    time_s: FloatArray
    angles_rad: FloatArray
    std_rad: FloatArray | None
    bias_rad_s: FloatArray | None
    notes: tuple[str, ...]


def predict(
    recording: ImuRecording,
    method: NarxMethod,
    *,
    frame: Frame = "auto",
    side: Side = "right",
    start_pose: StartPose = "unknown",
    remove_bias: bool = True,
    still_s: tuple[float, float] | None = None,
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
        ``walking``: the sensor sits anyhow on a thigh or shank; up comes from the accelerometer,
        forward from the swing of the leg, so there must be some steps (`narx.calibration`).
        ``sensor``: the sensor's axes, turned the shortest way so that z is up at the start.
        ``auto``: walking where there is an accelerometer, else anatomical.
    side : {"right", "left"}
        Leg; decides the signs of abduction and internal rotation.
    start_pose : {"known", "unknown"}
        ``known``: the first sample is upright standing, where all angles are zero; they keep
        that zero. ``unknown``: angles swing about zero once the start-up is over.
    remove_bias : bool
        Whether the gyroscope's static bias is removed.
    still_s : tuple of (float, float), optional
        Part in which the sensor was at rest, s on the recording's clock: its mean rate is the
        bias. Without it, the quietest 5 s are taken if they are quiet enough (unrest below
        2 deg/s, mean below 10 deg/s); otherwise the bias stays in, and a note says so.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    Prediction
        Angles at the recording's sampling times.

    Raises
    ------
    UserError
        If a choice is unknown, or the recording lacks what it needs.

    Notes
    -----
    The recording is brought to a uniform clock at its own median rate and the angles back to its
    sampling times, both by cubic splines. Gaps of up to 50 ms are interpolated across; in longer
    ones the network pauses, and the angles go on from where they were.
    """
    _check("frame", frame, Frame)
    _check("side", side, Side)
    _check("start_pose", start_pose, StartPose)
    clock, rate_hz = _uniform_clock(recording, where)
    bias, bias_note = _bias(recording, remove_bias, still_s, where)
    corrected = recording.gyroscope_rad_s - (0.0 if bias is None else bias)
    gyroscope = _on_clock(recording.time_s, corrected, clock)
    if not np.isfinite(gyroscope).any():
        raise RecordingError(f"{where}: no two gyroscope samples within {MAX_GAP_S:g} s")
    has_accelerometer = bool(np.isfinite(recording.accelerometer_m_s2).all(axis=1).any())
    if frame == "auto":
        frame = "walking" if has_accelerometer else "anatomical"
    if frame == "anatomical":
        frame_note = "frame anatomical: axes taken as x forward, y left, z up"
    elif has_accelerometer:
        force = _on_clock(recording.time_s, recording.accelerometer_m_s2, clock)
        imu = ImuRecording(f"leg_{side}", clock, gyroscope, force)
        to_anatomical, frame_note = _sensor_to_anatomical(imu, rate_hz, frame, start_pose, where)
        gyroscope = to_anatomical.apply(gyroscope)
    else:
        raise RecordingError(
            f"{where}: frame={frame} needs an accelerometer to tell what is up; expected its "
            "three columns, or frame=anatomical"
        )
    rates = axis_rates(mirror_angular_rate(gyroscope) if side == "left" else gyroscope)
    signals = SegmentSignals(
        f"leg_{side}",
        rate_hz,
        rates,
        np.full_like(rates, np.nan),
        np.zeros(3) if start_pose == "known" else None,
    )
    there: NDArray[np.bool_] = np.asarray(np.isfinite(recording.gyroscope_rad_s).all(axis=1))
    std = method.standard_deviation(signals)
    return Prediction(
        recording.time_s,
        _at_samples(clock, method.estimate(signals), recording.time_s, there),
        None if std is None else _at_samples(clock, std, recording.time_s, there),
        bias,
        (f"{rate_hz:g} Hz", bias_note, frame_note),
    )


def angles_from_gyroscope(
    gyroscope_rad_s: ArrayLike,
    sampling_rate_hz: float,
    *,
    accelerometer_m_s2: ArrayLike | None = None,
    frame: Frame = "auto",
    side: Side = "right",
    start_pose: StartPose = "unknown",
    remove_bias: bool = True,
    still_s: tuple[float, float] | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
) -> FloatArray:
    """Turn a gyroscope's samples into the three angles of the segment that it sits on.

    Parameters
    ----------
    gyroscope_rad_s : array_like, shape (N, 3)
        Angular rate x, y, z in rad/s (``np.radians`` of deg/s); NaN where missing.
    sampling_rate_hz : float
        Samples per second; need not be the network's.
    accelerometer_m_s2 : array_like, shape (N, 3), optional
        Specific force x, y, z in m/s^2. Used for nothing but to find the segment's axes in the
        sensor, so that the sensor may sit anyhow. Without it the gyroscope's axes must be the
        segment's: x forward, y to the left, z up along it.
    frame : {"auto", "anatomical", "walking", "sensor"}
        How the axes are found, see `predict`; by default from walking where there is an
        accelerometer.
    side : {"right", "left"}
        Leg; decides the signs of abduction and internal rotation.
    start_pose : {"known", "unknown"}
        ``known`` if the first sample is upright standing, where all angles are zero; they keep
        that zero. ``unknown``: angles swing about zero.
    remove_bias : bool
        Whether the gyroscope's static bias is removed; False if it already is.
    still_s : tuple of (float, float), optional
        Part in which the sensor was at rest, s from the first sample, to take the bias from; by
        default it is looked for, and a warning says so where there is none.
    checkpoint : path-like, optional
        Network from `narx.checkpoint.save`; the shipped one by default.

    Returns
    -------
    ndarray, shape (N, 3)
        Sagittal (flexion +), frontal (abduction +) and transverse (internal rotation +) angle
        in rad; NaN where a sample is missing.

    Raises
    ------
    UserError
        If a choice is unknown, or the recording lacks what it needs.

    Examples
    --------
    >>> angles_deg = np.degrees(angles_from_gyroscope(gyroscope_rad_s, 100.0))  # doctest: +SKIP
    """
    if not (np.isfinite(sampling_rate_hz) and sampling_rate_hz > 0):
        raise UserError(f"sampling_rate_hz is {sampling_rate_hz}, expected a positive number")
    gyroscope = np.asarray(gyroscope_rad_s, dtype=np.float64)
    force = (
        np.full(gyroscope.shape, np.nan)
        if accelerometer_m_s2 is None
        else np.asarray(accelerometer_m_s2, dtype=np.float64)
    )
    prediction = predict(
        ImuRecording("segment", np.arange(len(gyroscope)) / sampling_rate_hz, gyroscope, force),
        checkpoint_or_shipped(checkpoint).method(),
        frame=frame,
        side=side,
        start_pose=start_pose,
        remove_bias=remove_bias,
        still_s=still_s,
    )
    if remove_bias and prediction.bias_rad_s is None:
        warnings.warn(prediction.notes[1], UserWarning, stacklevel=2)
    return prediction.angles_rad


def _check(name: str, value: object, choices: object) -> None:
    if value not in get_args(choices):
        raise UserError(f"{name} is '{value}', expected one of {', '.join(get_args(choices))}")


def _bias(
    recording: ImuRecording,
    remove: bool,
    still_s: tuple[float, float] | None,
    where: str,
) -> tuple[FloatArray | None, str]:
    if not remove:
        return None, "static bias left in, as asked for"
    rate_hz = recording.sampling_rate_hz
    if still_s is None:
        part = quietest_window(recording.gyroscope_rad_s, rate_hz, "the quietest 5 s")
        if (
            part is None
            or part.unrest_rad_s > _MAX_UNREST_RAD_S
            or np.linalg.norm(part.bias_rad_s) > _MAX_BIAS_RAD_S
        ):
            return None, (
                f"{where}: static bias left in, no 5 s without movement to take it from; "
                "still_s tells a shorter part, remove_bias=False that it is off already"
            )
    else:
        begin, end = still_s
        inside = (recording.time_s >= begin) & (recording.time_s <= end)
        there = recording.gyroscope_rad_s[inside]
        there = there[np.isfinite(there).all(axis=1)]
        if not len(there):
            raise RecordingError(
                f"{where}: no gyroscope sample in still_s {begin:g}-{end:g} s; the recording "
                f"lasts from {recording.time_s[0]:g} to {recording.time_s[-1]:g} s"
            )
        # all of it: what was said to be still is not searched again
        bias = there.mean(axis=0)
        return bias, f"static bias {_deg_s(bias)} deg/s from {begin:g}-{end:g} s removed"
    return part.bias_rad_s, (
        f"static bias {_deg_s(part.bias_rad_s)} deg/s from {part.where} removed"
    )


def _deg_s(rate_rad_s: FloatArray) -> list[float]:
    return [round(float(value), 3) for value in np.degrees(rate_rad_s)]


def _uniform_clock(recording: ImuRecording, where: str) -> tuple[FloatArray, float]:
    """Make a clock of about the median rate that begins and ends with the recording."""
    if recording.n_samples < 2:
        raise RecordingError(f"{where}: {recording.n_samples} samples, expected at least 2")
    begin, end = recording.time_s[[0, -1]]
    intervals = max(1, round((end - begin) * recording.sampling_rate_hz))
    return np.linspace(begin, end, intervals + 1), intervals / (end - begin)


def _on_clock(time_s: FloatArray, values: FloatArray, clock: FloatArray) -> FloatArray:
    # a slow recording has no gap between its regular samples
    max_gap_s = max(MAX_GAP_S, 1.5 * float(np.median(np.diff(time_s))))
    return resample_vectors(time_s, values, clock, max_gap_s=max_gap_s)


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


def _at_samples(
    clock: FloatArray, values: FloatArray, time_s: FloatArray, there: NDArray[np.bool_]
) -> FloatArray:
    """Bring values from the uniform clock to the sampling times, NaN where nothing is there."""
    result = np.full((len(time_s), values.shape[1]), np.nan)
    interval = float(clock[1] - clock[0])
    for piece in contiguous_pieces(clock, np.isfinite(values).all(axis=1), 1.5 * interval):
        # up to one interval beyond the piece: its first sample may lie before the first tick
        first, last = clock[piece[0]] - interval, clock[piece[-1]] + interval
        inside = there & (time_s > first) & (time_s < last)
        if piece.size < 2 or not inside.any():
            continue
        spline = make_interp_spline(
            clock[piece] - first, values[piece], k=3 if piece.size > 3 else 1
        )
        result[inside] = spline(time_s[inside] - first)
    return result
