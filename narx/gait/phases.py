"""Phases of the stride from the sagittal gyroscope of one thigh (Abhayasinghe et al., Fig. 11).

========= ============================== =======================================
point     meaning (Table 2)              signal (Table 3)
========= ============================== =======================================
``a``     end of swing                   gyroscope falls through zero
``b``     initial contact                derivative rises through zero
``c``     end of loading response        relative maximum of the derivative
``d``     end of mid stance              derivative rises through zero
``e``     end of terminal stance         gyroscope rises through zero
``f``     end of pre-swing               derivative falls through zero
``g``     the next initial contact       as ``b``
========= ============================== =======================================

The intervals between them are loading response (b-c), mid stance (c-d), terminal stance (d-e),
pre-swing (e-f) and swing (f-g). The paper's text calls the minimum of the thigh angle, ``e``,
toe-off, while its Table 2 begins swing at ``f``. In walking, the thigh swings forward from about
the moment when the *other* foot comes down (``e``), and its own toes leave the ground near the
highest rate (``f``).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import signal

from narx.errors import UserError
from narx.gait.standing import runs
from narx.gait.stride_frequency import stride_frequency_hz
from narx.types import FloatArray

MEANING: Mapping[str, str] = MappingProxyType(
    {
        "a": "end of swing",
        "b": "initial contact",
        "c": "end of loading response",
        "d": "end of mid stance",
        "e": "end of terminal stance",
        "f": "end of pre-swing",
        "g": "next initial contact",
    }
)

PHASES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "loading_response": ("b", "c"),
        "mid_stance": ("c", "d"),
        "terminal_stance": ("d", "e"),
        "pre_swing": ("e", "f"),
        "swing": ("f", "g"),
    }
)

# human walking has no relevant content above this, and the derivative would amplify noise
_LOW_PASS_HZ = 6.0
# harmonics of the stride that outline its shape: one swing lobe, one dip in stance
_OUTLINE_HARMONICS = 2.5
# from the end of swing, initial contact comes within this part of a stride (it takes a tenth),
# the end of mid stance after it (a third)
_LANDING_STRIDES = 0.22


@dataclass(frozen=True)
class GaitPhases:
    """Points of every stride, s from the first sample; NaN for a point that was not found.

    Parameters
    ----------
    times_s : mapping of str to ndarray, shape (S,)
        By point ``a`` ... ``g``, one entry per stride from the end of one swing to the next, in
        order of time.
    """

    times_s: Mapping[str, FloatArray]

    @property
    def n_strides(self) -> int:
        """Number of strides."""
        return len(self.times_s["a"])

    def stride_times_s(self, point: str = "e") -> FloatArray:
        """Times from one stride to the next.

        Parameters
        ----------
        point : str
            Point between which the strides are counted; ``e`` is the steepest crossing and so
            the least sensitive to noise.

        Returns
        -------
        ndarray, shape (S - 1,)
            Stride times, s; NaN across a gap or a missing point.
        """
        between = np.diff(self.times_s[point])
        # a pause, or a gap with lost strides, is not one long stride
        usual = np.nanmedian(between) if np.isfinite(between).any() else np.nan
        return np.where(between < 1.75 * usual, between, np.nan)

    def statistics(self, point: str = "e") -> dict[str, float]:
        """Cadence, stride time and their variability.

        Parameters
        ----------
        point : str
            As in `stride_times_s`.

        Returns
        -------
        dict of str to float
            ``n_strides``, ``stride_time_s``, ``stride_time_sd_s``, ``stride_time_cv_percent``,
            ``cadence_steps_per_min``; NaN where there are too few strides.
        """
        times = self.stride_times_s(point)
        times = times[np.isfinite(times)]
        mean = float(times.mean()) if times.size else float("nan")
        spread = float(times.std(ddof=1)) if times.size > 1 else float("nan")
        return {
            "n_strides": float(times.size),
            "stride_time_s": mean,
            "stride_time_sd_s": spread,
            "stride_time_cv_percent": 100.0 * spread / mean,
            "cadence_steps_per_min": 120.0 / mean,
        }

    def frame(self) -> pd.DataFrame:
        """List the points as a table.

        Returns
        -------
        pandas.DataFrame
            Columns ``stride``, ``point``, ``meaning``, ``time_s``, in order of time within each
            stride.
        """
        rows = [
            (stride, point, MEANING[point], self.times_s[point][stride])
            for stride in range(self.n_strides)
            for point in MEANING
        ]
        return pd.DataFrame(rows, columns=["stride", "point", "meaning", "time_s"])


def smooth_rate_and_derivative(
    sagittal_rate_rad_s: ArrayLike, sampling_rate_hz: float
) -> tuple[FloatArray, FloatArray]:
    """Low-pass a rate without delay, and differentiate it.

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate about the sagittal axis, rad/s, without missing samples.
    sampling_rate_hz : float
        Sampling rate.

    Returns
    -------
    rate_rad_s : ndarray, shape (N,)
        After a second-order Butterworth filter at 6 Hz, forwards and backwards.
    derivative_rad_s2 : ndarray, shape (N,)
        Its derivative.
    """
    rate = _low_pass(np.asarray(sagittal_rate_rad_s, dtype=float), _LOW_PASS_HZ, sampling_rate_hz)
    return rate, np.gradient(rate) * sampling_rate_hz


def _low_pass(values: FloatArray, cutoff_hz: float, sampling_rate_hz: float) -> FloatArray:
    if cutoff_hz >= 0.5 * sampling_rate_hz:
        return values
    sections = signal.butter(2, cutoff_hz, fs=sampling_rate_hz, output="sos")
    padding = min(len(values) - 1, round(sampling_rate_hz))
    return signal.sosfiltfilt(sections, values, padlen=padding)


def gait_phases(sagittal_rate_rad_s: ArrayLike, sampling_rate_hz: float) -> GaitPhases:
    """Find the points a-g of every stride of a thigh.

    Parameters
    ----------
    sagittal_rate_rad_s : array_like, shape (N,)
        Rate about the thigh's sagittal axis, flexion positive, rad/s; NaN where missing.
    sampling_rate_hz : float
        Sampling rate.

    Returns
    -------
    GaitPhases
        Complete strides between gaps.

    Raises
    ------
    UserError
        If no walking is found.
    """
    rate = np.asarray(sagittal_rate_rad_s, dtype=float)
    frequency_hz = stride_frequency_hz(rate, sampling_rate_hz)
    if not np.isfinite(frequency_hz):
        raise UserError("gait phases: no walking found in the sagittal gyroscope, expected strides")
    strides: list[dict[str, float]] = []
    for begin, end in runs(np.isfinite(rate)):
        if (end - begin) * frequency_hz > 2.0 * sampling_rate_hz:
            found = _strides(rate[begin:end], sampling_rate_hz, frequency_hz)
            strides += [{p: t + begin / sampling_rate_hz for p, t in s.items()} for s in found]
    return GaitPhases({point: np.array([stride[point] for stride in strides]) for point in MEANING})


def _strides(
    rate: FloatArray, sampling_rate_hz: float, frequency_hz: float
) -> list[dict[str, float]]:
    smooth, derivative = smooth_rate_and_derivative(rate, sampling_rate_hz)
    outline = _low_pass(rate, _OUTLINE_HARMONICS * frequency_hz, sampling_rate_hz)
    swings, _ = signal.find_peaks(
        outline, height=outline.std(), distance=max(1, 0.6 * sampling_rate_hz / frequency_hz)
    )
    falls = _crossings(-smooth)
    rises = _crossings(smooth)
    turns_up = _crossings(derivative)
    turns_down = _crossings(-derivative)
    humps = signal.find_peaks(derivative)[0].astype(float)
    strides = []
    for swing, next_swing in pairwise(swings):
        if next_swing - swing > 1.75 * sampling_rate_hz / frequency_hz:
            continue  # a pause
        a = _first(falls, swing, next_swing)
        e = _last(rises, a, next_swing)
        # initial contact follows soon after the thigh's swing; the later dip is mid stance
        landed = a + _LANDING_STRIDES * sampling_rate_hz / frequency_hz
        b = _first(turns_up, a, landed)
        d = _deepest(turns_up, smooth, landed, e)
        c = _highest(humps, derivative, b, d)
        f = _highest(turns_down, smooth, e, e + 0.5 * sampling_rate_hz / frequency_hz)
        strides.append({"a": a, "b": b, "c": c, "d": d, "e": e, "f": f, "g": np.nan})
    for stride, following in pairwise(strides):
        if following["a"] - stride["a"] < 1.75 * sampling_rate_hz / frequency_hz:
            stride["g"] = following["b"]
    return [{p: float(k) / sampling_rate_hz for p, k in stride.items()} for stride in strides]


def _crossings(values: FloatArray) -> FloatArray:
    """Positions in samples, interpolated, at which a signal rises through zero."""
    before = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    return before + values[before] / (values[before] - values[before + 1])


def _between(places: FloatArray, begin: float, end: float) -> FloatArray:
    return places[(places > begin) & (places < end)]


def _first(places: FloatArray, begin: float, end: float) -> float:
    inside = _between(places, begin, end)
    return float(inside[0]) if inside.size else float("nan")


def _last(places: FloatArray, begin: float, end: float) -> float:
    inside = _between(places, begin, end)
    return float(inside[-1]) if inside.size else float("nan")


def _highest(places: FloatArray, values: FloatArray, begin: float, end: float) -> float:
    inside = _between(places, begin, end)
    if not inside.size:
        return float("nan")
    return float(inside[np.argmax(np.interp(inside, np.arange(len(values)), values))])


def _deepest(places: FloatArray, values: FloatArray, begin: float, end: float) -> float:
    return _highest(places, -values, begin, end)
