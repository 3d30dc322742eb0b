"""Joint angles from the orientations of two segments, by the joint coordinate system.

E. S. Grood, W. J. Suntay, "A joint coordinate system for the clinical description of
three-dimensional motions: application to the knee", J. Biomech. Eng. 105 (1983) 136-144, as Tham
et al. (2020, section II-D) use it. With segments in the frame of `narx.kinematics.segment_angles`
(x forward, y left, z up along the segment, left legs mirrored to right ones):

============= ============================================= ==================================
axis          definition                                    positive
============= ============================================= ==================================
e1            y of the proximal segment (mediolateral)      flexion: the distal segment's far
                                                            end swings backwards
e2, floating  e1 x e3                                       abduction: the far end moves away
                                                            from the body
e3            z of the distal segment (its long axis)       internal rotation: the front turns
                                                            towards the other leg
============= ============================================= ==================================

which is the rotation sequence
``R_proximal^T R_distal = Ry(flexion) Rx(-abduction) Rz(internal rotation)``. Note that a knee
flexes backwards whereas a thigh's sagittal angle is positive forwards: in a walk straight ahead
knee flexion is about the thigh's sagittal angle less the shank's.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from narx.kinematics.segment_angles import mirror_quaternion
from narx.missing import finite_rows
from narx.types import FloatArray

# sine of the angle between e1 and e3 below which rounding errors dominate the floating axis
_GIMBAL_LOCK = 1e-7


def grood_suntay(proximal_wxyz: ArrayLike, distal_wxyz: ArrayLike) -> FloatArray:
    """Compute joint angles from the orientations of the two segments that the joint connects.

    Parameters
    ----------
    proximal_wxyz, distal_wxyz : array_like, shape (N, 4)
        Orientations of both anatomical frames in the same global frame, w, x, y, z, mirrored to
        a right leg (`joint_angles` does that for raw ones). Both relative to the calibration
        posture, which is therefore zero. Rows with NaN are missing.

    Returns
    -------
    ndarray, shape (N, 3)
        Flexion, abduction and internal rotation in rad: flexion and rotation in (-pi, pi],
        abduction in [-pi/2, pi/2]. Missing rows are NaN.

    Notes
    -----
    At an abduction of +-90 degrees e1 and e3 are parallel, there is no floating axis, and only
    the sum (or difference) of flexion and rotation is defined. The rotation is then reported as
    zero and flexion takes the whole sum, so that the three angles still compose to the orientation.
    """
    proximal = np.atleast_2d(np.asarray(proximal_wxyz, dtype=float))
    distal = np.atleast_2d(np.asarray(distal_wxyz, dtype=float))
    if proximal.shape != distal.shape or proximal.shape[1:] != (4,):
        raise ValueError(
            f"orientations have shapes {proximal.shape} and {distal.shape}, expected twice (N, 4)"
        )
    angles = np.full((len(proximal), 3), np.nan)
    there = finite_rows(proximal) & finite_rows(distal)
    if there.any():
        angles[there] = _from_frames(
            Rotation.from_quat(proximal[there], scalar_first=True).as_matrix(),
            Rotation.from_quat(distal[there], scalar_first=True).as_matrix(),
        )
    return angles


def _from_frames(proximal: FloatArray, distal: FloatArray) -> FloatArray:
    """Angles from rotation matrices, shape (N, 3, 3), whose columns are the segments' axes."""
    proximal_x, e1, proximal_z = np.moveaxis(proximal, -1, 0)
    distal_x, distal_y, e3 = np.moveaxis(distal, -1, 0)

    def dot(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.einsum("ij,ij->i", a, b)

    floating = np.cross(e1, e3)
    sine = np.linalg.norm(floating, axis=1)
    locked = sine < _GIMBAL_LOCK
    e2 = np.where(locked[:, None], distal_x, floating / np.where(locked, 1.0, sine)[:, None])
    flexion = np.arctan2(-dot(e2, proximal_z), dot(e2, proximal_x))
    # from both sine and cosine, because arcsin alone loses half the digits near 90 degrees
    abduction = np.arctan2(dot(e1, e3), sine)
    rotation = np.arctan2(-dot(e2, distal_y), dot(e2, distal_x))
    rotation[locked] = 0.0
    return np.column_stack([flexion, abduction, rotation])


def joint_angles(
    proximal_wxyz: ArrayLike, distal_wxyz: ArrayLike, side: Literal["left", "right"]
) -> FloatArray:
    """Compute joint angles from raw orientations of either leg.

    Parameters
    ----------
    proximal_wxyz, distal_wxyz : array_like, shape (N, 4)
        Orientations as measured (x forward, y left, z up), not mirrored.
    side : {"left", "right"}
        Which leg; a left one is mirrored through the sagittal plane first.

    Returns
    -------
    ndarray, shape (N, 3)
        As `grood_suntay`: the same signs mean the same for both legs.
    """
    if side == "left":
        return grood_suntay(mirror_quaternion(proximal_wxyz), mirror_quaternion(distal_wxyz))
    if side == "right":
        return grood_suntay(proximal_wxyz, distal_wxyz)
    raise ValueError(f"side is {side!r}, expected 'left' or 'right'")


def orientation_from_joint_angles(
    angles_rad: ArrayLike, proximal_wxyz: ArrayLike | None = None
) -> FloatArray:
    """Compose the distal segment's orientation from joint angles, the inverse of `grood_suntay`.

    Parameters
    ----------
    angles_rad : array_like, shape (N, 3)
        Flexion, abduction and internal rotation in rad.
    proximal_wxyz : array_like, shape (N, 4), optional
        Orientation of the (mirrored) proximal segment in the global frame. Without it the result
        is relative to the proximal segment.

    Returns
    -------
    ndarray, shape (N, 4)
        Quaternions w, x, y, z of the (mirrored) distal segment; NaN where anything is missing.
    """
    angles = np.atleast_2d(np.asarray(angles_rad, dtype=float))
    proximal = np.tile([1.0, 0.0, 0.0, 0.0], (len(angles), 1))
    if proximal_wxyz is not None:
        proximal = np.atleast_2d(np.asarray(proximal_wxyz, dtype=float))
    quaternion = np.full((len(angles), 4), np.nan)
    there = finite_rows(angles) & finite_rows(proximal)
    if there.any():
        joint = Rotation.from_euler("YXZ", angles[there] * [1.0, -1.0, 1.0])
        distal = Rotation.from_quat(proximal[there], scalar_first=True) * joint
        quaternion[there] = distal.as_quat(scalar_first=True)
    return quaternion
