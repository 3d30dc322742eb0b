"""Angular rate and specific force at a place on a moving segment."""

import numpy as np
from scipy.spatial.transform import Rotation

from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.calculus import derivative
from narx.types import FloatArray

_UP = np.array([0.0, 0.0, GRAVITY_M_S2])


def angular_rate(orientation: Rotation, rate_hz: float) -> FloatArray:
    """Angular rate of a frame, in that frame.

    Parameters
    ----------
    orientation : scipy.spatial.transform.Rotation
        N orientations, frame to global, on a uniform clock.
    rate_hz : float
        Its rate.

    Returns
    -------
    ndarray, shape (N, 3)
        Twice the vector part of the conjugate quaternion times the quaternion's derivative,
        rad/s.
    """
    quaternion = orientation.as_quat()
    # choose between q and -q so that the samples are those of a smooth function
    flips = np.cumsum(np.einsum("ij,ij->i", quaternion[1:], quaternion[:-1]) < 0.0) % 2
    quaternion[1:] *= np.where(flips, -1.0, 1.0)[:, None]
    vector, scalar = quaternion[:, :3], quaternion[:, 3:]
    change = derivative(quaternion, rate_hz)
    return np.asarray(
        2.0 * (scalar * change[:, :3] - change[:, 3:] * vector - np.cross(vector, change[:, :3]))
    )


def specific_force(orientation: Rotation, acceleration_m_s2: FloatArray) -> FloatArray:
    """Specific force measured by an ideal accelerometer.

    Parameters
    ----------
    orientation : scipy.spatial.transform.Rotation
        N orientations, sensor to global.
    acceleration_m_s2 : ndarray, shape (N, 3)
        Acceleration in the global frame.

    Returns
    -------
    ndarray, shape (N, 3)
        Acceleration minus gravity in the sensor's frame; at rest it points up, m/s^2.
    """
    return np.asarray(orientation.inv().apply(acceleration_m_s2 + _UP))
