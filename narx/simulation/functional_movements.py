"""Calibration movements: standing, imperfect hip abduction and passive knee flexion.

First the sensors lie on a table (``still``), for their bias. The rest is as in Tham et al. (2020),
section II-A: upright standing; abduction and adduction of the hip in
standing; flexion and extension of the knee by someone else, sitting with dangling feet. Sizes
and imperfections are assumptions, listed in docs/simulator.md.
"""

import numpy as np

from narx.simulation.calculus import smooth_step
from narx.simulation.walking import postural_sway
from narx.types import FloatArray

PARTS = (
    "still",
    "standing",
    "hip_abduction_right",
    "hip_abduction_left",
    "knee_flexion_right",
    "knee_flexion_left",
)
DURATION_S = 20.0
STANDING_S = 10.0
STILL_S = 30.0

_REPETITIONS = 5
_FIRST_S = 2.0
_PERIOD_S = 3.4
_ONE_WAY_S = 1.2
_REPETITION_CV = 0.1

_ABDUCTION_DEG = 30.0
_KNEE_EXTENSION_DEG = 50.0
_SITTING_DEG = 88.0
# unintended motion in the other angles, as a share of the movement, standard deviations: of the
# person, and of the single repetition
_COMPANION_SD = 0.04
_COMPANION_REPETITION_SD = 0.02


def duration_s(part: str) -> float:
    """Return the duration of a calibration recording.

    Parameters
    ----------
    part : str
        One of `PARTS`.

    Returns
    -------
    float
        Seconds.
    """
    return {"still": STILL_S, "standing": STANDING_S}.get(part, DURATION_S)


def calibration_angles(
    part: str, time_s: FloatArray, rng: np.random.Generator, exact: bool = False
) -> dict[str, FloatArray]:
    """Perform a calibration movement.

    Parameters
    ----------
    part : str
        One of `PARTS` but ``still``, for which nobody wears the sensors. Hip abduction begins
        with the leg moving outwards, knee flexion with the foot moving forwards.
    time_s : ndarray, shape (N,)
        Clock; the recording begins at 0.
    rng : numpy.random.Generator
        Source of randomness.
    exact : bool, optional
        No unintended motion in the other two angles of the joint.

    Returns
    -------
    dict of str to ndarray, shape (N, 3)
        Joint angles in rad, as in `narx.simulation.skeleton.segment_orientations`.
    """
    angles = postural_sway(rng, time_s)
    if part == "standing":
        return angles
    movement, side = part.rsplit("_", 1)
    outward = -1.0 if side == "left" else 1.0
    if movement == "hip_abduction":
        way = np.radians(_ABDUCTION_DEG) * _repetitions(time_s, rng)
        angles[f"hip_{side}"] += way @ _with_companions(rng, 1, exact)
        # the pelvis follows the leg slightly: the lifted side rises
        angles["pelvis"][:, 1] -= outward * 0.1 * way.sum(axis=1)
    else:
        for thigh in ("hip_right", "hip_left"):
            angles[thigh][:, 0] += np.radians(_SITTING_DEG)
        for knee in ("knee_right", "knee_left"):
            angles[knee][:, 0] += np.radians(_SITTING_DEG)
        way = -np.radians(_KNEE_EXTENSION_DEG) * _repetitions(time_s, rng)
        angles[f"knee_{side}"] += way @ _with_companions(rng, 0, exact)
        # the thigh is lifted slightly off the chair
        angles[f"hip_{side}"][:, 0] -= 0.04 * way.sum(axis=1)
    return angles


def _repetitions(time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
    """One column per repetition: out, short rest, back; sizes and times vary."""
    columns = []
    for k in range(_REPETITIONS):
        start = _FIRST_S + k * _PERIOD_S + 0.15 * rng.random()
        one_way = _ONE_WAY_S * (1.0 + _REPETITION_CV * rng.uniform(-1.0, 1.0))
        size = 1.0 + _REPETITION_CV * rng.uniform(-1.0, 1.0)
        rise = smooth_step((time_s - start) / one_way)
        fall = smooth_step((time_s - start - one_way - 0.3) / one_way)
        columns.append(size * (rise - fall))
    return np.column_stack(columns)


def _with_companions(rng: np.random.Generator, main: int, exact: bool) -> FloatArray:
    """Share of each of the three angles in every repetition, shape (repetitions, 3)."""
    share = _COMPANION_SD * rng.standard_normal(3)
    share = share + _COMPANION_REPETITION_SD * rng.standard_normal((_REPETITIONS, 3))
    if exact:
        share[:] = 0.0
    share[:, main] = 1.0
    return np.asarray(share)
