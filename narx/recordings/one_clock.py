"""Two sensors on one time axis: the accelerometer resampled at the gyroscope's samples."""

from dataclasses import replace

import numpy as np

from narx.recordings.resampling import contiguous_pieces
from narx.recordings.trial import ImuRecording
from narx.types import BoolArray, FloatArray

# a sensor that is missing in more than this share of rows has a different rate, or separate rows
_OTHER_RATE = 0.2
_MIN_SAMPLES = 10
# largest gap to interpolate across, in intervals of the accelerometer
_MAX_INTERVALS = 2.5


def at_gyroscope_times(recording: ImuRecording) -> ImuRecording:
    """Resample the accelerometer at the gyroscope's samples, if the two are in separate rows.

    Parameters
    ----------
    recording : ImuRecording
        Its rows contain one sensor, the other, or both.

    Returns
    -------
    ImuRecording
        The recording itself if both are sampled together; else the gyroscope's rows, with the
        accelerometer interpolated linearly, and a note.
    """
    turning: BoolArray = np.asarray(np.isfinite(recording.gyroscope_rad_s).any(axis=1))
    pulled: BoolArray = np.asarray(np.isfinite(recording.accelerometer_m_s2).any(axis=1))
    n = recording.n_samples
    if min(turning.sum(), pulled.sum()) < _MIN_SAMPLES:
        return recording
    own_rows = (pulled & ~turning).sum() > _OTHER_RATE * n
    slower = (turning & ~pulled).sum() > _OTHER_RATE * turning.sum()
    if not own_rows and not slower:
        return recording
    keep = turning if own_rows else np.ones(n, dtype=bool)
    time = recording.time_s[keep]
    note = (
        f"gyroscope at {_rate_hz(recording.time_s[turning]):.4g} Hz and accelerometer at "
        f"{_rate_hz(recording.time_s[pulled]):.4g} Hz on one time axis: the accelerometer is "
        "interpolated to the gyroscope's samples"
    )
    return replace(
        recording,
        time_s=time,
        gyroscope_rad_s=recording.gyroscope_rad_s[keep],
        accelerometer_m_s2=_interpolated(recording, pulled, time),
        notes=(*recording.notes, note),
    )


def union_of_rows(
    recording: ImuRecording, time_s: FloatArray, accelerometer_m_s2: FloatArray
) -> ImuRecording:
    """Add the samples of an accelerometer that has different sampling times.

    Parameters
    ----------
    recording : ImuRecording
        Recording with the gyroscope.
    time_s : ndarray, shape (M,)
        The accelerometer's sampling times on the same clock, increasing, s.
    accelerometer_m_s2 : ndarray, shape (M, 3)
        Its samples.

    Returns
    -------
    ImuRecording
        One row for every time of either; a sensor without a sample at that time is NaN.
    """
    time = np.union1d(recording.time_s, time_s)
    gyroscope, force = np.full((2, len(time), 3), np.nan)
    gyroscope[np.searchsorted(time, recording.time_s)] = recording.gyroscope_rad_s
    force[np.searchsorted(time, time_s)] = accelerometer_m_s2
    return replace(recording, time_s=time, gyroscope_rad_s=gyroscope, accelerometer_m_s2=force)


def _rate_hz(time_s: FloatArray) -> float:
    return float(1.0 / np.median(np.diff(time_s))) if len(time_s) > 1 else np.nan


def _interpolated(recording: ImuRecording, valid: BoolArray, time_s: FloatArray) -> FloatArray:
    complete = valid & np.isfinite(recording.accelerometer_m_s2).all(axis=1)
    own = recording.time_s[complete]
    result = np.full((len(time_s), 3), np.nan)
    if len(own) < 2:
        return result
    gap_s = _MAX_INTERVALS * float(np.median(np.diff(own)))
    for piece in contiguous_pieces(recording.time_s, complete, gap_s):
        first, last = recording.time_s[piece[[0, -1]]]
        inside = (time_s >= first) & (time_s <= last)
        for axis in range(3):
            result[inside, axis] = np.interp(
                time_s[inside], recording.time_s[piece], recording.accelerometer_m_s2[piece, axis]
            )
    return result
