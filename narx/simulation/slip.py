"""A sensor that slips on its segment and stays as it has come to rest."""

from collections.abc import Sequence

import numpy as np

from narx.simulation.calculus import smooth_step
from narx.types import FloatArray

# duration of a slip, *assumed*
SLIP_S = 0.3


def slip_turn_rad(
    rng: np.random.Generator, time_s: FloatArray, slips_s: Sequence[float], slip_rad: float
) -> FloatArray:
    """Rotation of a sensor relative to its first place on the segment.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness: the axis of every slip.
    time_s : ndarray, shape (N,)
        Clock of the recording.
    slips_s : sequence of float
        When a slip begins, s.
    slip_rad : float
        Its angle.

    Returns
    -------
    ndarray, shape (N, 3)
        Rotation vector in the segment's anatomical frame, rad.
    """
    turn = np.zeros((len(time_s), 3))
    for at_s in slips_s:
        axis = rng.standard_normal(3)
        slipped = smooth_step((time_s - at_s) / SLIP_S)
        turn += slip_rad * slipped[:, None] * axis / np.linalg.norm(axis)
    return turn
