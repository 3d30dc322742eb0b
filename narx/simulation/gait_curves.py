"""Joint angles over the stride: published mean curves as Fourier series.

The tables hold the published mean curves of healthy adults at a comfortable speed (about
1.3 m/s), read to about a degree at every twentieth of the stride from heel strike to heel strike
and given relative to quiet standing, since that is the calibration posture here:

- hip and knee flexion: Winter, The Biomechanics and Motor Control of Human Gait, 2nd ed., 1991
  (natural cadence); Kadaba et al., J Orthop Res 8:383-392, 1990;
- pelvis and the hip's frontal and transverse planes: Kadaba et al. 1990; Perry and Burnfield,
  Gait Analysis, 2nd ed., 2010;
- the knee's frontal and transverse planes: Lafortune et al., J Biomech 25:347-357, 1992
  (bone pins).

They are shapes for simulation, not data to cite. Curves of different people and laboratories are
not exactly consistent: hip flexion and adduction and knee flexion were adjusted by at most 1.5
degrees so that the feet carry the pelvis as evenly as in real walking; individual walkers deviate
from them by more than that (`narx.simulation.walker`).
"""

import numpy as np
from numpy.typing import NDArray

from narx.types import FloatArray

ComplexArray = NDArray[np.complex128]

# order of the channels of a joint throughout: flexion, abduction, internal rotation
PELVIS = ("tilt_forward", "right_side_down", "right_side_forward")
JOINT = ("flexion", "abduction", "internal_rotation")

HARMONICS = 7
REFERENCE_SPEED_M_S = 1.3
TABLE_TOE_OFF = 0.63
CIRCUMDUCTION_DEG = 14.0

# degrees at 0, 5, ..., 95 % of the stride
_HIP_FLEXION = [25.3, 24.9, 22.7, 18.8, 14.1, 8.9, 4, -0.6, -5.2, -8.8,
                -11.5, -11.3, -7.5, 0.9, 9.4, 16.9, 22.5, 26, 27, 26.1]  # fmt: skip
_HIP_ADDUCTION = [0.4, 1.5, 3.5, 5.7, 6.4, 6.2, 5.9, 5.2, 4.4, 3,
                  0.8, -1.7, -4.4, -5.6, -4.9, -3.4, -2.3, -1.2, -0.6, 0]  # fmt: skip
_HIP_ROTATION = [-2, -1, 1, 2.2, 3, 3.4, 3.5, 3.5, 3.4, 3,
                 2, 0, -2.5, -4, -4.2, -3.6, -2.8, -2.2, -2.2, -2.4]  # fmt: skip
_KNEE_FLEXION = [4.6, 10.5, 16.3, 18.4, 17, 13.4, 9.9, 7.1, 5.5, 5.8,
                 9, 17, 31.3, 48, 58.5, 60.5, 53.5, 38, 20, 7]  # fmt: skip
_KNEE_ABDUCTION = [0, 0, 0.2, 0.3, 0.2, 0.1, 0, 0, 0, 0.2,
                   0.6, 1.4, 2.8, 4.2, 5.1, 5.2, 4.2, 2.6, 1.1, 0.2]  # fmt: skip
_KNEE_ROTATION = [-1, 1, 3, 4, 4.2, 3.8, 3.2, 2.8, 2.6, 2.8,
                  3.4, 3.8, 3, 0.5, -2.5, -4.4, -5, -4.6, -3.6, -2.4]  # fmt: skip
_PELVIS_TILT = [0.6, 0.2, -0.5, -1, -1, -0.6, 0, 0.6, 0.9, 0.8,
                0.6, 0.2, -0.5, -1, -1, -0.6, 0, 0.6, 0.9, 0.8]  # fmt: skip
_PELVIS_RIGHT_UP = [0.8, 2.4, 3.7, 4.2, 3.6, 2.6, 1.8, 1.2, 0.8, 0.3,
                    -0.8, -2.4, -3.7, -4.2, -3.6, -2.6, -1.8, -1.2, -0.8, -0.3]  # fmt: skip
_PELVIS_ROTATION = [4.2, 4, 3.4, 2.6, 1.8, 0.9, 0, -1, -2.1, -3.3,
                    -4.2, -4, -3.4, -2.6, -1.8, -0.9, 0, 1, 2.1, 3.3]  # fmt: skip

# change per m/s of speed, degrees: the knee yields more in loading and bends a little more in
# swing the faster the walk (Kirtley et al., J Biomed Eng 7:282, 1985; Lelas et al., Gait &
# Posture 17:106, 2003)
_KNEE_FLEXION_PER_M_S = [1, 4, 8, 9.5, 8, 5, 2.5, 1, 0, 0,
                         1, 2.5, 4, 5.5, 6.5, 6.5, 5, 3, 1.5, 0.5]  # fmt: skip


def fourier_series(table_deg: list[float], harmonics: int = HARMONICS) -> ComplexArray:
    """Convert one stride of a table to a Fourier series.

    Parameters
    ----------
    table_deg : list of float
        Degrees at equal steps of the stride, from heel strike on.
    harmonics : int, optional
        Highest harmonic kept.

    Returns
    -------
    ndarray of complex, shape (harmonics + 1,)
        Coefficients c in rad: the angle is the real part of ``sum c_k exp(2 pi i k phase)``.
    """
    coefficients = np.fft.rfft(np.radians(table_deg)) / len(table_deg)
    coefficients[1:] *= 2.0
    return np.asarray(coefficients[: harmonics + 1])


def joint_curves(speed_m_s: float) -> dict[str, ComplexArray]:
    """Return the mean curves of pelvis, hip and knee at a speed.

    Parameters
    ----------
    speed_m_s : float
        Walking speed.

    Returns
    -------
    dict of str to ndarray of complex, shape (3, HARMONICS + 1)
        ``pelvis`` (order of `PELVIS`, phase of the right leg), ``hip`` and ``knee`` (order of
        `JOINT`, phase of the leg), Fourier coefficients in rad.

    Notes
    -----
    Pelvis and the hip's frontal and transverse planes grow with the speed (here with its square
    root, like the stride length); the hip's flexion is scaled by the walker so that the feet
    do not slip (`narx.simulation.walker`).
    """
    growth = np.sqrt(speed_m_s / REFERENCE_SPEED_M_S)
    faster = speed_m_s - REFERENCE_SPEED_M_S
    knee_flexion = fourier_series(_KNEE_FLEXION) + faster * fourier_series(_KNEE_FLEXION_PER_M_S)
    return {
        "pelvis": growth
        * np.stack(
            [
                fourier_series(_PELVIS_TILT),
                -fourier_series(_PELVIS_RIGHT_UP),
                fourier_series(_PELVIS_ROTATION),
            ]
        ),
        "hip": np.stack(
            [
                fourier_series(_HIP_FLEXION),
                -growth * fourier_series(_HIP_ADDUCTION),
                growth * fourier_series(_HIP_ROTATION),
            ]
        ),
        "knee": np.stack(
            [knee_flexion, fourier_series(_KNEE_ABDUCTION), fourier_series(_KNEE_ROTATION)]
        ),
    }


def swing_outwards(curves: dict[str, ComplexArray]) -> dict[str, ComplexArray]:
    """Swing the legs outwards, as the walkers of Han et al. (2020) did on purpose.

    Parameters
    ----------
    curves : dict of str to ndarray of complex
        From `joint_curves`.

    Returns
    -------
    dict of str to ndarray of complex
        With a hip abducted by `CIRCUMDUCTION_DEG` and turned outwards by a third of that in
        mid-swing, with less knee flexion. The paper gives no sizes; these are of the order of
        circumduction in hemiparetic gait (Kerrigan et al., Am J Phys Med Rehabil 79:247, 2000).
    """
    phase = np.arange(100) / 100.0
    swing = np.clip((phase - TABLE_TOE_OFF + 0.08) / (1.08 - TABLE_TOE_OFF), 0.0, 1.0)
    bump = fourier_series(list(CIRCUMDUCTION_DEG * np.sin(np.pi * swing) ** 2))
    hip, knee = curves["hip"].copy(), curves["knee"].copy()
    hip[1] += bump
    hip[2] -= bump / 3.0
    knee[0, 1:] *= 0.75
    return {**curves, "hip": hip, "knee": knee}


def table_phase(phase: FloatArray, toe_off: float) -> FloatArray:
    """Warp the stride so that toe-off coincides with that of the tables.

    Parameters
    ----------
    phase : ndarray
        Stride phase of the leg, 1 per stride, an integer at heel strike.
    toe_off : float
        Phase at which this walker's foot leaves the ground.

    Returns
    -------
    ndarray
        Phase in the tables: equal at heel strike, `TABLE_TOE_OFF` at toe-off, smooth between.
    """
    bend = (TABLE_TOE_OFF - toe_off) / (1.0 - np.cos(2.0 * np.pi * toe_off))
    return phase + bend * (1.0 - np.cos(2.0 * np.pi * phase))


def evaluate(coefficients: ComplexArray, phase: FloatArray) -> FloatArray:
    """Evaluate Fourier series at many phases.

    Parameters
    ----------
    coefficients : ndarray of complex, shape (C, K + 1)
        Series of C channels.
    phase : ndarray, shape (N,)
        Stride phase.

    Returns
    -------
    ndarray, shape (N, C)
        Angles in the unit of the coefficients.
    """
    turn = np.exp(2j * np.pi * phase)
    angles = np.empty((len(phase), len(coefficients)))
    for channel, series in enumerate(coefficients):
        # Horner's scheme: one complex exponential serves all harmonics
        value = np.full(len(phase), series[-1])
        for coefficient in series[-2::-1]:
            value *= turn
            value += coefficient
        angles[:, channel] = value.real
    return angles
