"""Turns of a walker, who walks over ground and leans into them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from narx.kinematics.rotations import compose, from_angles
from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.calculus import derivative, integral, smooth_step
from narx.simulation.parts import check_parts
from narx.simulation.skeleton import SkeletonMotion
from narx.types import FloatArray

# a turn on one foot takes half a second (*assumed*)
SHORTEST_TURN_S = 0.5


@dataclass(frozen=True)
class Turns:
    """When and by how much a walker turns.

    Parameters
    ----------
    parts_s : sequence of tuple of (float, float)
        Begin and end of every turn, s; none by default.
    turn_deg : float
        Angle of each, to the left and to the right in turn.
    """

    parts_s: Sequence[tuple[float, float]] = ()
    turn_deg: float = 180.0

    def __bool__(self) -> bool:
        return bool(self.parts_s)

    def check(self, protocol: str, first_s: float, last_s: float) -> None:
        """Refuse turns that the walk has no room for.

        Parameters
        ----------
        protocol : str
            Of the recording.
        first_s, last_s : float
            Full steps from then on, and end of the recording, s.

        Raises
        ------
        UserError
            As `narx.simulation.parts.check_parts`.
        """
        check_parts("turns_s", self.parts_s, protocol, SHORTEST_TURN_S, first_s, last_s)

    def heading_rad(self, time_s: FloatArray) -> FloatArray:
        """Heading of the walker.

        Parameters
        ----------
        time_s : ndarray, shape (N,)
            Moments.

        Returns
        -------
        ndarray, shape (N,)
            rad, to the left of the first direction.
        """
        heading, side = np.zeros(len(time_s)), 1.0
        for begin, end in self.parts_s:
            turned = smooth_step((time_s - begin) / (end - begin))
            heading += side * np.radians(self.turn_deg) * turned
            side = -side
        return heading

    def turned(self, motion: SkeletonMotion, speed_m_s: float) -> SkeletonMotion:
        """Turn a walker.

        Parameters
        ----------
        motion : SkeletonMotion
            Over ground, straight ahead.
        speed_m_s : float
            Walking speed, which determines the lean into a turn.

        Returns
        -------
        SkeletonMotion
            The path follows the heading; the body leans by atan(speed * turn rate / g), so that the
            force on it stays in its median plane.
        """
        heading = self.heading_rad(motion.time_s)
        rate = derivative(heading, motion.rate_hz)
        lean = -np.arctan(speed_m_s * rate / GRAVITY_M_S2)
        body = from_angles("ZX", np.column_stack([heading, lean]))
        course = Rotation.from_rotvec(np.outer(heading, [0.0, 0.0, 1.0]))
        height = np.array([0.0, 0.0, motion.pelvis_m[0, 2]])
        path = integral(course.apply(derivative(motion.pelvis_m, motion.rate_hz)), motion.rate_hz)
        return replace(
            motion,
            orientations={name: compose(body, r) for name, r in motion.orientations.items()},
            centres_m={name: body.apply(centre) for name, centre in motion.centres_m.items()},
            pelvis_m=path + body.apply(height),
        )
