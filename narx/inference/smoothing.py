"""A second pass from the end to the start, for recordings that are there as a whole.

A recurrence that leaks knows the past alone. Its output is the rate's leaky integral: what the
rate was wrong by stays in for some seconds, and slow movement leaks away. Backwards in time, over
the rates with their sign turned, the same recurrence obeys the same kinematics and errs by the
future instead. With 1 / (s + l) forwards and -1 / (l - s) backwards, the mean of both is

    -s / (l^2 - s^2),   at a frequency of w a gain of   w / (l^2 + w^2)   without any lag.

Compared with one pass, the share of the movement that is lost falls from l / sqrt(l^2 + w^2) to
its square; what an error of the rate leaves falls by w / sqrt(l^2 + w^2), and a constant error
leaves nothing. For an angle that wanders about a mean (Ornstein and Uhlenbeck) and a rate with
white noise this is the Wiener smoother; to average two filters of equal variance is how
Fraser and Potter (IEEE Trans. Automat. Contr. 14 (1969) 387-390) write the smoother of Rauch, Tung
and Striebel (AIAA J. 3 (1965) 1445-1450).

Only near the start are the two not worth the same. A known start pose is better than anything
that comes from behind, an unknown one worse; from the hand-over on both differences fade. At the
end the backward pass sets out from where the forward one arrived, as that of Rauch, Tung and
Striebel does, so nothing has to be known there.
"""

import numpy as np
import torch

from narx.network.cell import coupled_rates
from narx.types import FloatArray


def turned_round(
    coupled: bool,
    axis_rates_rad_s: FloatArray,
    angles_rad: FloatArray,
    posture_rad: FloatArray,
    interval_s: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Say what a recursion has followed that arrives at a sample from the future.

    Parameters
    ----------
    coupled : bool
        Whether it runs on the rates of the angles.
    axis_rates_rad_s : ndarray, shape (3,)
        Gyroscope about the clinical axes at that sample, as recorded, rad/s.
    angles_rad : ndarray, shape (3,)
        Angles there.
    posture_rad : ndarray, shape (3,)
        Angle about which the recursion swings, rad.
    interval_s : float
        Sampling interval, s.

    Returns
    -------
    deviation, following_deviation, rates : ndarray, shape (3,)
        As `narx.network.model.Narx.initial_state` takes them: deviation from the posture there and
        one sample later, and the rate of the angles as it is backwards in time.
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
        Samples in which what is known of the start fades.
    known : bool
        Whether the start pose is known.

    Returns
    -------
    ndarray, shape (N, 1)
        One half but near the start. With a known pose: one until the hand-over, then falling to
        one half. With an unknown one: rising from zero at the first sample to one half at the
        hand-over.
    """
    sample = np.arange(n_samples)[:, None]
    if known:
        return 1.0 - 0.5 * np.clip((sample - n_start_up) / max(n_settling, 1), 0.0, 1.0)
    return 0.5 * np.clip(sample / max(n_start_up, 1), 0.0, 1.0)
