"""The first seconds: find the posture about which the network then works.

A gyroscope does not know where zero is, and a network that leaks towards zero forgets the mean
angle of a walk (a knee is bent by some 20 degrees on average). What is known at the start decides:

- The start pose is known (standing in the calibration posture). The rates are integrated, which
  for that long drifts little, and a slow low-pass of the integral, averaged over its last
  seconds so that no part of a stride is frozen in it, becomes the posture. From then on the
  network works on the deviation from it.
- The start pose is unknown. The integral leaks towards zero, strongly at first and less and less
  (the gain of a growing memory), and the posture is zero.

At the hand-over the angle is the sum of posture and deviation in both cases, so nothing jumps.
"""

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from narx.cell import SMALLEST_COS_FRONTAL

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class StartUp:
    """Parameters of the start-up.

    Parameters
    ----------
    duration_s : float
        Time before the network takes over, s; 0 starts the network at once from zero.
    leak_rad_s : float
        Corner frequency that separates posture from deviation, rad/s.
    settling_gain : float
        At time t the leak is larger by ``settling_gain / (t + settling_s)``.
    settling_s : float
        See `settling_gain`, s.
    averaging_s : float
        End of the start-up over which the posture is averaged, s.
    """

    duration_s: float = 40.0
    leak_rad_s: float = 0.1
    settling_gain: float = 2.0
    settling_s: float = 0.5
    averaging_s: float = 10.0

    def begin(self, initial_angles_rad: FloatArray | None) -> FloatArray:
        """State before the first sample.

        Parameters
        ----------
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose; None where it is unknown.

        Returns
        -------
        ndarray, shape (15,)
            Angles (3), leaky angles (3), latest coupled rates (3), sum of postures (3), samples
            in that sum, time in s, and 1 where the start is known.
        """
        state = np.zeros(15)
        if initial_angles_rad is not None:
            state[0:3] = initial_angles_rad
            state[14] = 1.0
        return state

    def run(
        self,
        axis_rates_rad_s: FloatArray,
        interval_s: float,
        state: FloatArray,
        coupled: bool = True,
    ) -> FloatArray:
        """Advance over some samples.

        Parameters
        ----------
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes, rad/s.
        interval_s : float
            Sampling interval, s.
        state : ndarray, shape (15,)
            From `begin` or an earlier piece; changed in place.
        coupled : bool
            As the network that takes over.

        Returns
        -------
        ndarray, shape (N, 3)
            Angles, rad.
        """
        return _run(
            np.ascontiguousarray(axis_rates_rad_s, dtype=np.float64),
            interval_s,
            self.leak_rad_s,
            self.settling_gain,
            self.settling_s,
            self.duration_s - self.averaging_s,
            coupled,
            state,
        )

    @staticmethod
    def hand_over(
        state: FloatArray, interval_s: float
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Split the state for the network that takes over.

        Parameters
        ----------
        state : ndarray, shape (15,)
            After the last sample of the start-up.
        interval_s : float
            Sampling interval, s.

        Returns
        -------
        posture, deviation, previous_deviation, rates : ndarray, shape (3,)
            Angle about which the network swings, its last two outputs and its last input, in
            rad and rad/s.
        """
        posture = np.zeros(3)
        if state[14] and state[12]:
            posture = state[9:12] / state[12]
        deviation, rates = state[0:3] - posture, state[6:9].copy()
        return posture, deviation, deviation - interval_s * rates, rates


@numba.njit(cache=True, nogil=True)
def _run(  # type: ignore[no-untyped-def]
    rates, interval, leak, gain, settling, averaging_from, coupled, state
):
    angles = np.empty((len(rates), 3))
    known = state[14] > 0.0
    rate, tilt = np.empty(3), np.empty(3)
    for k in range(len(rates)):
        if coupled:
            # extrapolated to the time of the sample: with the tilt of the sample before, the
            # lag would add up to degrees per minute
            for axis in range(3):
                tilt[axis] = state[axis] + interval * state[6 + axis]
            sin_s, cos_s = np.sin(tilt[0]), np.cos(tilt[0])
            sin_f, cos_f = np.sin(tilt[1]), np.cos(tilt[1])
            if abs(cos_f) < SMALLEST_COS_FRONTAL:
                cos_f = -SMALLEST_COS_FRONTAL if cos_f < 0 else SMALLEST_COS_FRONTAL
            rate[2] = (rates[k, 2] * cos_s - rates[k, 1] * sin_s) / cos_f
            rate[1] = rates[k, 1] * cos_s + rates[k, 2] * sin_s
            rate[0] = rates[k, 0] - sin_f * rate[2]
        else:
            rate[:] = rates[k]
        state[13] += interval
        damping = 1.0 + interval * (leak + gain / (state[13] + settling))
        for axis in range(3):
            step = 0.5 * interval * (rate[axis] + state[6 + axis])
            state[3 + axis] = (state[3 + axis] + step) / damping
            state[axis] = state[axis] + step if known else state[3 + axis]
            state[6 + axis] = rate[axis]
            if state[13] > averaging_from:
                state[9 + axis] += state[axis] - state[3 + axis]
            angles[k, axis] = state[axis]
        if state[13] > averaging_from:
            state[12] += 1.0
    return angles
