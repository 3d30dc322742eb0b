"""Does the error grow while a recording goes on?"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from narx.errors import MethodNotApplicableError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class DriftTest:
    """Error at the end of a recording beside its start.

    Parameters
    ----------
    first_deg, last_deg : float
        RMSE (or bias) in the first and in the last window, degrees.
    change_deg : float
        Mean over the blocks of the last window less that of the first, degrees.
    low_deg, high_deg : float
        95 % confidence interval of the change, degrees.
    p_value : float
        Two-sided p of no change.
    n_effective : float
        Independent blocks that a window is worth, after autocorrelation (the fewer of the two).
    slope_deg_per_h : float
        Theil-Sen slope of the block values over the whole recording, degrees an hour.
    """

    first_deg: float
    last_deg: float
    change_deg: float
    low_deg: float
    high_deg: float
    p_value: float
    n_effective: float
    slope_deg_per_h: float

    @property
    def grows(self) -> bool:
        """Whether the error is larger at the end than at the start, significantly at 5 %."""
        return self.p_value < 0.05 and abs(self.last_deg) > abs(self.first_deg)


def block_errors(
    time_s: ArrayLike,
    error_rad: ArrayLike,
    block_s: float = 10.0,
    quantity: Literal["rmse", "bias"] = "rmse",
) -> tuple[FloatArray, FloatArray]:
    """Summarise an error block by block.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Clock, s, increasing.
    error_rad : array_like, shape (N,)
        Error in rad; NaN where missing.
    block_s : float
        Length of a block in s: several strides, so that a block's value does not depend on
        where in the stride it begins.
    quantity : {"rmse", "bias"}
        What a block is summed up by.

    Returns
    -------
    middle_s : ndarray, shape (blocks,)
        Middle of each block, s.
    value_deg : ndarray, shape (blocks,)
        RMSE or bias, degrees. Blocks less than half full, and an incomplete last one, are left
        out.
    """
    time, error = np.asarray(time_s, dtype=float), np.asarray(error_rad, dtype=float)
    if len(time) < 2:
        return np.empty(0), np.empty(0)
    block = np.floor((time - time[0]) / block_s).astype(int)
    there = ~np.isnan(error)
    samples = np.bincount(block)
    count = np.bincount(block[there], minlength=len(samples))
    value = error[there] ** 2 if quantity == "rmse" else error[there]
    total = np.bincount(block[there], value, minlength=len(samples))
    enough = count > 0.5 * block_s / float(np.median(np.diff(time)))
    mean = total[enough] / count[enough]
    summed_up = np.sqrt(mean) if quantity == "rmse" else mean
    middle = time[0] + (np.flatnonzero(enough) + 0.5) * block_s
    return middle, np.rad2deg(summed_up)


def _mean_and_error(value: FloatArray) -> tuple[float, float, float]:
    """Mean, its standard error, and the independent values it is worth (first-order memory)."""
    n = len(value)
    centred = value - value.mean()
    power = float(centred @ centred)
    memory = float(centred[:-1] @ centred[1:]) / power if power > 0 else 0.0
    # the estimate of lag-one correlation is low by about (1 + 4 r) / n in short series (Kendall)
    memory = float(np.clip(memory + (1.0 + 4.0 * memory) / n, 0.0, 0.99))
    effective = max(n * (1.0 - memory) / (1.0 + memory), 2.0)
    return float(value.mean()), float(np.sqrt(value.var(ddof=1) / effective)), effective


def drift_test(
    time_s: ArrayLike,
    error_rad: ArrayLike,
    window_s: float = 300.0,
    block_s: float = 10.0,
    quantity: Literal["rmse", "bias"] = "rmse",
) -> DriftTest:
    """Compare the error of the last minutes of a recording with that of the first.

    Parameters
    ----------
    time_s : array_like, shape (N,)
        Clock of the scored part, s, increasing.
    error_rad : array_like, shape (N,)
        Reference minus estimate in rad; NaN where missing.
    window_s : float
        Length of the first and of the last window, s.
    block_s : float
        Length of the blocks that count as observations, s.
    quantity : {"rmse", "bias"}
        Growth of the error's size, or a shift of its mean.

    Returns
    -------
    DriftTest
        Welch's t test between the blocks of both windows.

    Raises
    ------
    MethodNotApplicableError
        If the recording is shorter than two windows, or a window has fewer than three blocks.

    Notes
    -----
    Samples of one walk are far from independent: tested as such, any two windows of an hour
    differ. Blocks of several strides are nearly so, and what memory is left between them (a bias
    that wanders) lowers the number that they count for to ``n (1 - r1) / (1 + r1)``, with the
    lag-one correlation r1 found in each window and corrected for the window's shortness.
    """
    time = np.asarray(time_s, dtype=float)
    duration = float(time[-1] - time[0]) if len(time) else 0.0
    if duration < 2.0 * window_s - block_s:
        raise MethodNotApplicableError(
            f"test for drift: the recording has {duration:g} s, "
            f"expected two windows of {window_s:g} s"
        )
    middle, value = block_errors(time, error_rad, block_s, quantity)
    first = value[middle < time[0] + window_s]
    last = value[middle > time[-1] - window_s]
    if min(len(first), len(last)) < 3:
        raise MethodNotApplicableError(
            f"test for drift: {min(len(first), len(last))} blocks of {block_s:g} s "
            f"in a window of {window_s:g} s, expected three"
        )
    mean_first, error_first, n_first = _mean_and_error(first)
    mean_last, error_last, n_last = _mean_and_error(last)
    change = mean_last - mean_first
    error = float(np.hypot(error_first, error_last))
    if error > 0:
        freedom = error**4 / (error_first**4 / (n_first - 1) + error_last**4 / (n_last - 1))
        reach = float(stats.t.ppf(0.975, freedom)) * error
        p_value = float(2.0 * stats.t.sf(abs(change) / error, freedom))
    else:
        reach, p_value = 0.0, float(change == 0)
    if quantity == "rmse":
        ends = [float(np.sqrt(np.mean(part**2))) for part in (first, last)]
    else:
        ends = [mean_first, mean_last]
    return DriftTest(
        first_deg=ends[0],
        last_deg=ends[1],
        change_deg=change,
        low_deg=change - reach,
        high_deg=change + reach,
        p_value=p_value,
        n_effective=min(n_first, n_last),
        slope_deg_per_h=float(stats.theilslopes(value, middle).slope) * 3600.0,
    )
