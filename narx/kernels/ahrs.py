"""Madgwick's and Mahony's filters with gyroscope and accelerometer.

They reproduce the Python library `ahrs` 0.4, which takes 50 microseconds per sample; tests compare
the two. Quaternions are w, x, y, z of the sensor in a world frame with z up.
"""

from typing import Any

import numpy as np

from narx.kernels.compiler import EXACT, EXACT_INNER, compiled
from narx.kernels.transfer import copy_row


@compiled(**EXACT_INNER)
def _turn(q: Any, x: Any, y: Any, z: Any, interval: Any, correction: Any) -> None:
    """Advance q by its derivative at the rate (x, y, z), less a correction (4,), and normalise."""
    w0, x0, y0, z0 = q
    q[0] += interval * (0.5 * (-x0 * x - y0 * y - z0 * z) - correction[0])
    q[1] += interval * (0.5 * (w0 * x + y0 * z - z0 * y) - correction[1])
    q[2] += interval * (0.5 * (w0 * y - x0 * z + z0 * x) - correction[2])
    q[3] += interval * (0.5 * (w0 * z + x0 * y - y0 * x) - correction[3])
    q /= np.sqrt(np.sum(q * q))


@compiled(**EXACT)
def madgwick(
    gyroscope: Any, accelerometer: Any, interval: Any, gain: Any, q: Any, bias: Any, out: Any
) -> None:
    """Fill out (N, 4) from gyroscope (N, 3) in rad/s and accelerometer (N, 3); q (4,) is updated.

    Madgwick et al., eqs. (12), (25), (26), (33) and (34). `bias` is unused: both filters have the
    same signature.
    """
    gradient = np.zeros(4)
    for k in range(len(gyroscope)):
        x, y, z = gyroscope[k]
        force = np.sqrt(np.sum(accelerometer[k] ** 2))
        if x != 0.0 or y != 0.0 or z != 0.0:
            gradient[:] = 0.0
            if force > 0.0:
                a, b, c = accelerometer[k] / force
                qw, qx, qy, qz = q
                f0 = 2.0 * (qx * qz - qw * qy) - a
                f1 = 2.0 * (qw * qx + qy * qz) - b
                f2 = 2.0 * (0.5 - qx * qx - qy * qy) - c
                if f0 != 0.0 or f1 != 0.0 or f2 != 0.0:
                    gradient[0] = -2.0 * qy * f0 + 2.0 * qx * f1
                    gradient[1] = 2.0 * qz * f0 + 2.0 * qw * f1 - 4.0 * qx * f2
                    gradient[2] = -2.0 * qw * f0 + 2.0 * qz * f1 - 4.0 * qy * f2
                    gradient[3] = 2.0 * qx * f0 + 2.0 * qy * f1
                    gradient *= gain / np.sqrt(np.sum(gradient * gradient))
            _turn(q, x, y, z, interval, gradient)
        copy_row(q, out[k])


@compiled(**EXACT)
def mahony(
    gyroscope: Any, accelerometer: Any, interval: Any, gains: Any, q: Any, bias: Any, out: Any
) -> None:
    """Fill out (N, 4) likewise; `gains`: proportional, integral; bias (3,) is updated.

    Mahony et al., eqs. (32) and (48).
    """
    proportional, integral = gains
    nothing = np.zeros(4)
    for k in range(len(gyroscope)):
        x, y, z = gyroscope[k]
        force = np.sqrt(np.sum(accelerometer[k] ** 2))
        if x != 0.0 or y != 0.0 or z != 0.0:
            if force > 0.0:
                a, b, c = accelerometer[k] / force
                qw, qx, qy, qz = q
                up_x = 2.0 * (qx * qz - qw * qy)
                up_y = 2.0 * (qw * qx + qy * qz)
                up_z = 1.0 - 2.0 * (qx * qx + qy * qy)
                e0 = b * up_z - c * up_y
                e1 = c * up_x - a * up_z
                e2 = a * up_y - b * up_x
                bias[0] -= integral * e0 * interval
                bias[1] -= integral * e1 * interval
                bias[2] -= integral * e2 * interval
                x += proportional * e0 - bias[0]
                y += proportional * e1 - bias[1]
                z += proportional * e2 - bias[2]
            _turn(q, x, y, z, interval, nothing)
        copy_row(q, out[k])
