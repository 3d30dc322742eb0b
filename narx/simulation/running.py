"""Running: joint angles over the stride, stride frequency, and the bounce of the pelvis.

Hip and knee flexion are the mean curves of Novacheck (Gait & Posture 7:77-95, 1998), read to about
five degrees; the other planes and the pelvis are those of walking at the same speed
(`narx.simulation.gait_curves`), *assumed*. Other than in walking, no foot carries the pelvis for a
part of the stride, so its path is that of a bounce.
"""

import numpy as np

from narx.simulation.gait_curves import ComplexArray, fourier_series, joint_curves
from narx.types import FloatArray

# km/h, mean and standard deviation over the subjects, *assumed*: an easy run
SPEED_KM_H = (9.5, 0.6)
# runners change the length of their strides rather than their frequency (Cavanagh and Kram, Med Sci
# Sports Exerc 21:467, 1989: 1.3 to 1.4 strides per second at 3 to 4 m/s)
STRIDE_HZ = 1.35
# the foot leaves the ground after 39 to 36 % of the stride (Novacheck)
TOE_OFF = 0.38
# rise and fall of the body by 8 cm, lowest in the middle of stance (order of Novacheck)
BOUNCE_M = 0.04

# degrees at 0, 5, ..., 95 % of the stride, relative to quiet standing
_HIP_FLEXION = [38.0, 37, 33, 27, 19, 11, 3, -3, -6, -4,
                2, 12, 23, 34, 43, 49, 51, 48, 43, 40]  # fmt: skip
_KNEE_FLEXION = [18.0, 29, 38, 41, 39, 33, 26, 20, 19, 26,
                 41, 60, 79, 92, 97, 91, 74, 51, 30, 18]  # fmt: skip


def running_curves(speed_m_s: float) -> dict[str, ComplexArray]:
    """Return the mean curves of pelvis, hip and knee in running.

    Parameters
    ----------
    speed_m_s : float
        Running speed.

    Returns
    -------
    dict of str to ndarray of complex, shape (3, HARMONICS + 1)
        As `narx.simulation.gait_curves.joint_curves`, with the running foot's own timing.
    """
    curves = joint_curves(speed_m_s)
    curves["hip"][0] = fourier_series(_HIP_FLEXION)
    curves["knee"][0] = fourier_series(_KNEE_FLEXION)
    return curves


def bounce_m(phase: FloatArray, toe_off: float) -> FloatArray:
    """Displacement of the pelvis.

    Parameters
    ----------
    phase : ndarray, shape (N,)
        Phase of the right leg.
    toe_off : float
        Phase of a leg at its toe-off.

    Returns
    -------
    ndarray, shape (N, 3)
        Upwards twice per stride, m.
    """
    bounce = np.zeros((len(phase), 3))
    bounce[:, 2] = -BOUNCE_M * np.cos(4.0 * np.pi * (phase - 0.5 * toe_off))
    return bounce
