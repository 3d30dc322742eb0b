"""Resampling from irregular time stamps to a uniform clock, without interpolating across gaps."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import firwin, kaiserord, upfirdn
from scipy.spatial.transform import Rotation, Slerp

from narx.errors import RecordingError
from narx.types import FloatArray

# pass band as a fraction of the new Nyquist frequency, and attenuation beyond it
_PASS_BAND = 0.8
_STOP_BAND_DB = 60.0
# one day at 500 Hz, so that a gap of months does not exhaust the memory
MAX_CLOCK_SAMPLES = 5e7


def uniform_clock(
    start_s: float, stop_s: float, sampling_rate_hz: float, where: str = ""
) -> FloatArray:
    """Return the uniform clock between two times.

    Parameters
    ----------
    start_s, stop_s : float
        First and last time allowed, s.
    sampling_rate_hz : float
        Samples per second.
    where : str
        File, for messages; a caller that adds it itself leaves it out.

    Returns
    -------
    ndarray, shape (N,)
        Multiples of the sampling interval, so that sensors resampled separately share them.

    Raises
    ------
    RecordingError
        If fewer than two samples fit, or more than a day at 500 Hz.
    """
    first = int(np.ceil(start_s * sampling_rate_hz - 1e-6))
    last = int(np.floor(stop_s * sampling_rate_hz + 1e-6))
    file = f"{where}: " if where else ""
    if last - first > MAX_CLOCK_SAMPLES:
        raise RecordingError(
            f"{file}from {start_s:.6g} s to {stop_s:.6g} s there are {last - first:.3g} samples at "
            f"{sampling_rate_hz:g} Hz, expected {MAX_CLOCK_SAMPLES:.0g} at most; is there a "
            "gap, or another unit of time?"
        )
    if last <= first:
        raise RecordingError(
            f"{file}no common time: from {start_s:.3f} s to {stop_s:.3f} s there are not two "
            f"samples at {sampling_rate_hz:g} Hz"
        )
    return np.arange(first, last + 1) / sampling_rate_hz


def contiguous_pieces(
    time_s: ArrayLike, valid: ArrayLike, max_gap_s: float
) -> list[NDArray[np.intp]]:
    """Split samples into pieces without a gap.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Increasing sampling times, s.
    valid : array_like of bool, shape (N,)
        Samples that have a value.
    max_gap_s : float
        Valid samples no further apart than this belong to one piece.

    Returns
    -------
    list of ndarray of int
        Indices of each piece's samples, in order.
    """
    time = np.asarray(time_s, dtype=float)
    samples = np.flatnonzero(np.asarray(valid, dtype=bool))
    if samples.size == 0:
        return []
    return np.split(samples, np.flatnonzero(np.diff(time[samples]) > max_gap_s) + 1)


def resample_vectors(
    time_s: ArrayLike, values: ArrayLike, new_time_s: ArrayLike, *, max_gap_s: float
) -> FloatArray:
    """Resample vectors onto a uniform clock by cubic splines, with an anti-alias filter.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Increasing sampling times, regular or not, s.
    values : array_like, shape (N, K)
        Samples; a row with NaN is missing.
    new_time_s : array_like, shape (M,)
        Uniform clock, s.
    max_gap_s : float
        Longest interval between neighbouring samples that is interpolated.

    Returns
    -------
    ndarray, shape (M, K)
        Resampled values; NaN in gaps and outside the recording.

    Notes
    -----
    Each gapless piece is interpolated onto the new clock's k-th subdivision, the smallest that
    is at least as fine as the original; if k > 1, a zero-phase Kaiser low-pass (pass band 0.8
    of the new Nyquist frequency, 60 dB at it) is applied before every k-th sample is
    kept. At a piece's ends the signal is continued by odd reflection, which keeps level and slope.
    Resampling to the same or a higher rate only interpolates.
    """
    time = np.asarray(time_s, dtype=float)
    data = np.asarray(values, dtype=float)
    clock = np.asarray(new_time_s, dtype=float)
    resampled = np.full((len(clock), data.shape[1]), np.nan)
    interval = (clock[-1] - clock[0]) / (len(clock) - 1)
    # stamps since 1970 are multiples of 0.2 us
    rounding = 1e-6 * interval + 2.0 * np.spacing(np.abs(clock).max())
    for piece in contiguous_pieces(time, np.isfinite(data).all(axis=1), max_gap_s):
        if piece.size < 2:
            continue
        begin, end = np.searchsorted(clock, [time[piece[0]] - rounding, time[piece[-1]] + rounding])
        if begin == end:
            continue
        # relative to the first sample: large time stamps would reduce the precision of the spline
        origin = time[piece[0]]
        spline = make_interp_spline(time[piece] - origin, data[piece], k=3 if piece.size > 3 else 1)
        native = float(np.median(np.diff(time[piece])))
        factor = max(1, int(np.ceil(interval / native - 0.01)))
        fine = clock[begin] + np.arange((end - begin - 1) * factor + 1) * (interval / factor)
        inside = np.clip(fine - origin, 0.0, time[piece[-1]] - origin)
        resampled[begin:end] = _decimated(spline(inside), factor)
    return resampled


def _decimated(fine: FloatArray, factor: int) -> FloatArray:
    """Low-pass without phase shift, then keep every `factor`-th sample."""
    if factor == 1 or len(fine) < 2:
        return fine[::factor]
    taps, beta = kaiserord(_STOP_BAND_DB, (1.0 - _PASS_BAND) / factor)
    half = taps // 2
    low_pass = firwin(2 * half + 1, 0.5 * (1.0 + _PASS_BAND) / factor, window=("kaiser", beta))
    padded = np.pad(fine, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    return upfirdn(low_pass, padded, axis=0)[2 * half : 2 * half + len(fine) : factor]


def resample_quaternions(
    time_s: ArrayLike, quaternion_wxyz: ArrayLike, new_time_s: ArrayLike, *, max_gap_s: float
) -> FloatArray:
    """Interpolate orientations along the shortest arc, only between valid neighbours.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Increasing sampling times, s.
    quaternion_wxyz : array_like, shape (N, 4)
        Unit quaternions; a row with NaN is missing.
    new_time_s : array_like, shape (M,)
        Times to interpolate at, s.
    max_gap_s : float
        Longest interval between neighbouring samples that is interpolated.

    Returns
    -------
    ndarray, shape (M, 4)
        Quaternions w, x, y, z; NaN in gaps and outside the recording.
    """
    time = np.asarray(time_s, dtype=float)
    quaternion = np.asarray(quaternion_wxyz, dtype=float)
    clock = np.asarray(new_time_s, dtype=float)
    resampled = np.full((len(clock), 4), np.nan)
    tolerance = 1e-9
    for piece in contiguous_pieces(time, np.isfinite(quaternion).all(axis=1), max_gap_s):
        first, last = time[piece[0]], time[piece[-1]]
        inside = (clock >= first - tolerance) & (clock <= last + tolerance)
        if not inside.any():
            continue
        rotation = Rotation.from_quat(quaternion[piece], scalar_first=True)
        if piece.size == 1:
            resampled[inside] = rotation.as_quat(scalar_first=True)
        else:
            within = np.clip(clock[inside], first, last)
            resampled[inside] = Slerp(time[piece], rotation)(within).as_quat(scalar_first=True)
    return resampled
