"""Conversions between a segment's orientation, its three clinical angles and their rates.

Frames and signs (the whole package relies on them)
---------------------------------------------------
Anatomical frame: x forward, y left, z up along the segment. Segments of the left leg are
mirrored through the sagittal plane before anything else (`mirror_left`), so every method receives
the signals of a right leg.

With ``R`` the orientation of the anatomical frame in the global frame (z up), relative to the
calibration posture, ``R = Rz(psi) Rx(phi) Ry(theta)``:

========== ========= ==========================================================
axis       angle     positive
========== ========= ==========================================================
sagittal   ``-theta`` flexion: the distal end swings forward
frontal    ``-phi``   abduction: the distal end moves away from the body
transverse ``psi``    internal rotation: the front turns towards the other leg
========== ========= ==========================================================

Sagittal and frontal angle depend only on the direction of gravity in the segment, so they remain
defined when the walker turns; the transverse angle is the heading.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from narx.missing import finite_rows
from narx.types import FloatArray

AXES = ("sagittal", "frontal", "transverse")
SAGITTAL, FRONTAL, TRANSVERSE = range(3)


# mirror through the sagittal plane: vectors change the sign of y, pseudovectors (angular rate)
# of x and z, quaternions (w, x, y, z) of x and z
_MIRROR_VECTOR = np.array([1.0, -1.0, 1.0])
_MIRROR_PSEUDOVECTOR = np.array([-1.0, 1.0, -1.0])
_MIRROR_QUATERNION_WXYZ = np.array([1.0, -1.0, 1.0, -1.0])


def mirror_vector(vector: ArrayLike) -> FloatArray:
    """Mirror x, y, z vectors (acceleration) through the sagittal plane.

    Parameters
    ----------
    vector : array_like, shape (..., 3)
        Components x, y, z in an anatomical frame.

    Returns
    -------
    ndarray, shape (..., 3)
        The same with y negated.
    """
    return np.asarray(vector, dtype=float) * _MIRROR_VECTOR


def mirror_angular_rate(rate: ArrayLike) -> FloatArray:
    """Mirror x, y, z angular rates (pseudovectors) through the sagittal plane.

    Parameters
    ----------
    rate : array_like, shape (..., 3)
        Components x, y, z in an anatomical frame.

    Returns
    -------
    ndarray, shape (..., 3)
        The same with x and z negated.
    """
    return np.asarray(rate, dtype=float) * _MIRROR_PSEUDOVECTOR


def mirror_quaternion(quaternion_wxyz: ArrayLike) -> FloatArray:
    """Mirror orientations through the sagittal plane (of both segment and world).

    Parameters
    ----------
    quaternion_wxyz : array_like, shape (..., 4)
        Quaternions w, x, y, z.

    Returns
    -------
    ndarray, shape (..., 4)
        Quaternions of ``M R M`` with ``M = diag(1, -1, 1)``.
    """
    return np.asarray(quaternion_wxyz, dtype=float) * _MIRROR_QUATERNION_WXYZ


def axis_rates(rate_xyz: ArrayLike) -> FloatArray:
    """Convert anatomical x, y, z rates to rates about the clinical axes, with the reported signs.

    Parameters
    ----------
    rate_xyz : array_like, shape (..., 3)
        Angular rate in the (mirrored) anatomical frame, rad/s.

    Returns
    -------
    ndarray, shape (..., 3)
        Rates in the order of `AXES`: ``(-y, -x, z)``, rad/s.
    """
    rate = np.asarray(rate_xyz, dtype=float)
    return np.stack([-rate[..., 1], -rate[..., 0], rate[..., 2]], axis=-1)


def gyroscope_xyz(axis_rates_rad_s: ArrayLike) -> FloatArray:
    """Undo `axis_rates`.

    Parameters
    ----------
    axis_rates_rad_s : array_like, shape (..., 3)
        Rates about the sagittal, frontal and transverse axis, reported signs, rad/s.

    Returns
    -------
    ndarray, shape (..., 3)
        Rates about x, y, z of the (mirrored) anatomical frame: ``(-frontal, -sagittal,
        transverse)``.
    """
    rates = np.asarray(axis_rates_rad_s, dtype=float)
    xyz = [-rates[..., FRONTAL], -rates[..., SAGITTAL], rates[..., TRANSVERSE]]
    return np.ascontiguousarray(np.stack(xyz, axis=-1))


def clinical_rates(rate_xyz: ArrayLike, side: Literal["left", "right"] | None) -> FloatArray:
    """Convert a segment's anatomical x, y, z rates to rates about the clinical axes of its leg.

    Parameters
    ----------
    rate_xyz : array_like, shape (..., 3)
        Angular rate in the (not mirrored) anatomical frame, rad/s.
    side : {"left", "right"}, optional
        Leg; a left one is mirrored.

    Returns
    -------
    ndarray, shape (..., 3)
        As `axis_rates`.
    """
    return axis_rates(mirror_angular_rate(rate_xyz) if side == "left" else rate_xyz)


def angles_from_orientation(quaternion_wxyz: ArrayLike) -> FloatArray:
    """Decompose segment orientations into sagittal, frontal and transverse angles.

    Parameters
    ----------
    quaternion_wxyz : array_like, shape (N, 4)
        Orientation of the (mirrored) anatomical frame in the global frame; rows with NaN are
        missing.

    Returns
    -------
    ndarray, shape (N, 3)
        Angles in rad in the order of `AXES`; transverse is unwrapped over the valid samples,
        because a walker may turn more than once. Missing rows are NaN.
    """
    quaternion = np.atleast_2d(np.asarray(quaternion_wxyz, dtype=float))
    angles = np.full((len(quaternion), 3), np.nan)
    there = finite_rows(quaternion)
    if there.any():
        rotation = Rotation.from_quat(quaternion[there], scalar_first=True)
        psi, phi, theta = rotation.as_euler("ZXY").T
        angles[there] = np.column_stack([-theta, -phi, np.unwrap(psi)])
    return angles


def orientation_from_angles(angles_rad: ArrayLike) -> FloatArray:
    """Compose segment orientations from the three clinical angles.

    Parameters
    ----------
    angles_rad : array_like, shape (N, 3)
        Angles in the order of `AXES`.

    Returns
    -------
    ndarray, shape (N, 4)
        Quaternions w, x, y, z of ``Rz(transverse) Rx(-frontal) Ry(-sagittal)``; NaN where any
        angle is NaN.
    """
    angles = np.atleast_2d(np.asarray(angles_rad, dtype=float))
    quaternion = np.full((len(angles), 4), np.nan)
    there = finite_rows(angles)
    if there.any():
        # written out explicitly, since scipy takes five times as long, which is seconds per trial
        half = 0.5 * angles[there].T * np.array([[-1.0], [-1.0], [1.0]])
        (cy, cx, cz), (sy, sx, sz) = np.cos(half), np.sin(half)
        w, x, y, z = cz * cx, cz * sx, sz * sx, sz * cx
        quaternion[there] = np.stack(
            [w * cy - y * sy, x * cy - z * sy, w * sy + y * cy, z * cy + x * sy], axis=-1
        )
    return quaternion


def tilt_from_specific_force(specific_force_m_s2: ArrayLike) -> FloatArray:
    """Sagittal and frontal angle of a segment at rest, from the direction of gravity.

    Parameters
    ----------
    specific_force_m_s2 : array_like, shape (..., 3)
        Accelerometer reading x, y, z in the (mirrored) anatomical frame.

    Returns
    -------
    ndarray, shape (..., 2)
        Sagittal ``atan2(x, z)`` and frontal ``atan2(-y, hypot(x, z))`` in rad (Han et al.,
        eqs. (5) and (6), the latter with the tilt of the other axis taken into account).
    """
    x, y, z = np.moveaxis(np.asarray(specific_force_m_s2, dtype=float), -1, 0)
    return np.stack([np.arctan2(x, z), np.arctan2(-y, np.hypot(x, z))], axis=-1)


def coupled_rates(axis_rates_rad_s: ArrayLike, angles_rad: ArrayLike) -> FloatArray:
    """Convert gyroscope rates to the rates of change of the three angles (Euler kinematics).

    Parameters
    ----------
    axis_rates_rad_s : array_like, shape (..., 3)
        Gyroscope about the clinical axes of the segment, order of `AXES`.
    angles_rad : array_like, shape (..., 3)
        Angles at that moment, order of `AXES`.

    Returns
    -------
    ndarray, shape (..., 3)
        d/dt of the angles, rad/s. Singular at a frontal angle of 90 degrees.

    Notes
    -----
    From ``R = Rz(psi) Rx(phi) Ry(theta)``; integrating each gyroscope axis independently neglects
    these terms, so that a turn of a tilted segment appears as flexion.
    """
    sagittal_rate, frontal_rate, transverse_rate = np.moveaxis(
        np.asarray(axis_rates_rad_s, dtype=float), -1, 0
    )
    sagittal, frontal, _ = np.moveaxis(np.asarray(angles_rad, dtype=float), -1, 0)
    heading_rate = (transverse_rate * np.cos(sagittal) - frontal_rate * np.sin(sagittal)) / np.cos(
        frontal
    )
    return np.stack(
        [
            sagittal_rate - np.sin(frontal) * heading_rate,
            frontal_rate * np.cos(sagittal) + transverse_rate * np.sin(sagittal),
            heading_rate,
        ],
        axis=-1,
    )
