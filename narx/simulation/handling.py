"""A sensor that is held in a hand before the walk, and put where it belongs."""

import numpy as np

from narx.simulation.calculus import smooth_step
from narx.simulation.random_numbers import smooth_noise
from narx.types import FloatArray

# all *assumed*: by how much the sensor is turned in the hand, how it moves there, and how long it
# takes to put it on the segment (a phone into a pocket)
HELD_DEG = (40.0, 80.0)
HAND_SD_DEG, HAND_BANDWIDTH_HZ = 8.0, 1.0
PUT_S = 1.2


def hand_turn_rad(rng: np.random.Generator, time_s: FloatArray, handling_s: float) -> FloatArray:
    """Rotation of a sensor in a hand relative to where it will be on the segment.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    time_s : ndarray, shape (N,)
        Clock of the recording.
    handling_s : float
        When the sensor is in its place, s.

    Returns
    -------
    ndarray, shape (N, 3)
        Rotation vector in the segment's anatomical frame, rad; zero from `handling_s` on.
    """
    axis = rng.standard_normal(3)
    held = np.radians(rng.uniform(*HELD_DEG)) * axis / np.linalg.norm(axis)
    # bounds in whole seconds, so that the motion is the same at every sampling rate
    begin, end = np.floor(time_s[0]) - 1.0, np.ceil(time_s[-1]) + 1.0
    moving = smooth_noise(rng, begin, end, HAND_BANDWIDTH_HZ, 3)(time_s) * np.radians(HAND_SD_DEG)
    in_hand = smooth_step((handling_s - time_s) / PUT_S)
    return np.asarray(in_hand[:, None] * (held + moving))
