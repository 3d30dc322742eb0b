"""Pelvis, thighs and shanks in space, carried by feet that neither slip nor sink.

Global and anatomical frames as in `narx.kinematics.segment_angles`: x forward, y left, z up; all
segments are aligned with the global frame in standing. Joint angles are in the order flexion,
abduction, internal rotation, positive alike for both legs (the left leg is the mirror image of a
right one), in the joint coordinate system of Grood and Suntay (J Biomech Eng 105:136-144, 1983).
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose, from_angles
from narx.simulation.body import Body
from narx.simulation.calculus import derivative, second_derivative, smooth_step
from narx.types import FloatArray

SIDES = ("right", "left")
SEGMENTS = ("pelvis", "thigh_right", "shank_right", "thigh_left", "shank_left")

GRAVITY_UP = np.array([0.0, 0.0, 1.0])

# the foot rolls like an arc of 0.3 leg lengths (McGeer, Int J Robot Res 9:62, 1990; Adamczyk et
# al., J Exp Biol 209:3953, 2006, after Hansen et al.) and bears the weight in front of the ankle
# in standing (Winter, Gait & Posture 3:193, 1995)
ROLL_RADIUS_PER_LEG = 0.3
PRESSURE_CENTRE_PER_LEG = 0.05
# interval in which the leading foot takes over, as fractions of double support. Horizontal: early,
# since the trailing foot soon pivots on its toes. Vertical: from before heel strike, when push-off
# begins to reverse the fall of the body, until toe-off.
LEVEL_HANDOVER = (0.1, 0.8)
VERTICAL_HANDOVER = (-0.3, 1.0)


def segment_orientations(joint_angles: dict[str, FloatArray]) -> dict[str, Rotation]:
    """Convert joint angles to the orientation of every segment.

    Parameters
    ----------
    joint_angles : dict of str to ndarray, shape (N, 3)
        ``pelvis`` (forward tilt, right side down, right side forward) and ``hip_right``,
        ``knee_right``, ``hip_left``, ``knee_left`` (flexion, abduction, internal rotation), rad.

    Returns
    -------
    dict of str to scipy.spatial.transform.Rotation
        From the anatomical frame to the global frame, for each of `SEGMENTS`.
    """
    pelvis = from_angles("ZXY", joint_angles["pelvis"][:, ::-1])
    orientations = {"pelvis": pelvis}
    for side in SIDES:
        thigh = compose(pelvis, _joint_rotation(joint_angles[f"hip_{side}"], -1.0, side))
        orientations[f"thigh_{side}"] = thigh
        orientations[f"shank_{side}"] = compose(
            thigh, _joint_rotation(joint_angles[f"knee_{side}"], 1.0, side)
        )
    return orientations


def _joint_rotation(angles: FloatArray, flexion_sign: float, side: str) -> Rotation:
    """Distal relative to proximal segment; flexion turns the hip about -y and the knee about y."""
    # mirroring reverses rotations about x and z
    mirror = -1.0 if side == "left" else 1.0
    return from_angles("YXZ", angles * [flexion_sign, -mirror, mirror])


def joint_centres(orientations: dict[str, Rotation], body: Body) -> dict[str, FloatArray]:
    """Locate the proximal joint centre of every segment relative to the middle of the hips.

    Parameters
    ----------
    orientations : dict of str to scipy.spatial.transform.Rotation
        From `segment_orientations`.
    body : Body
        Size.

    Returns
    -------
    dict of str to ndarray, shape (N, 3)
        For each of `SEGMENTS` (the pelvis itself: zero) and ``ankle_right``, ``ankle_left``,
        global axes, m.
    """
    centres = {"pelvis": np.zeros((len(orientations["pelvis"]), 3))}
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        thigh, shank = orientations[f"thigh_{side}"], orientations[f"shank_{side}"]
        hip = orientations["pelvis"].apply([0.0, 0.5 * sign * body.hip_distance_m, 0.0])
        knee = hip + thigh.apply([0.0, 0.0, -body.thigh_m])
        centres[f"thigh_{side}"] = hip
        centres[f"shank_{side}"] = knee
        centres[f"ankle_{side}"] = knee + shank.apply([0.0, 0.0, -body.shank_m])
    return centres


def stance_share(
    phase: FloatArray, toe_off: float, left_lag: float, window: tuple[float, float] = (0.0, 1.0)
) -> FloatArray:
    """Share of the body carried by the right foot.

    Parameters
    ----------
    phase : ndarray
        Phase of the right leg.
    toe_off : float
        Phase of the leg at which its foot leaves the ground.
    left_lag : float
        Phase of the right leg at which the left heel strikes.
    window : tuple of (float, float), optional
        Part of double support, from heel strike (0) to the other foot's toe-off (1), in which the
        load is transferred.

    Returns
    -------
    ndarray
        1 in right, 0 in left single stance, smooth between.
    """
    begin, length = window[0], window[1] - window[0]
    # the stride is cut in right swing, where no load is transferred
    right = np.mod(phase + 0.25, 1.0) - 0.25
    to_right = (right / (toe_off + left_lag - 1.0) - begin) / length
    to_left = ((right - left_lag) / (toe_off - left_lag) - begin) / length
    return smooth_step(to_right) - smooth_step(to_left)


def forward_velocity(
    joint_angles: dict[str, FloatArray],
    phase: FloatArray,
    toe_off: float,
    left_lag: float,
    body: Body,
    rate_hz: float,
) -> FloatArray:
    """Compute the velocity of the pelvis over ground from the stance feet.

    Parameters
    ----------
    joint_angles : dict of str to ndarray, shape (N, 3)
        As in `segment_orientations`.
    phase : ndarray, shape (N,)
        Phase of the right leg.
    toe_off, left_lag : float
        As in `stance_share`.
    body : Body
        Size.
    rate_hz : float
        Sampling rate.

    Returns
    -------
    ndarray, shape (N, 3)
        Velocity of the middle of the hips in m/s; the forward component is the walking speed.

    Notes
    -----
    The centre of a rolling arc moves forwards by radius times pitch rate and neither sideways
    nor up. Around double support the velocities from the two feet are blended by `stance_share`.
    """
    orientations = segment_orientations(joint_angles)
    centres = joint_centres(orientations, body)
    demands = [
        _velocity_from_foot(orientations[f"shank_{side}"], centres[f"ankle_{side}"], body, rate_hz)
        for side in SIDES
    ]
    velocity = demands[1]
    for columns, window in ((slice(0, 2), LEVEL_HANDOVER), (slice(2, 3), VERTICAL_HANDOVER)):
        share = stance_share(phase, toe_off, left_lag, window)[:, None]
        velocity[:, columns] += share * (demands[0] - demands[1])[:, columns]
    return velocity


def _velocity_from_foot(
    shank: Rotation, ankle: FloatArray, body: Body, rate_hz: float
) -> FloatArray:
    radius = ROLL_RADIUS_PER_LEG * body.leg_m
    arc_centre = ankle + shank.apply(
        [PRESSURE_CENTRE_PER_LEG * body.leg_m, 0.0, radius - body.ankle_height_m]
    )
    velocity = -derivative(arc_centre, rate_hz)
    up = shank.apply(GRAVITY_UP)
    velocity[:, 0] += radius * derivative(np.unwrap(np.arctan2(up[:, 0], up[:, 2])), rate_hz)
    return velocity


@dataclass(frozen=True)
class SkeletonMotion:
    """Motion of all segments on a uniform clock.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Clock.
    rate_hz : float
        Its rate.
    joint_angles : dict of str to ndarray, shape (N, 3)
        As in `segment_orientations`.
    orientations : dict of str to scipy.spatial.transform.Rotation
        Segment to global, N each.
    centres_m : dict of str to ndarray, shape (N, 3)
        Proximal joint centre of each segment relative to the middle of the hips.
    pelvis_m : ndarray, shape (N, 3)
        Middle of the hips in the global frame.
    impact_m : dict of str to ndarray, shape (N, 3)
        Shock wave of the heel strikes: displacement of points fixed to a segment.
    """

    time_s: FloatArray
    rate_hz: float
    joint_angles: dict[str, FloatArray]
    orientations: dict[str, Rotation]
    centres_m: dict[str, FloatArray]
    pelvis_m: FloatArray
    impact_m: dict[str, FloatArray] = field(default_factory=dict)

    def position(self, segment: str, offset_m: FloatArray) -> FloatArray:
        """Return the position of a point that is fixed to a segment.

        Parameters
        ----------
        segment : str
            One of `SEGMENTS`.
        offset_m : ndarray, shape (3,)
            From the proximal joint centre, in the anatomical frame.

        Returns
        -------
        ndarray, shape (N, 3)
            Position in the global frame, m.
        """
        point = self.pelvis_m + self.centres_m[segment]
        point += self.orientations[segment].apply(offset_m)
        if segment in self.impact_m:
            point += self.impact_m[segment]
        return point

    def acceleration(self, segment: str, offset_m: FloatArray) -> FloatArray:
        """Differentiate `position` twice.

        Parameters
        ----------
        segment : str
            One of `SEGMENTS`.
        offset_m : ndarray, shape (3,)
            From the proximal joint centre, in the anatomical frame.

        Returns
        -------
        ndarray, shape (N, 3)
            Acceleration in the global frame, m/s^2.
        """
        return second_derivative(self.position(segment, offset_m), self.rate_hz)


def move(
    time_s: FloatArray, rate_hz: float, joint_angles: dict[str, FloatArray], body: Body
) -> SkeletonMotion:
    """Move the segments while the pelvis stays in place.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Clock.
    rate_hz : float
        Its rate.
    joint_angles : dict of str to ndarray, shape (N, 3)
        As in `segment_orientations`.
    body : Body
        Size.

    Returns
    -------
    SkeletonMotion
        Without walking.
    """
    orientations = segment_orientations(joint_angles)
    return SkeletonMotion(
        time_s,
        rate_hz,
        joint_angles,
        orientations,
        joint_centres(orientations, body),
        np.tile([0.0, 0.0, body.leg_m], (len(time_s), 1)),
    )
