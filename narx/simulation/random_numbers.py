"""Random numbers that depend only on the seed and a name, and noise of gait and sensors."""

import zlib

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from narx.types import FloatArray


def stream(seed: int, *names: str) -> np.random.Generator:
    """Open the random stream of a name.

    Parameters
    ----------
    seed : int
        Seed of the whole data set.
    *names : str
        Such as subject, condition, trial and purpose. Different names give different numbers,
        whatever the order in which streams are opened.

    Returns
    -------
    numpy.random.Generator
        Independent of the streams of all other names.
    """
    return np.random.default_rng([seed, *(zlib.crc32(name.encode()) for name in names)])


def persistent_noise(
    rng: np.random.Generator, n: int, channels: int, exponent: float = 0.75
) -> FloatArray:
    """Draw noise with the long-range correlation of strides.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    n : int
        Number of strides.
    channels : int
        Number of independent sequences.
    exponent : float, optional
        Scaling exponent of detrended fluctuation analysis: 0.5 is white; strides of healthy
        adults have about 0.75 (Hausdorff et al., J Appl Physiol 78:349, 1995).

    Returns
    -------
    ndarray, shape (n, channels)
        Zero mean and unit variance in expectation. The power falls with frequency to the power
        ``2 exponent - 1``, made in the frequency domain.
    """
    frequency = np.fft.rfftfreq(2 * n)
    gain = np.zeros_like(frequency)
    gain[1:] = frequency[1:] ** (0.5 - exponent)
    gain /= np.sqrt(2.0 * np.sum(gain[1:-1] ** 2) + gain[-1] ** 2) / np.sqrt(2.0 * n)
    white = np.fft.rfft(rng.standard_normal((2 * n, channels)), axis=0)
    return np.asarray(np.fft.irfft(white * gain[:, None], axis=0)[:n])


def smooth_noise(
    rng: np.random.Generator, start_s: float, end_s: float, bandwidth_hz: float, channels: int
) -> BSpline:
    """Draw slow noise as a smooth function of time, independent of the sampling clock.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    start_s, end_s : float
        Interval that will be evaluated.
    bandwidth_hz : float
        Highest frequency; above it the power falls steeply.
    channels : int
        Number of independent sequences.

    Returns
    -------
    scipy.interpolate.BSpline
        Function of time with values of shape (..., channels), unit variance, four continuous
        derivatives.
    """
    spacing = 0.5 / bandwidth_hz
    n = int(np.ceil((end_s - start_s) / spacing)) + 13
    knots = start_s + spacing * (np.arange(n) - 6.0)
    return make_interp_spline(knots, rng.standard_normal((n, channels)), k=5)
