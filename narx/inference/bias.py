"""The gyroscope's static bias in a user's recording, and checks of declared rest."""

import numpy as np
from numpy.typing import ArrayLike

from narx.calibration.static_bias import quietest_window
from narx.errors import RecordingError, UserError
from narx.recordings.rest import REST_RAD_S
from narx.recordings.trial import ImuRecording
from narx.settings.wording import shown
from narx.types import FloatArray

# above sway in standing, and above the bias of any current gyroscope
_MAX_SCATTER_RAD_S = np.radians(2.0)
_MAX_BIAS_RAD_S = np.radians(10.0)
# a part declared still by the user may contain more sway, but no walking
_MAX_DECLARED_SCATTER_RAD_S = np.radians(5.0)
# lengths of windows to search, longest first, since longer ones average out more noise and sway
_STILL_S = (5.0, 2.0, 1.0)
# time during which a person who stands at the first sample does not swing a leg
_FIRST_S = 0.2
_MAX_FIRST_RAD_S = 2 * REST_RAD_S


def remove_static_bias(
    recording: ImuRecording,
    remove: bool,
    still_s: tuple[float, float] | None,
    where: str,
    given_rad_s: ArrayLike | None = None,
) -> tuple[FloatArray | None, str]:
    """Determine the static bias to remove.

    Parameters
    ----------
    recording : ImuRecording
        The sensor.
    remove : bool
        Whether a bias is removed.
    still_s : tuple of (float, float), optional
        Part given by the user as at rest, s; None searches for the quietest one.
    where : str
        Name of the recording, for messages.
    given_rad_s : array_like, shape (3,), optional
        Bias given by the user.

    Returns
    -------
    bias_rad_s : ndarray, shape (3,), or None
        Mean rate at rest, rad/s; None if the bias is not to be removed.
    note : str
        Source of the bias, as text.

    Raises
    ------
    UserError
        If the given bias is invalid, or is combined with a conflicting option.
    RecordingError
        If the given part has no sample, or the sensor moves during it.
    """
    if given_rad_s is not None:
        if still_s is not None or not remove:
            other = "still_s" if still_s is not None else "remove_bias=false"
            raise UserError(f"bias_rad_s and {other} exclude each other; give one of them")
        return _removed(_given(given_rad_s), "bias_rad_s")
    if not remove:
        return None, "static bias not removed, as requested"
    if still_s is not None:
        return _removed(
            declared_rest(recording, *still_s, where), f"{still_s[0]:g}-{still_s[1]:g} s"
        )
    duration_s = recording.n_samples / recording.sampling_rate_hz
    for window_s in (length for length in _STILL_S if length <= duration_s):
        part = quietest_window(
            recording.gyroscope_rad_s, recording.sampling_rate_hz, where, window_s
        )
        if (
            part is not None
            and part.gyroscope_scatter_rad_s < _MAX_SCATTER_RAD_S
            and np.linalg.norm(part.bias_rad_s) < _MAX_BIAS_RAD_S
        ):
            return _removed(part.bias_rad_s, f"the quietest {window_s:g} s")
    return None, (
        f"{where}: static bias not removed, no {_STILL_S[-1]:g} s at rest to measure it; "
        "give still_s, or remove_bias=False if it was already removed"
    )


def _given(bias_rad_s: ArrayLike) -> FloatArray:
    try:
        bias = np.asarray(bias_rad_s, dtype=np.float64)
    except (TypeError, ValueError):
        bias = np.empty(0)
    if bias.shape != (3,) or not np.linalg.norm(bias) < _MAX_BIAS_RAD_S:
        raise UserError(
            f"bias_rad_s is {shown(bias_rad_s)}, expected three numbers in rad/s, together below "
            f"{_MAX_BIAS_RAD_S:.3f} (10 deg/s)"
        )
    return bias


def _removed(bias_rad_s: FloatArray, source: str) -> tuple[FloatArray, str]:
    shown = np.degrees(bias_rad_s).round(3).tolist()
    return bias_rad_s, f"static bias {shown} deg/s from {source} removed"


def check_known_start(time_s: FloatArray, gyroscope_rad_s: FloatArray, where: str) -> None:
    """Refuse a known start that the recording contradicts.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Sampling times, s.
    gyroscope_rad_s : ndarray, shape (N, 3)
        Gyroscope without bias, rad/s; NaN where missing.
    where : str
        Name of the recording, for messages.

    Raises
    ------
    RecordingError
        If the first samples are missing, or the sensor moves during them.
    """
    there = np.isfinite(gyroscope_rad_s).all(axis=1)
    first_s = float(time_s[np.argmax(there)])
    interval_s = float(np.median(np.diff(time_s)))
    if first_s - time_s[0] > max(_FIRST_S / 2, 1.5 * interval_s):
        raise RecordingError(
            f"{where}: start_pose=known, but the gyroscope's first {first_s - time_s[0]:.2f} s are "
            "missing; expected upright standing at the first sample"
        )
    first = gyroscope_rad_s[there & (time_s <= first_s + _FIRST_S)]
    speed = float(np.linalg.norm(first.mean(axis=0)))
    if speed > _MAX_FIRST_RAD_S:
        raise RecordingError(
            f"{where}: start_pose=known, but the sensor turns by {np.degrees(speed):.0f} deg/s in "
            f"the first {_FIRST_S:g} s; expected upright standing at the first sample"
        )


def declared_rest(recording: ImuRecording, begin: float, end: float, where: str) -> FloatArray:
    """Average the gyroscope over a part that the user declared still.

    Parameters
    ----------
    recording : ImuRecording
        One sensor.
    begin, end : float
        The part, s on the recording's clock.
    where : str
        Name of the recording, for messages.

    Returns
    -------
    ndarray, shape (3,)
        Mean rate, the static bias, rad/s.

    Raises
    ------
    RecordingError
        If there are no samples in it, or the sensor moves.
    """
    inside = (recording.time_s >= begin) & (recording.time_s <= end)
    rate = recording.gyroscope_rad_s[inside]
    rate = rate[np.isfinite(rate).all(axis=1)]
    if not len(rate):
        raise RecordingError(
            f"{where}: no gyroscope sample in still_s {begin:g}-{end:g} s; the recording "
            f"lasts from {recording.time_s[0]:g} to {recording.time_s[-1]:g} s"
        )
    scatter = float(np.sqrt(rate.var(axis=0).sum()))
    mean = float(np.linalg.norm(rate.mean(axis=0)))
    if scatter > _MAX_DECLARED_SCATTER_RAD_S or mean > _MAX_BIAS_RAD_S:
        raise RecordingError(
            f"{where}: still_s {begin:g}-{end:g} s is not at rest: the gyroscope varies by "
            f"{np.degrees(scatter):.1f} deg/s about a mean of {np.degrees(mean):.1f} deg/s, "
            f"expected less than {np.degrees(_MAX_DECLARED_SCATTER_RAD_S):.0f} and "
            f"{np.degrees(_MAX_BIAS_RAD_S):.0f}"
        )
    return np.asarray(rate.mean(axis=0))
