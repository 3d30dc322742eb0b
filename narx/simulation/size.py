"""Estimate the size of a simulated data set before simulation."""

from narx.errors import UserError

# more would take months of computing
MOST_TRIALS = 100_000
# peak memory measured with one and with four sensors
_BYTES_A_SAMPLE = 1300
MOST_GIB = 2.5
_LONGEST_STEP_S = 1.0


def longest_walk_s(stand_s: tuple[float, float], steps: tuple[int, int]) -> float:
    """Estimate how long a walk over ground can last.

    Parameters
    ----------
    stand_s : tuple of (float, float)
        Shortest and longest stand before and after, s.
    steps : tuple of (int, int)
        Fewest and most steps.

    Returns
    -------
    float
        Upper estimate, s.
    """
    return 2.0 * stand_s[1] + _LONGEST_STEP_S * steps[1]


def check_size(n_trials: int, longest_s: float, motion_rate_hz: float) -> None:
    """Refuse a data set that is too large to simulate.

    Parameters
    ----------
    n_trials : int
        Number of trials.
    longest_s : float
        Length of the longest, s.
    motion_rate_hz : float
        Rate at which motion is computed, Hz.

    Raises
    ------
    UserError
        If there are too many trials, or one of them would not fit into memory.
    """
    if n_trials > MOST_TRIALS:
        raise UserError(
            f"simulated_gait: {n_trials} trials (subjects times conditions times "
            f"trials_per_condition), expected at most {MOST_TRIALS}"
        )
    gib = _BYTES_A_SAMPLE * longest_s * motion_rate_hz / 2**30
    if gib > MOST_GIB:
        raise UserError(
            f"simulated_gait: a walk of {longest_s:g} s, computed at {motion_rate_hz:g} Hz, takes "
            f"some {gib:.2g} GiB of memory, expected at most {MOST_GIB:g}; shorten it or lower "
            "sampling_rate_hz"
        )
