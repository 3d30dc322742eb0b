"""Check of axes that are taken as the segment's, by the axis about which the leg swings."""

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import correlate

from narx.calibration.axes import swing_sign, walking_band
from narx.errors import RecordingError
from narx.missing import finite_rows
from narx.types import BoolArray, FloatArray

# slower than the swing of a leg, root mean square over two seconds
_MOVING_RAD_S = np.radians(25.0)
_WINDOW_S = 2.0
_MIN_WALK_S = 5.0
_STRIDES_S = (0.6, 2.5)
# that of the recorded walks was 0.33 to 0.91
_MIN_PERIODICITY = 0.3
# smallest share of one axis in the rate
_MIN_SHARE = 0.6
_CERTAIN_SHARE = 0.7
# Largest angles between this axis and the plane of y and z, and between it and y. Recorded thighs
# turn about z as well, so their axis is up to 54 degrees from y, but within 9 degrees of the plane.
_DOUBTFUL_RAD = np.radians([35.0, 70.0])
_CERTAIN_RAD = np.radians([55.0, 78.0])


def mounting_note(
    gyroscope_rad_s: FloatArray,
    sampling_rate_hz: float,
    *,
    has_accelerometer: bool,
    is_assumed: bool,
    where: str,
) -> list[str]:
    """Compare the axis about which a leg swings with y, the mediolateral axis.

    Parameters
    ----------
    gyroscope_rad_s : ndarray, shape (N, 3)
        On a uniform clock, in axes taken as x forward, y left, z up; NaN where missing.
    sampling_rate_hz : float
        Samples per second.
    has_accelerometer : bool
        Whether the recording has one, from which the axes could be found.
    is_assumed : bool
        Whether these axes were assumed, not asked for.
    where : str
        Name of the recording, for the message.

    Returns
    -------
    list of str
        A note if the leg swings about another axis, or y seems to point to the right; empty if
        the axes fit, or if no walk, or no dominant axis, was found.

    Raises
    ------
    RecordingError
        If the axes were assumed, and the leg certainly swings about another axis.
    """
    rate = walking_band(gyroscope_rad_s, sampling_rate_hz)
    moving = _moving(rate, sampling_rate_hz)
    walk = rate[moving]
    if len(walk) < _MIN_WALK_S * sampling_rate_hz:
        return []
    power, axes = np.linalg.eigh(walk.T @ walk)
    axis, share = axes[:, -1], float(power[-1] / power.sum())
    swing = np.where(moving, np.nan_to_num(rate) @ axis, 0.0)
    if share < _MIN_SHARE or _periodicity(swing, sampling_rate_hz) < _MIN_PERIODICITY:
        return []
    # the swing determines which end of the axis is left
    sign = swing_sign(walk, axis)
    axis = axis * (sign or np.sign(axis[np.argmax(np.abs(axis))]))
    angles = np.array([np.arcsin(min(1.0, abs(axis[0]))), np.arccos(min(1.0, abs(axis[1])))])
    if (angles <= _DOUBTFUL_RAD).all():
        return [_reversed(has_accelerometer)] if swing_sign(walk, np.array([0, 1, 0])) < 0 else []
    found = (
        f"the leg swings about ({', '.join(f'{one:.2f}' for one in axis)}), expected y (0, 1, 0): "
        f"is the sensor mounted otherwise? {_way_out(has_accelerometer)}"
    )
    if is_assumed and share > _CERTAIN_SHARE and (angles > _CERTAIN_RAD).any():
        raise RecordingError(f"{where}: {found}; frame=anatomical keeps the axes as they are")
    return [found]


def _reversed(has_accelerometer: bool) -> str:
    return (
        "the leg swings faster backward than forward, as if y pointed to the right: is the sensor "
        f"mounted otherwise? {_way_out(has_accelerometer)}"
    )


def _way_out(has_accelerometer: bool) -> str:
    if has_accelerometer:
        return "Give frame=walking, or columns=... with the axes exchanged"
    return "Give an accelerometer, or columns=... with the axes exchanged"


def _moving(rate: FloatArray, sampling_rate_hz: float) -> BoolArray:
    power = uniform_filter1d(
        np.nan_to_num((rate**2).sum(axis=1)), max(1, round(_WINDOW_S * sampling_rate_hz))
    )
    return np.asarray((power > _MOVING_RAD_S**2) & finite_rows(rate))


def _periodicity(rate: FloatArray, sampling_rate_hz: float) -> float:
    """Largest autocorrelation at the duration of a stride.

    Normalised by the energy of the two parts that overlap, so that it is 1 for a periodic signal
    of any length (McLeod and Wyvill 2005).
    """
    longest = min(len(rate) // 2, round(_STRIDES_S[1] * sampling_rate_hz))
    lags = np.arange(round(_STRIDES_S[0] * sampling_rate_hz), longest + 1)
    products = correlate(rate, rate, "full", "fft")[len(rate) - 1 + lags]
    energy = np.cumsum(rate**2)
    overlapping = energy[-1 - lags] + energy[-1] - energy[lags - 1]
    return float(np.max(2.0 * products / overlapping, initial=0.0))
