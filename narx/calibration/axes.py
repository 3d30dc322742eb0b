"""Alignment of a sensor's technical frame with its segment's anatomical frame (Tham et al., II-A).

The frames are rotations that map vectors in the sensor frame to the anatomical frame (x forward, y
left, z up along the segment; not mirrored, so the same for left and right legs).

Gravity gives z. The second axis is a rotation axis found from a movement: the hip's abduction axis
(x) for a thigh, the knee's flexion axis (y) for a shank, or the principal horizontal axis (y) of
walking without calibration movements. The sign of the axis follows from the direction of the
calibration movement (`excursion_rad`), or from the swing of the leg in walking (`swing_sign`).
"""

import numpy as np
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation
from scipy.stats import skew

from narx.errors import RecordingError
from narx.recordings.resampling import contiguous_pieces
from narx.types import FloatArray

# pass band of walking: turns and bias are below, soft-tissue motion is above
_BAND_HZ = (0.5, 10.0)
MIN_WALK_S = 1.0
# skewness of simulated and real walkers: thighs 0.2 to 1.1, shanks 0.7 to 1.1
_MIN_SKEWNESS = 0.1


def up_from_gravity(accelerometer_m_s2: FloatArray, where: str) -> FloatArray:
    """Return the upward direction in the sensor frame.

    Parameters
    ----------
    accelerometer_m_s2 : ndarray, shape (N, 3)
        Specific force, m/s^2, at rest or over whole strides; samples with NaN are left out.
    where : str
        Name of the recording, for the message.

    Returns
    -------
    ndarray, shape (3,)
        Unit vector along the mean specific force.

    Raises
    ------
    RecordingError
        If there is no sample, or the magnitude of the mean is far from gravity.
    """
    valid = accelerometer_m_s2[np.isfinite(accelerometer_m_s2).all(axis=1)]
    if not len(valid):
        raise RecordingError(f"{where}: no accelerometer sample from which to measure the vertical")
    mean = valid.mean(axis=0)
    size = float(np.linalg.norm(mean))
    if not 8.0 < size < 12.0:
        raise RecordingError(
            f"{where}: mean specific force is {size:.2f} m/s^2, expected about 9.8 (unit or "
            "calibration of the accelerometer)"
        )
    return np.asarray(mean / size)


def principal_horizontal_axis(rate_rad_s: FloatArray, up: FloatArray) -> FloatArray:
    """Return the horizontal axis about which a sensor turns most.

    Parameters
    ----------
    rate_rad_s : ndarray, shape (N, 3)
        Angular rate in the sensor frame without bias, rad/s, no NaN.
    up : ndarray, shape (3,)
        Direction of up in the sensor frame.

    Returns
    -------
    ndarray, shape (3,)
        Unit vector of unknown sign, perpendicular to up. Restricting the axis to the horizontal
        plane excludes rotation about the leg's long axis, which can be the largest part of the
        motion of a phone in a pocket.
    """
    horizontal = rate_rad_s - np.outer(rate_rad_s @ up, up)
    _, _, axes = np.linalg.svd(horizontal.T @ horizontal)
    axis = axes[0] - up * (axes[0] @ up)
    return np.asarray(axis / np.linalg.norm(axis))


def walking_band(rate_rad_s: FloatArray, sampling_rate_hz: float) -> FloatArray:
    """Band-pass the rate to the band of walking, 0.5 to 10 Hz, without phase shift.

    Parameters
    ----------
    rate_rad_s : ndarray, shape (N, 3)
        Angular rate on a uniform clock, rad/s; NaN where missing.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    ndarray, shape (N, 3)
        The filtered rate; NaN in gaps and in pieces shorter than 1 s.
    """
    high = min(_BAND_HZ[1], 0.45 * sampling_rate_hz)
    band = butter(2, (_BAND_HZ[0], high), "bandpass", fs=sampling_rate_hz, output="sos")
    time = np.arange(len(rate_rad_s)) / sampling_rate_hz
    valid = np.isfinite(rate_rad_s).all(axis=1)
    filtered = np.full_like(rate_rad_s, np.nan)
    for piece in contiguous_pieces(time, valid, 1.5 / sampling_rate_hz):
        if piece.size >= MIN_WALK_S * sampling_rate_hz:
            filtered[piece] = sosfiltfilt(band, rate_rad_s[piece], axis=0)
    return filtered


def swing_sign(walk_rad_s: FloatArray, left: FloatArray) -> int:
    """Determine from the swing of a leg whether an axis points left or right.

    Parameters
    ----------
    walk_rad_s : ndarray, shape (N, 3)
        Angular rate of a thigh or shank in walking, as from `walking_band`, no NaN.
    left : ndarray, shape (3,)
        Mediolateral axis in the sensor frame.

    Returns
    -------
    int
        1 if it points to the left, -1 if to the right, 0 if it cannot be determined (walk too
        short, or skewness of the rate below 0.1).

    Notes
    -----
    In walking the leg swings forward in about 40 % of the stride and back in the other 60 %, so the
    rate of flexion (about minus left) is skewed to positive values. No reference is used.
    """
    if not len(walk_rad_s):
        return 0
    skewness = float(skew(-(walk_rad_s @ left)))
    # NaN: a constant rate has no skewness
    return int(np.sign(skewness)) if abs(skewness) >= _MIN_SKEWNESS else 0


def excursion_rad(rate_rad_s: FloatArray, axis: FloatArray, sampling_rate_hz: float) -> float:
    """Return the mean angle about an axis during a movement that starts at rest.

    Parameters
    ----------
    rate_rad_s : ndarray, shape (N, 3)
        Angular rate without bias, rad/s, no NaN.
    axis : ndarray, shape (3,)
        Unit vector in the sensor frame.
    sampling_rate_hz : float
        Samples per second.

    Returns
    -------
    float
        Mean of the integrated rate, rad.
    """
    return float(np.mean(np.cumsum(rate_rad_s @ axis)) / sampling_rate_hz)


def frame_from_left(up: FloatArray, left: FloatArray) -> Rotation:
    """Build the frame from the upward and the leftward direction.

    Parameters
    ----------
    up, left : ndarray, shape (3,)
        Perpendicular unit vectors in the sensor frame.

    Returns
    -------
    Rotation
        Maps sensor vectors to anatomical ones.
    """
    return Rotation.from_matrix(np.vstack([np.cross(left, up), left, up]))


def frame_from_gravity(up: FloatArray) -> Rotation:
    """Build a frame from the upward direction alone, by the smallest rotation.

    Parameters
    ----------
    up : ndarray, shape (3,)
        Direction of up in the sensor frame.

    Returns
    -------
    Rotation
        Maps sensor vectors to the upright frame. A sensor with its z axis up keeps its frame; one
        that is upside down is rotated about its x axis.
    """
    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(up, z)
    sine, cosine = float(np.linalg.norm(axis)), float(up @ z)
    direction = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    return Rotation.from_rotvec(np.arctan2(sine, cosine) * direction)
