"""Motion of a sensor relative to its segment: in a hand before the walk, and by slips."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from narx.errors import UserError
from narx.kinematics.rotations import compose
from narx.simulation.handling import PUT_S, hand_turn_rad
from narx.simulation.slip import SLIP_S, slip_turn_rad
from narx.types import FloatArray


@dataclass(frozen=True)
class Attachment:
    """When a sensor moves relative to its segment.

    Parameters
    ----------
    handling_s : float
        Time in a hand before the walk, s.
    slips_s : sequence of float
        Times of slips, s.
    slip_deg : float
        Angle of a slip.
    """

    handling_s: float = 0.0
    slips_s: Sequence[float] = ()
    slip_deg: float = 20.0

    def __bool__(self) -> bool:
        return self.handling_s > 0.0 or bool(self.slips_s)

    def check(self, protocol: str, first_s: float, last_s: float) -> None:
        """Refuse times for which there is no room.

        Parameters
        ----------
        protocol : str
            Of the recording.
        first_s, last_s : float
            Full steps from then on, and end of the recording, s.

        Raises
        ------
        UserError
            If the sensor is in the hand for less time than it takes to put it on the segment, or
            slips not on a treadmill, outside the walk, or during another slip.
        """
        if 0.0 < self.handling_s < PUT_S:
            raise UserError(
                f"handling_s is {self.handling_s:g}, expected 0 or at least {PUT_S:g} s"
            )
        if self.slips_s and protocol != "treadmill":
            raise UserError(f"slips_s is for protocol=treadmill, found protocol={protocol}")
        before_s = first_s
        for at_s in self.slips_s:
            if not before_s <= at_s <= last_s - SLIP_S:
                raise UserError(
                    f"slips_s has {at_s:g}, expected rising times, at least {SLIP_S:g} s apart, "
                    f"from {first_s:g} to {last_s - SLIP_S:g} s"
                )
            before_s = at_s + SLIP_S

    def rotation(self, rng: np.random.Generator, time_s: FloatArray) -> Rotation:
        """Rotation of the sensor relative to where it would be if it were fixed to the segment.

        Parameters
        ----------
        rng : numpy.random.Generator
            Source of randomness.
        time_s : ndarray, shape (N,)
            Clock of the recording.

        Returns
        -------
        scipy.spatial.transform.Rotation
            N rotations, from the frame that the sensor carries to the anatomical frame.
        """
        slipped = slip_turn_rad(rng, time_s, self.slips_s, np.radians(self.slip_deg))
        if self.handling_s == 0.0:
            return Rotation.from_rotvec(slipped)
        held = hand_turn_rad(rng, time_s, self.handling_s)
        return compose(Rotation.from_rotvec(slipped), Rotation.from_rotvec(held))


def carried(wxyz: FloatArray, rotation: Rotation) -> FloatArray:
    """Orientation of the frame that a sensor carries.

    Parameters
    ----------
    wxyz : ndarray, shape (N, 4)
        Of the segment, to the global frame; NaN where unknown.
    rotation : scipy.spatial.transform.Rotation
        N rotations from `Attachment.rotation`.

    Returns
    -------
    ndarray, shape (N, 4)
        To the global frame; NaN where unknown.
    """
    found = np.full_like(wxyz, np.nan)
    there = np.isfinite(wxyz).all(axis=1)
    segment = Rotation.from_quat(wxyz[there], scalar_first=True)
    found[there] = compose(segment, rotation[there]).as_quat(scalar_first=True)
    return found
