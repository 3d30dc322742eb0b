"""Gait of one person at one speed: the published mean with individual deviations."""

from dataclasses import dataclass, replace

import numpy as np

from narx.simulation.body import Body
from narx.simulation.gait_curves import (
    ComplexArray,
    evaluate,
    joint_curves,
    swing_outwards,
    table_phase,
)
from narx.simulation.random_numbers import stream
from narx.simulation.running import STRIDE_HZ, TOE_OFF, running_curves
from narx.simulation.skeleton import SIDES, forward_velocity
from narx.types import FloatArray

JOINTS = ("pelvis", "hip_right", "knee_right", "hip_left", "knee_left")

# between-subject standard deviations: of the mean angle in deg (sagittal, frontal, transverse,
# after Kadaba et al., 1990: bands about half as wide as theirs, since theirs include the error of
# marker placement), and of the curves' size and timing
_OFFSET_SD_DEG = {"pelvis": (2.0, 1.0, 1.5), "hip": (3.0, 2.0, 3.0), "knee": (3.0, 1.0, 3.0)}
_SIZE_SD = 0.08
_HARMONIC_SD = 0.04
_TIMING_SD = 0.008
# the two legs of one person differ by a third of the difference between two people
_ASYMMETRY = 0.33
# weights of the fit to the feet: change of a harmonic of the hip's curve (against 0.02 m/s of
# pelvis velocity), and error of the walking speed
_BEND_DEG = 1.0
_VELOCITY_TOLERANCE_M_S = 0.02
_SPEED_TOLERANCE_M_S = 1e-5


@dataclass(frozen=True)
class WalkingPattern:
    """Steady walking of one person at one speed.

    Parameters
    ----------
    speed_m_s : float
        Walking speed.
    stride_s : float
        Duration of a stride.
    toe_off : float
        Phase of the stride at which the foot leaves the ground.
    left_lag : float
        Phase of the right leg at which the left heel strikes.
    curves : dict of str to ndarray of complex, shape (3, K + 1)
        Fourier coefficients in rad of ``pelvis``, ``hip_right``, ``knee_right``, ``hip_left``,
        ``knee_left``.
    runs : bool
        Whether the person runs; the curves then have the timing of running.
    """

    speed_m_s: float
    stride_s: float
    toe_off: float
    left_lag: float
    curves: dict[str, ComplexArray]
    runs: bool = False

    def leg_phase(self, joint: str, phase: FloatArray) -> FloatArray:
        """Return the phase of the leg that a joint belongs to (the right one for the pelvis).

        Parameters
        ----------
        joint : str
            One of `JOINTS`.
        phase : ndarray
            Phase of the right leg.

        Returns
        -------
        ndarray
            Phase of that leg, an integer at its heel strike.
        """
        return phase - self.left_lag if joint.endswith("_left") else phase

    def joint_angles(self, phase: FloatArray) -> dict[str, FloatArray]:
        """Evaluate all joint angles.

        Parameters
        ----------
        phase : ndarray, shape (N,)
            Phase of the right leg.

        Returns
        -------
        dict of str to ndarray, shape (N, 3)
            Angles in rad for each of `JOINTS`.
        """
        angles = {}
        for joint in JOINTS:
            of_leg = self.leg_phase(joint, phase)
            in_table = of_leg if self.runs else table_phase(of_leg, self.toe_off)
            angles[joint] = evaluate(self.curves[joint], in_table)
        return angles


def stride_frequency_hz(speed_m_s: float, height_m: float) -> float:
    """Predict the stride frequency of treadmill walking.

    Parameters
    ----------
    speed_m_s : float
        Walking speed.
    height_m : float
        Body height.

    Returns
    -------
    float
        Strides per second.

    Notes
    -----
    Grieve and Gear (Ergonomics 9:379-399, 1966): 64.8 strides per minute times the speed in
    statures per second to the power 0.57. The factor 1.1 is for the treadmill, where the cadence is
    higher (Alton et al., Clin Biomech 13:434-440, 1998); with it the stride counts of the five
    walkers agree with those of Tham et al. (1109, 1272 and 1413 in 25 min each).
    """
    return 1.1 * 64.8 / 60.0 * (speed_m_s / height_m) ** 0.57


def toe_off_phase(speed_m_s: float) -> float:
    """Predict the stance fraction of the stride.

    Parameters
    ----------
    speed_m_s : float
        Walking speed.

    Returns
    -------
    float
        0.63 at 1.3 m/s and 0.055 more for each m/s less (within the range of Murray et al.,
        1984, and Hebenstreit et al., Hum Mov Sci 41:22-38, 2015).
    """
    return float(np.clip(0.63 - 0.055 * (speed_m_s - 1.3), 0.58, 0.70))


def walking_pattern(
    subject: str,
    body: Body,
    speed_m_s: float,
    seed: int,
    swings_outwards: bool = False,
    runs: bool = False,
) -> WalkingPattern:
    """Draw the gait of one person at a speed.

    Parameters
    ----------
    subject : str
        Name; it determines the individual deviations from the mean, which are the same at every
        speed.
    body : Body
        Size.
    speed_m_s : float
        Walking speed.
    seed : int
        Seed of the data set.
    swings_outwards : bool, optional
        Walk with the legs swung outwards (`narx.simulation.gait_curves.swing_outwards`).
    runs : bool, optional
        Run (`narx.simulation.running`).

    Returns
    -------
    WalkingPattern
        In walking, hip flexion and abduction are adjusted so that stance feet that neither slip
        nor sink carry the pelvis at `speed_m_s` with the usual fluctuation (`pelvis_velocity`).
    """
    rng = stream(seed, subject, "walking pattern")
    mean = running_curves(speed_m_s) if runs else joint_curves(speed_m_s)
    if swings_outwards:
        mean = swing_outwards(mean)
    curves = {"pelvis": _individual(rng, mean["pelvis"], _OFFSET_SD_DEG["pelvis"], 1.0)}
    # the pelvis has one more symmetry than the legs: zero mean obliquity and rotation
    curves["pelvis"][1:, 0] *= 0.3
    for joint in ("hip", "knee"):
        person = _individual(rng, mean[joint], _OFFSET_SD_DEG[joint], 1.0)
        for side in SIDES:
            curves[f"{joint}_{side}"] = _individual(rng, person, _OFFSET_SD_DEG[joint], _ASYMMETRY)
    usual_hz = STRIDE_HZ if runs else stride_frequency_hz(speed_m_s, body.height_m)
    frequency = usual_hz * (1.0 + 0.03 * rng.standard_normal())
    toe_off = TOE_OFF if runs else toe_off_phase(speed_m_s)
    pattern = WalkingPattern(
        speed_m_s=speed_m_s,
        stride_s=1.0 / frequency,
        toe_off=toe_off + 0.006 * float(rng.standard_normal()),
        left_lag=0.5 + 0.005 * float(rng.standard_normal()),
        curves=curves,
        runs=runs,
    )
    return pattern if runs else _agree_with_feet(pattern, body)


def _agree_with_feet(pattern: WalkingPattern, body: Body) -> WalkingPattern:
    """Adjust the hip curves so that the stance feet carry the pelvis evenly at the right speed.

    Iterated linear least squares: the velocity from the feet is nearly linear in the hip angles.
    """
    n = 64
    phase = np.arange(3 * n) / n
    stride = slice(n, 2 * n)
    rate_hz = n / pattern.stride_s
    wanted = pelvis_velocity(phase[stride], pattern.speed_m_s, pattern.stride_s)
    channels, order = (0, 1), pattern.curves["hip_right"].shape[1]
    size = len(channels) * (order - 1) * 2
    angle = np.radians(_BEND_DEG)

    def bent(bend: FloatArray) -> WalkingPattern:
        parts = angle * bend.reshape(2, len(channels), order - 1)
        curves = dict(pattern.curves)
        for side in SIDES:
            curves[f"hip_{side}"] = curves[f"hip_{side}"].copy()
            curves[f"hip_{side}"][channels, 1:] += parts[0] + 1j * parts[1]
        return replace(pattern, curves=curves)

    def residual(bend: FloatArray) -> FloatArray:
        angles = bent(bend).joint_angles(phase)
        velocity = forward_velocity(
            angles, phase, pattern.toe_off, pattern.left_lag, body, rate_hz
        )[stride, :2]
        mean_speed = velocity[:, 0].mean() - pattern.speed_m_s
        return np.concatenate(
            [
                ((velocity - wanted[:, :2]) / _VELOCITY_TOLERANCE_M_S / np.sqrt(n)).ravel(),
                [mean_speed / _SPEED_TOLERANCE_M_S],
                bend,
            ]
        )

    solution = np.zeros(size)
    now = residual(solution)
    slopes = np.column_stack([residual(unit) - now for unit in np.eye(size)])
    for _ in range(4):
        solution = solution - np.linalg.lstsq(slopes, now, rcond=None)[0]
        now = residual(solution)
    return bent(solution)


def pelvis_velocity(phase: FloatArray, speed_m_s: float, stride_s: float) -> FloatArray:
    """Return the usual velocity of the pelvis over ground.

    Parameters
    ----------
    phase : ndarray, shape (N,)
        Phase of the right leg.
    speed_m_s : float
        Walking speed.
    stride_s : float
        Duration of a stride.

    Returns
    -------
    ndarray, shape (N, 2)
        Forwards: 6 % faster about heel strikes than in between; to the left: once to and fro
        per stride over a width of 7 cm at 0.7 m/s and 4 cm at 1.6 m/s (Orendurff et al., J
        Rehabil Res Dev 41:829-834, 2004), m/s.
    """
    half_width = 0.5 * np.clip(0.07 - 0.034 * (speed_m_s - 0.7), 0.03, 0.08)
    forward = speed_m_s * (1.0 + 0.06 * np.cos(4.0 * np.pi * (phase - 0.06)))
    to_left = half_width * 2.0 * np.pi / stride_s * np.sin(2.0 * np.pi * (phase - 0.35))
    return np.column_stack([forward, to_left])


def _individual(
    rng: np.random.Generator, curves: ComplexArray, offset_sd_deg: tuple[float, ...], share: float
) -> ComplexArray:
    """Vary curves at random in offset, size, shape and timing, by `share` of the population SD."""
    channels, order = curves.shape
    harmonic = np.arange(order)
    size = 1.0 + share * _SIZE_SD * rng.standard_normal((channels, 1))
    shape = 1.0 + share * _HARMONIC_SD * (
        rng.standard_normal((channels, order)) + 1j * rng.standard_normal((channels, order))
    )
    shape[:, 0] = 1.0
    shift = share * _TIMING_SD * rng.standard_normal((channels, 1))
    bent = curves * size * shape * np.exp(2j * np.pi * harmonic * shift)
    bent[:, 0] += share * np.radians(offset_sd_deg) * rng.standard_normal(channels)
    return np.asarray(bent)
