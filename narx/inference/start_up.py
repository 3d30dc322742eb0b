"""The first seconds: find the posture about which the network then works.

A gyroscope does not know where zero is, and a network that leaks towards zero forgets the mean
angle of a walk (a knee is bent by some 20 degrees on average). What is known at the start decides:

- The start pose is known (standing in the calibration posture). The rates are integrated, which
  for a dozen seconds drifts little; the mean angle of early strides becomes the posture. From
  then on the network works on the deviation from it.
- The start pose is unknown. The integral leaks towards zero, strongly at first and less and less
  (the gain of a growing memory), and the posture is zero.

Only movement counts: somebody who stands at first is waited for. At the hand-over the angle is the
sum of posture and deviation in both cases, so nothing jumps.
"""

from dataclasses import dataclass

import numba
import numpy as np

from narx.kernels.euler import COS_FRONTAL_MIN
from narx.types import FloatArray

# where in the state lies what
ANGLES, RATES, POSTURE = slice(0, 3), slice(3, 6), slice(6, 9)
POSTURE_WEIGHT, TIME_S, MOVING_S, MEAN_SQUARE, KNOWN = 9, 10, 11, 12, 13
STATE_SIZE = 14

# time constant and threshold of what counts as movement: root mean square of the rates over
# about a second, which sway in standing stays far below
MOVEMENT_TIME_CONSTANT_S = 1.0
MOVEMENT_RAD_S = 0.35


@dataclass(frozen=True)
class StartUp:
    """Parameters of the start-up.

    Parameters
    ----------
    duration_s : float
        Movement before the network takes over, s; 0 starts the network at once from zero.
    averaging_s : float
        Its part over which the posture is averaged with a Hann window, so that no part of a
        stride counts more than another, s.
    averaging_begin_s : float
        Movement before that part, s; less where it would not end before the start-up does. Early,
        because what is left of the bias is integrated; not the first steps, which are not steady.
    leak_rad_s : float
        Leak of an unknown start, rad/s.
    settling_gain : float
        At time t that leak is larger by ``settling_gain / (t + settling_s)``.
    settling_s : float
        See `settling_gain`, s.
    """

    duration_s: float = 12.0
    averaging_s: float = 6.0
    averaging_begin_s: float = 2.0
    leak_rad_s: float = 0.1
    settling_gain: float = 2.0
    settling_s: float = 0.5

    @property
    def averaged_from_s(self) -> float:
        """Movement before the posture is averaged, s."""
        return min(self.averaging_begin_s, self.duration_s - self.averaging_s)

    def begin(self, initial_angles_rad: FloatArray | None) -> FloatArray:
        """State before the first sample.

        Parameters
        ----------
        initial_angles_rad : ndarray, shape (3,), optional
            Known start pose; None where it is unknown.

        Returns
        -------
        ndarray, shape (14,)
            Angles (3), latest coupled rates (3), weighted sum of angles (3) and its weight,
            time and time in movement in s, mean square of the rates, 1 where the start is known.
        """
        state = np.zeros(STATE_SIZE)
        if initial_angles_rad is not None:
            state[ANGLES] = initial_angles_rad
            state[KNOWN] = 1.0
        return state

    def is_over(self, state: FloatArray) -> bool:
        """Tell whether the network takes over at the next sample.

        Parameters
        ----------
        state : ndarray, shape (14,)
            From `begin`, as `run` left it.

        Returns
        -------
        bool
            True once there was enough movement.
        """
        return bool(state[MOVING_S] >= self.duration_s)

    def run(
        self,
        axis_rates_rad_s: FloatArray,
        interval_s: float,
        state: FloatArray,
        coupled: bool = True,
    ) -> FloatArray:
        """Advance until there was enough movement, or the samples end.

        Parameters
        ----------
        axis_rates_rad_s : ndarray, shape (N, 3)
            Gyroscope about the clinical axes, rad/s.
        interval_s : float
            Sampling interval, s.
        state : ndarray, shape (14,)
            From `begin` or an earlier piece; changed in place.
        coupled : bool
            As the network that takes over.

        Returns
        -------
        ndarray, shape (n, 3)
            Angles in rad of the n <= N samples that the start-up took.
        """
        rates = np.ascontiguousarray(axis_rates_rad_s, dtype=np.float64)
        angles = np.empty_like(rates)
        n = _run(
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
        """Split the state for the network that takes over.

        Parameters
        ----------
        state : ndarray, shape (14,)
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
        if state[KNOWN] and state[POSTURE_WEIGHT]:
            posture = state[POSTURE] / state[POSTURE_WEIGHT]
        deviation, rates = state[ANGLES] - posture, state[RATES].copy()
        return posture, deviation, deviation - interval_s * rates, rates


@numba.njit(cache=True, nogil=True)
def _run(  # type: ignore[no-untyped-def]
    rates,
    interval,
    duration,
    averaged_from,
    averaging,
    leak,
    gain,
    settling,
    coupled,
    state,
    angles,
):
    known = state[13] > 0.0
    rate, tilt = np.empty(3), np.empty(3)
    for k in range(len(rates)):
        if state[11] >= duration:
            return k
        if coupled:
            # extrapolated to the time of the sample: with the tilt of the sample before, the
            # lag would add up to degrees per minute
            for axis in range(3):
                tilt[axis] = state[axis] + interval * state[3 + axis]
            sin_s, cos_s = np.sin(tilt[0]), np.cos(tilt[0])
            sin_f, cos_f = np.sin(tilt[1]), np.cos(tilt[1])
            if abs(cos_f) < COS_FRONTAL_MIN:
                cos_f = -COS_FRONTAL_MIN if cos_f < 0 else COS_FRONTAL_MIN
            rate[2] = (rates[k, 2] * cos_s - rates[k, 1] * sin_s) / cos_f
            rate[1] = rates[k, 1] * cos_s + rates[k, 2] * sin_s
            rate[0] = rates[k, 0] - sin_f * rate[2]
        else:
            rate[:] = rates[k]
        state[10] += interval
        square = rates[k, 0] ** 2 + rates[k, 1] ** 2 + rates[k, 2] ** 2
        state[12] += (square - state[12]) * interval / (MOVEMENT_TIME_CONSTANT_S + interval)
        if state[12] > MOVEMENT_RAD_S**2:
            state[11] += interval
        damping = 1.0
        if not known:
            damping += interval * (leak + gain / (state[10] + settling))
        weight = 0.0
        into = state[11] - averaged_from
        if 0.0 < into < averaging:
            weight = np.sin(np.pi * into / averaging) ** 2
        for axis in range(3):
            step = 0.5 * interval * (rate[axis] + state[3 + axis])
            state[axis] = (state[axis] + step) / damping
            state[3 + axis] = rate[axis]
            state[6 + axis] += weight * state[axis]
            angles[k, axis] = state[axis]
        state[9] += weight
    return len(rates)
