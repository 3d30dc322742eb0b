"""Timing of gait events: the stride phase over a trial.

The phase of the right leg grows by one per stride and is an integer at right heel strikes; the size
of the movement goes from 0 in standing to 1 in steady walking.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from narx.simulation.calculus import smooth_step
from narx.simulation.pauses import Pauses
from narx.simulation.random_numbers import persistent_noise
from narx.types import FloatArray

# strides by which the splines extend beyond the walk, so that they are smooth at its ends
_MARGIN = 8

# stride-to-stride standard deviations: duration relative (treadmill 1-2 %, Terrier and Deriaz,
# J NeuroEng Rehabil 8:12, 2011), size of a joint's movement relative, its mean in deg (together
# 1-2 deg in the knee and hip, Winter, Hum Mov Sci 3:51, 1984; Kadaba et al., 1989)
STRIDE_TIME_CV = 0.018
SIZE_CV = 0.03
OFFSET_SD_DEG = 0.8


@dataclass(frozen=True)
class GaitTiming:
    """Phase and size of the movement over one trial.

    Parameters
    ----------
    phase_of_time : scipy.interpolate.BSpline
        Phase of the right leg, also beyond the walk.
    start_s, end_s : float
        First and last moment of walking.
    rise_s, fall_s : float
        Time in which the movement grows to its full size and falls to rest.
    events : dict of str to ndarray
        Times of ``heel_strike_right``, ``heel_strike_left``, ``toe_off_right``,
        ``toe_off_left``, s.
    strides : scipy.interpolate.BSpline
        Stride-to-stride variation as a function of phase, unit variance, one column per channel.
    pauses : Pauses
        Pauses of the walk, in which the phase goes on but nothing moves.
    """

    phase_of_time: BSpline
    start_s: float
    end_s: float
    rise_s: float
    fall_s: float
    events: dict[str, FloatArray]
    strides: BSpline
    pauses: Pauses = field(default_factory=Pauses)

    def size(self, time_s: FloatArray) -> FloatArray:
        """Size of the movement.

        Parameters
        ----------
        time_s : ndarray, shape (N,)
            Moments.

        Returns
        -------
        ndarray, shape (N,)
            0 in standing, 1 in steady walking.
        """
        rise = smooth_step((time_s - self.start_s) / self.rise_s)
        size = rise * smooth_step((self.end_s - time_s) / self.fall_s)
        return size * self.pauses.walking(time_s)

    def variation(self, phase: FloatArray, channels: slice) -> FloatArray:
        """Stride-to-stride variation.

        Parameters
        ----------
        phase : ndarray, shape (N,)
            Phase of the leg.
        channels : slice
            Which of the independent sequences.

        Returns
        -------
        ndarray, shape (N, n)
            Unit variance, smooth.
        """
        chosen = np.ascontiguousarray(self.strides.c[:, channels])
        return np.asarray(BSpline(self.strides.t, chosen, self.strides.k)(phase))


def treadmill_timing(
    rng: np.random.Generator,
    stride_s: float,
    toe_off: float,
    left_lag: float,
    stand_s: float,
    belt_rise_s: float,
    duration_s: float,
    channels: int,
) -> GaitTiming:
    """Stand, let the belt start, and walk until after the recording ends.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    stride_s : float
        Mean duration of a stride.
    toe_off, left_lag : float
        Phase of a leg at its toe-off; phase of the right leg at the left heel strike.
    stand_s : float
        Standing before the belt starts.
    belt_rise_s : float
        Time in which belt and steps grow to full speed.
    duration_s : float
        Length of the recording.
    channels : int
        Number of sequences of stride-to-stride variation.

    Returns
    -------
    GaitTiming
        Its events lie within the recording.
    """
    first_phase = 0.5 * rng.integers(2)
    n = int(np.ceil(max(duration_s - stand_s, 0.0) / stride_s * 1.1)) + 4
    slow_start = 1.0 + 0.6 * np.exp(-np.arange(n) * stride_s / belt_rise_s * 2.0)
    return _timing(
        rng, stride_s, slow_start, first_phase, toe_off, left_lag, stand_s,
        duration_s + 1e3, (belt_rise_s, 1.0), duration_s, channels,
    )  # fmt: skip


def overground_timing(
    rng: np.random.Generator,
    stride_s: float,
    toe_off: float,
    left_lag: float,
    stand_s: float,
    n_steps: int,
    stand_after_s: float,
    channels: int,
) -> GaitTiming:
    """Stand, walk some steps, close with the feet side by side, and stand.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    stride_s : float
        Mean duration of a stride.
    toe_off, left_lag : float
        Phase of a leg at its toe-off; phase of the right leg at the left heel strike.
    stand_s : float
        Standing before.
    n_steps : int
        Steps, the closing one included.
    stand_after_s : float
        Standing after.
    channels : int
        Number of sequences of stride-to-stride variation.

    Returns
    -------
    GaitTiming
        Its events leave out the closing step, in which the foot is set down flat; the toe-off of
        that step is included.
    """
    first_phase = 0.5 * rng.integers(2)
    return _timing(
        rng, stride_s, np.ones(n_steps + 2), first_phase, toe_off, left_lag, stand_s,
        stand_s + 0.5 * n_steps * stride_s, (0.6 * stride_s, 0.6 * stride_s),
        stand_s + 0.5 * n_steps * stride_s + stand_after_s, channels,
    )  # fmt: skip


def _timing(
    rng: np.random.Generator,
    stride_s: float,
    tempo: FloatArray,
    first_phase: float,
    toe_off: float,
    left_lag: float,
    start_s: float,
    end_s: float,
    ramps_s: tuple[float, float],
    duration_s: float,
    channels: int,
) -> GaitTiming:
    n = len(tempo)
    variation = persistent_noise(rng, n + 2 * _MARGIN, channels + 1)
    strides = stride_s * (1.0 + STRIDE_TIME_CV * variation[:-1, 0])
    strides[_MARGIN : _MARGIN + n] *= tempo
    nodes = np.concatenate([[0.0], np.cumsum(strides)])
    phases = np.arange(len(nodes)) - _MARGIN + first_phase
    nodes += start_s - nodes[_MARGIN]
    phase_of_time = make_interp_spline(nodes, phases, k=5)

    clock = np.arange(start_s, min(end_s, duration_s), 0.002)
    phase = phase_of_time(clock)
    events = {}
    for name, instant in {
        "heel_strike_right": 0.0,
        "heel_strike_left": left_lag,
        "toe_off_right": toe_off,
        "toe_off_left": toe_off + left_lag,
    }.items():
        if len(clock) < 2:
            events[name] = np.empty(0)
            continue
        whole = np.arange(np.ceil(phase[0] - instant), np.floor(phase[-1] - instant) + 1.0)
        times = np.interp(whole + instant, phase, clock)
        if name.startswith("heel"):
            # neither the standing foot at the start nor the closing step has a heel strike
            margin = 0.2 * stride_s
            times = times[(times > start_s + margin) & (times < end_s - margin)]
        events[name] = times
    return GaitTiming(
        phase_of_time,
        start_s,
        end_s,
        *ramps_s,
        events,
        make_interp_spline(phases, variation[:, 1:], k=5),
    )
