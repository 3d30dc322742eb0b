"""The task that the engine and its peers are timed by: one sequence, and a plain network."""

import numpy as np
import torch

from narx.network.structure import NarxStructure
from narx.training.least_squares.axis import NetworkFit
from narx.training.least_squares.one_step import OneStepFit
from narx.training.stages import Stage
from narx.types import FloatArray
from narx.windows.lagged import LaggedWindows

STRUCTURE = NarxStructure()


def gait_like(n: int, rate_hz: float = 500.0) -> tuple[FloatArray, FloatArray]:
    """Generate a normalised rate and angle similar to those of a thigh in the sagittal plane.

    Parameters
    ----------
    n : int
        Samples.
    rate_hz : float
        Sampling rate.

    Returns
    -------
    rate, angle : ndarray, shape (n,)
        Each with a largest magnitude of one.
    """
    time_s = np.arange(n) / rate_hz
    sway = 0.2 * np.sin(2 * np.pi * 0.05 * time_s)
    harmonics = ((20.0, 0.0), (6.0, 1.0), (2.5, 2.0), (1.0, 0.5), (0.4, 0.1))
    angle = sum(
        size * np.sin(2 * np.pi * 0.9 * k * time_s + phase + k * sway)
        for k, (size, phase) in enumerate(harmonics, start=1)
    )
    rate = np.gradient(angle, 1.0 / rate_hz)
    rate = rate + 0.002 * np.abs(rate).max() * np.random.default_rng(0).standard_normal(n)
    return rate / np.abs(rate).max(), angle / np.abs(angle).max()


def open_loop_fit(v: FloatArray, target: FloatArray) -> OneStepFit:
    """Make the one-step fit that the peers solve as well: zero before the first sample.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and measured output.

    Returns
    -------
    OneStepFit
        Of the default network.
    """
    before = np.zeros(STRUCTURE.output_lags)
    windows = LaggedWindows([np.concatenate([before, v])], [np.concatenate([before, target])])
    return OneStepFit(windows, STRUCTURE)


def open_then_closed(v: FloatArray, target: FloatArray) -> list[Stage]:
    """Make the stages of a training: one step ahead, then in closed loop.

    Parameters
    ----------
    v, target : ndarray, shape (N,)
        Input and output wanted, NaN where it does not count.

    Returns
    -------
    list of Stage
        Of the default network, from a state of zero.
    """
    one_step = OneStepFit(LaggedWindows([v], [target]), STRUCTURE)
    closed = NetworkFit(torch.from_numpy(v)[:, None], torch.from_numpy(target), structure=STRUCTURE)
    return [
        Stage("open", one_step, 1.0 / max(one_step.total_weight, 1.0)),
        Stage("closed", closed, 1.0 / max(closed.total_weight, 1.0)),
    ]


def random_starts(n: int, rng: np.random.Generator) -> FloatArray:
    """Draw random weights, from which every solver starts.

    Parameters
    ----------
    n : int
        Number of starts.
    rng : numpy.random.Generator
        Random number generator.

    Returns
    -------
    ndarray, shape (n, P)
        Normally distributed, standard deviation 0.5.
    """
    return 0.5 * rng.standard_normal((n, STRUCTURE.n_weights))
