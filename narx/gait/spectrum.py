"""Amplitude spectrum of a gyroscope, and the number of hidden neurons derived from it."""

import numpy as np
from numpy.typing import ArrayLike

from narx.errors import UserError
from narx.gait.stride_frequency import stride_frequency_hz
from narx.types import FloatArray


def single_sided_amplitude_spectrum(
    values: ArrayLike, sampling_rate_hz: float
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes of the sinusoidal components of a signal.

    Parameters
    ----------
    values : array_like, shape (N,)
        A real signal, without missing samples.
    sampling_rate_hz : float
        Sampling rate.

    Returns
    -------
    frequency_hz : ndarray, shape (N // 2 + 1,)
        From 0 to half the sampling rate.
    amplitude : ndarray, shape (N // 2 + 1,)
        In the unit of `values`: a sinusoid of amplitude 1 on a frequency of the grid gives 1.

    Raises
    ------
    UserError
        If `values` is empty or has missing samples.
    """
    series = np.asarray(values, dtype=float)
    if series.ndim != 1 or not series.size or not np.isfinite(series).all():
        raise UserError(
            f"amplitude spectrum: found an array of shape {series.shape} with "
            f"{int((~np.isfinite(series)).sum())} missing samples, expected one axis and none"
        )
    amplitude: FloatArray = np.abs(np.fft.rfft(series)) / len(series)
    # mean and (for even length) Nyquist frequency occur only once in the two-sided spectrum
    amplitude[1 : (len(series) + 1) // 2] *= 2.0
    frequency_hz = np.fft.rfftfreq(len(series), 1.0 / sampling_rate_hz).astype(np.float64)
    return frequency_hz, amplitude


def component_powers(
    sagittal_rate_rad_s: ArrayLike, sampling_rate_hz: float, highest_hz: float = 6.0
) -> tuple[float, FloatArray]:
    """Power of a walking gyroscope in each harmonic of the stride frequency.

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate about the sagittal axis, without missing samples.
    sampling_rate_hz : float
        Sampling rate.
    highest_hz : float
        Upper limit of walking motion; noise and soft-tissue motion are above. Winter et al. (J
        Biomech 7:479-486, 1974) found 99.7 % of the power of leg movements in walking below 6 Hz.

    Returns
    -------
    stride_frequency_hz : float
        Fundamental.
    power : ndarray, shape (H,)
        Share of harmonic 1, 2, ... up to `highest_hz` in their sum. Power below half the stride
        frequency (drift, turning) is left out.

    Raises
    ------
    UserError
        If the signal shows no walking, or has missing samples.

    Notes
    -----
    Strides differ from one another, so a component is a narrow peak of the spectrum and not a
    single line: each harmonic gets the band of one stride frequency around it.
    """
    frequency_hz, amplitude = single_sided_amplitude_spectrum(sagittal_rate_rad_s, sampling_rate_hz)
    fundamental_hz = stride_frequency_hz(sagittal_rate_rad_s, sampling_rate_hz)
    if not np.isfinite(fundamental_hz):
        raise UserError("gyroscope spectrum: no walking found in the signal, expected strides")
    harmonic = np.floor(frequency_hz / fundamental_hz + 0.5).astype(int)
    counted = frequency_hz <= highest_hz
    power = np.bincount(harmonic[counted], weights=amplitude[counted] ** 2)[1:]
    return fundamental_hz, power / power.sum()


def hidden_neurons(
    sagittal_rate_rad_s: ArrayLike,
    sampling_rate_hz: float,
    power_fraction: float = 0.98,
    highest_hz: float = 6.0,
) -> int:
    """Choose the number of hidden neurons as Tham et al. do (section II-B2, Fig. 3).

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate about the sagittal axis during walking, without missing samples.
    sampling_rate_hz : float
        Sampling rate.
    power_fraction : float
        Share of the power that the major components must have together.
    highest_hz : float
        As in `component_powers`.

    Returns
    -------
    int
        Number of harmonics of the stride, strongest first, that reach this share.

    Raises
    ------
    UserError
        If the signal shows no walking, or has missing samples.
    """
    _, power = component_powers(sagittal_rate_rad_s, sampling_rate_hz, highest_hz)
    held = np.cumsum(np.sort(power)[::-1])
    return int(np.searchsorted(held, power_fraction) + 1)
