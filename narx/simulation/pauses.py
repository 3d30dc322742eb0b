"""Pauses of a walker, who stands or sits down and walks on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from narx.simulation.calculus import smooth_step
from narx.simulation.parts import check_parts
from narx.types import FloatArray

# time in which the steps become smaller until the walker stands, and larger again; time of sitting
# down or standing up (healthy adults take 1.5 to 2 s; Kralj et al., J Biomech 23:1123, 1990, whose
# figure is rounded)
HALT_S, SIT_S = 1.5, 1.8
# flexion of hip and knee in sitting, *assumed*
SEATED_RAD = np.radians(80.0)


@dataclass(frozen=True)
class Pauses:
    """When a walker pauses.

    Parameters
    ----------
    parts_s : sequence of tuple of (float, float)
        From the last full step to the next one, s; none by default.
    sits : bool
        Whether the walker sits down in them.
    """

    parts_s: Sequence[tuple[float, float]] = ()
    sits: bool = False

    def check(self, protocol: str, first_s: float, last_s: float) -> None:
        """Refuse pauses that the walk has no room for.

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
        least_s = 2.0 * (HALT_S + SIT_S * self.sits)
        check_parts("pauses_s", self.parts_s, protocol, least_s, first_s, last_s)

    def walking(self, time_s: FloatArray) -> FloatArray:
        """Size of the steps.

        Parameters
        ----------
        time_s : ndarray, shape (N,)
            Moments.

        Returns
        -------
        ndarray, shape (N,)
            1 in walking, 0 in a pause.
        """
        return 1.0 - self._share(time_s, 0.0, HALT_S)

    def seat_rad(self, time_s: FloatArray) -> FloatArray:
        """Flexion of hips and knees by sitting.

        Parameters
        ----------
        time_s : ndarray, shape (N,)
            Moments.

        Returns
        -------
        ndarray, shape (N,)
            rad; zero while the walker moves the feet.
        """
        return SEATED_RAD * self.sits * self._share(time_s, HALT_S, SIT_S)

    def without(self, times_s: FloatArray) -> FloatArray:
        """Leave out events in pauses.

        Parameters
        ----------
        times_s : ndarray, shape (E,)
            Times of events.

        Returns
        -------
        ndarray
            Those in walking.
        """
        inside = [(begin < times_s) & (times_s < end) for begin, end in self.parts_s]
        return times_s[~np.any(inside, axis=0)] if inside else times_s

    def _share(self, time_s: FloatArray, margin_s: float, ramp_s: float) -> FloatArray:
        share = np.zeros(len(time_s))
        for begin, end in self.parts_s:
            rise = smooth_step((time_s - begin - margin_s) / ramp_s)
            share += rise * smooth_step((end - margin_s - time_s) / ramp_s)
        return share
