"""Smoothing of whole recordings by a backward pass.

A recurrence with a leak uses past samples only. Its output is the leaky integral of the rate: rate
errors persist for some seconds, and slow movement leaks away. Backwards in time, on rates of
reversed sign, the same recurrence obeys the same kinematics, with errors from the future instead.
With 1 / (s + l) forwards and -1 / (l - s) backwards, the mean of both is

    -s / (l^2 - s^2),   at a frequency of w a gain of   w / (l^2 + w^2)   without any lag.

Compared with one pass, the fraction of the movement that is lost falls from l / sqrt(l^2 + w^2) to
its square; the effect of a rate error falls by w / sqrt(l^2 + w^2), and that of a constant error
vanishes. For an angle that fluctuates about a mean (Ornstein and Uhlenbeck) and a rate with white
noise this is the Wiener smoother; averaging two filters of equal variance is the form of Fraser and
Potter (IEEE Trans. Automat. Contr. 14 (1969) 387-390) of the smoother of Rauch, Tung and
Striebel (AIAA J. 3 (1965) 1445-1450).

Only near the start do the two passes differ in accuracy. A known start pose is better than the
backward pass, an unknown one worse; after the hand-over (without a start-up, from the first sample
on) both differences fade. At the end the backward pass starts from the final state of the forward
one, as in Rauch, Tung and Striebel, so no end pose is needed.
"""

import numpy as np
import torch

from narx.network.cell import coupled_rates
from narx.types import FloatArray


def time_reversed(
    coupled: bool,
    axis_rates_rad_s: FloatArray,
    angles_rad: FloatArray,
    posture_rad: FloatArray,
    interval_s: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the start of a backward recursion at a sample.

    Parameters
    ----------
    coupled : bool
        Whether the recursion's inputs are the rates of the angles.
    axis_rates_rad_s : ndarray, shape (3,)
        Gyroscope about the clinical axes at that sample, as recorded, rad/s.
    angles_rad : ndarray, shape (3,)
        Angles at that sample.
    posture_rad : ndarray, shape (3,)
        Posture, the zero of the recursion, rad.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    deviation, following_deviation, rates : ndarray, shape (3,)
        Arguments of `narx.network.model.Narx.initial_state`: deviation from the posture there and
        one sample later, and the rate of the angles in reversed time.
    """
    rates = axis_rates_rad_s
    if coupled:
        rates = coupled_rates(torch.from_numpy(rates), torch.from_numpy(angles_rad)).numpy()
    deviation = angles_rad - posture_rad
    return deviation, deviation + interval_s * rates, -rates


def forward_share(n_samples: int, n_start_up: int, n_settling: int, known: bool) -> FloatArray:
    """Weight of the forward pass in the mean of both.

    Parameters
    ----------
    n_samples : int
        Samples of the recording.
    n_start_up : int
        Samples before the network took over.
    n_settling : int
        Samples over which the effect of the start decays.
    known : bool
        Whether the start pose is known.

    Returns
    -------
    ndarray, shape (N, 1)
        One half except near the start. With a known pose: one until the hand-over, then falling to
        one half. With an unknown one: rising from zero at the first sample to one half at the
        hand-over.
    """
    sample = np.arange(n_samples)[:, None]
    if known:
        return 1.0 - 0.5 * np.clip((sample - n_start_up) / max(n_settling, 1), 0.0, 1.0)
    return 0.5 * np.clip(sample / max(n_start_up, 1), 0.0, 1.0)
