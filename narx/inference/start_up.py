"""Start-up: estimation of the posture, the network's zero, in the first seconds.

A gyroscope has no absolute angle, and a network with a leak towards zero forgets the mean angle of
a walk (a knee is flexed by some 20 degrees on average). There are two cases:

- The start pose is known (standing in the calibration posture). The rates are integrated, with
  little drift over a dozen seconds; the mean angle of early strides becomes the posture. From then
  on the network computes the deviation from it.
- The start pose is unknown. The integral leaks towards zero, strongly at first and then less and
  less (the gain of a growing memory), and the posture is zero.

Only time in movement counts, so standing at the beginning extends the start-up. At the hand-over
the angle is the sum of posture and deviation in both cases, so there is no jump.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from narx.kernels.start_up import KNOWN, MOVING_S, STATE_SIZE, run_start_up, split_for_network
from narx.settings import PositiveSeconds, Seconds, check_fields
from narx.types import FloatArray

# layout of the state
ANGLES, RATES, POSTURE = slice(0, 3), slice(3, 6), slice(6, 9)


@dataclass(frozen=True)
class StartUp:
    """Parameters of the start-up.

    Parameters
    ----------
    duration_s : float
        Movement before the network takes over, s; 0 starts the network immediately from zero.
    averaging_s : float
        Duration of movement over which the posture is averaged with a Hann window, so that all
        parts of a stride have equal weight, s.
    averaging_begin_s : float
        Movement before this window, s; reduced if the window would not end before the start-up.
        The window is early, because the remaining bias is integrated, but excludes the first
        steps, which are not steady.
    leak_rad_s : float
        Leak of an unknown start, rad/s.
    settling_gain : float
        At time t the leak is increased by ``settling_gain / (t + settling_s)``.
    settling_s : float
        See `settling_gain`, s.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    duration_s: Seconds = 12.0
    averaging_s: PositiveSeconds = 6.0
    averaging_begin_s: Seconds = 2.0
    leak_rad_s: Annotated[float, Field(ge=0, le=100)] = 0.1
    settling_gain: Annotated[float, Field(ge=0, le=1000)] = 2.0
    settling_s: PositiveSeconds = 0.5

    def __post_init__(self) -> None:
        check_fields(self, "start_up")

    @property
    def averaged_from_s(self) -> float:
        """Movement before the posture is averaged, s."""
        return min(self.averaging_begin_s, self.duration_s - self.averaging_s)

    def begin(self, initial_angles_rad: FloatArray | None) -> FloatArray:
        """State before the first sample.

        Parameters
        ----------
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose; None if it is unknown.

        Returns
        -------
        ndarray, shape (14,)
            Angles (3), latest coupled rates (3), weighted sum of angles (3) and its weight,
            time and time in movement in s, mean square of the rates, 1 if the start is known.
        """
        state = np.zeros(STATE_SIZE)
        if initial_angles_rad is not None:
            state[ANGLES] = initial_angles_rad
            state[KNOWN] = 1.0
        return state

    def is_over(self, state: FloatArray) -> bool:
        """Return whether the network takes over at the next sample.

        Parameters
        ----------
        state : ndarray, shape (14,)
            From `begin`, updated by `run`.

        Returns
        -------
        bool
            True once there has been enough movement.
        """
        return bool(state[MOVING_S] >= self.duration_s)

    def run(
        self,
        axis_rates_rad_s: FloatArray,
        interval_s: float,
        state: FloatArray,
        coupled: bool = True,
    ) -> FloatArray:
        """Advance until there has been enough movement, or the samples end.

        Parameters
        ----------
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes, rad/s.
        interval_s : float
            Sampling interval, s.
        state : ndarray, shape (14,)
            From `begin` or an earlier call; changed in place.
        coupled : bool
            Whether the network that takes over is coupled.

        Returns
        -------
        ndarray, shape (n, 3)
            Angles in rad of the n <= N samples used by the start-up.
        """
        rates = np.ascontiguousarray(axis_rates_rad_s, dtype=np.float64)
        angles = np.empty_like(rates)
        n = run_start_up(
            rates,
            interval_s,
            self.duration_s,
            self.averaged_from_s,
            self.averaging_s,
            self.leak_rad_s,
            self.settling_gain,
            self.settling_s,
            coupled,
            state,
            angles,
        )
        return angles[:n]

    @staticmethod
    def hand_over(
        state: FloatArray, interval_s: float
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Derive the initial values of the network that takes over.

        Parameters
        ----------
        state : ndarray, shape (14,)
            State after the last sample of the start-up.
        interval_s : float
            Sampling interval, s.

        Returns
        -------
        posture, deviation, previous_deviation, rates : ndarray, shape (3,)
            Posture of the network, its last two outputs and its last input, in
            rad and rad/s.
        """
        posture, deviation, earlier = np.empty((3, 3))
        split_for_network(state, interval_s, posture, deviation, earlier)
        return posture, deviation, earlier, state[RATES].copy()
