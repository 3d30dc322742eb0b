"""Test whether the error grows over a recording."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from narx.errors import MethodNotApplicableError
from narx.types import FloatArray

# smallest number of windows for a useful scatter: four degrees of freedom about a line
_MIN_WINDOWS = 6
_MIN_BLOCKS = 3
# scatter below this is rounding error
_NO_SCATTER_DEG = 1e-9


@dataclass(frozen=True)
class DriftTest:
    """Error at the end of a recording compared with its start.

    Parameters
    ----------
    first_deg, last_deg : float
        RMSE (or bias) in the first and in the last window, degrees.
    change_deg : float
        Mean over the blocks of the last window minus that of the first, degrees.
    low_deg, high_deg : float
        95 % confidence interval of the change, degrees.
    p_value : float
        Two-sided p of no change.
    n_windows : int
        Number of windows whose scatter gives the standard error; 2 for a short recording, where the
        scatter of the blocks within the first and the last window is used.
    freedom : float
        Degrees of freedom of the t test.
    slope_deg_per_h : float
        Theil-Sen slope of the block values over the whole recording, degrees an hour.
    """

    first_deg: float
    last_deg: float
    change_deg: float
    low_deg: float
    high_deg: float
    p_value: float
    n_windows: int
    freedom: float
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
    """Summarise an error in blocks.

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
        Summary of a block.

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
    valid = ~np.isnan(error)
    samples = np.bincount(block)
    count = np.bincount(block[valid], minlength=len(samples))
    value = error[valid] ** 2 if quantity == "rmse" else error[valid]
    total = np.bincount(block[valid], value, minlength=len(samples))
    enough = count > 0.5 * block_s / float(np.median(np.diff(time)))
    mean = total[enough] / count[enough]
    summed_up = np.sqrt(mean) if quantity == "rmse" else mean
    middle = time[0] + (np.flatnonzero(enough) + 0.5) * block_s
    return middle, np.rad2deg(summed_up)


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
        Length of the blocks used as observations, s.
    quantity : {"rmse", "bias"}
        Test for growth of the error's size, or for a shift of its mean.

    Returns
    -------
    DriftTest
        t test of the last window against the first.

    Raises
    ------
    MethodNotApplicableError
        If the recording is shorter than two windows, or a window has fewer than three blocks.

    Notes
    -----
    Samples of one walk are far from independent: tested as if they were, any two windows of an hour
    differ. Nor does any block length make them independent: stride-to-stride fluctuations have long
    memory (scaling exponent about 0.75, J. M. Hausdorff et al., J. Appl. Physiol. 80 (1996)
    1448-1457), so two five-minute means of one steady walk differ by more than the scatter within
    either explains, whatever the method.

    With six windows or more, the standard error therefore comes from the scatter of the *windows*
    about a straight line through all of them. It includes fluctuations slower than a block, but not
    steady growth. Last minus first has twice its variance, with n - 2 degrees of freedom. Both end
    windows influence the line, so the scatter is not quite independent of their difference, which
    changes the size to 4 % instead of 5 % for independent windows. Alternatives were tried on
    simulated walks. A line through the inner windows alone is exact for independent windows, but
    finds a ramp of six scatters in an hour as often and in half an hour less often (45 instead of
    73 %), and is less accurate with long memory. A memory estimated from one-minute means is often
    wrong (size 0.3 to 12 %).

    Shorter recordings compare the blocks of both windows by Welch's test. Correlation between
    blocks reduces their effective number to ``n (1 - r1) / (1 + r1)``, with the lag-one correlation
    r1 found in each window and corrected for the short window. Fluctuations slower than a window
    are not accounted for.
    """
    time = np.asarray(time_s, dtype=float)
    interval = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    duration = float(time[-1] - time[0]) + interval if len(time) else 0.0
    if duration < 2.0 * window_s - block_s:
        raise MethodNotApplicableError(
            f"test for drift: the recording has {duration:g} s, "
            f"expected two windows of {window_s:g} s"
        )
    middle, value = block_errors(time, error_rad, block_s, quantity)
    # as many windows as fit, the first at the start and the last at the end
    n_windows = max(2, int((duration + block_s) // window_s))
    begins = time[0] + np.linspace(0.0, duration - window_s, n_windows)
    windows = [value[(middle > begin) & (middle < begin + window_s)] for begin in begins]
    first, last = windows[0], windows[-1]
    fewest = min(len(first), len(last))
    if fewest < _MIN_BLOCKS:
        raise MethodNotApplicableError(
            f"test for drift: {fewest} blocks of {block_s:g} s "
            f"in a window of {window_s:g} s, expected three"
        )
    enough = np.array([len(window) >= _MIN_BLOCKS for window in windows])
    n_windows = int(enough.sum())
    if n_windows >= _MIN_WINDOWS:
        means = np.array([w.mean() for w, use in zip(windows, enough, strict=True) if use])
        error, freedom = _scatter_of_windows(begins[enough], means)
    else:
        n_windows = 2
        error, freedom = _scatter_of_blocks(first, last)
    change = float(last.mean() - first.mean())
    if error > _NO_SCATTER_DEG:
        reach = float(stats.t.ppf(0.975, freedom)) * error
        p_value = float(2.0 * stats.t.sf(abs(change) / error, freedom))
    else:
        reach, p_value = 0.0, float(abs(change) <= _NO_SCATTER_DEG)
    if quantity == "rmse":
        ends = [float(np.sqrt(np.mean(part**2))) for part in (first, last)]
    else:
        ends = [float(part.mean()) for part in (first, last)]
    return DriftTest(
        first_deg=ends[0],
        last_deg=ends[1],
        change_deg=change,
        low_deg=change - reach,
        high_deg=change + reach,
        p_value=p_value,
        n_windows=n_windows,
        freedom=freedom,
        slope_deg_per_h=float(stats.theilslopes(value, middle).slope) * 3600.0,
    )


def _scatter_of_windows(begin_s: FloatArray, means: FloatArray) -> tuple[float, float]:
    """Standard error of last minus first by the scatter about a line; degrees of freedom."""
    line = stats.linregress(begin_s, means)
    rest = means - (line.intercept + line.slope * begin_s)
    freedom = len(means) - 2
    return float(np.sqrt(2.0 * (rest @ rest) / freedom)), float(freedom)


def _scatter_of_blocks(first: FloatArray, last: FloatArray) -> tuple[float, float]:
    """Standard error of last minus first by the blocks of both; Welch's degrees of freedom."""
    error_first, n_first = _standard_error(first)
    error_last, n_last = _standard_error(last)
    error = float(np.hypot(error_first, error_last))
    if error == 0:
        return 0.0, n_first + n_last - 2
    spread = error_first**4 / (n_first - 1) + error_last**4 / (n_last - 1)
    return error, error**4 / spread


def _standard_error(value: FloatArray) -> tuple[float, float]:
    """Standard error of the mean, and the effective number of values (first-order correlation)."""
    n = len(value)
    centred = value - value.mean()
    power = float(centred @ centred)
    memory = float(centred[:-1] @ centred[1:]) / power if power > 0 else 0.0
    # the estimate of lag-one correlation is low by about (1 + 4 r) / n in short series (Kendall)
    memory = max(memory + (1.0 + 4.0 * memory) / n, 0.0)
    effective = max(n * (1.0 - memory) / (1.0 + memory), 2.0)
    return float(np.sqrt(value.var(ddof=1) / effective)), effective
