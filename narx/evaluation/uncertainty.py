"""Calibration of a predicted standard deviation against the actual errors."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from narx.types import FloatArray


@dataclass(frozen=True)
class Calibration:
    """Predicted standard deviation compared with the errors.

    Parameters
    ----------
    n_samples : int
        Samples with an error and a standard deviation.
    coverage_68, coverage_95 : float
        Share of errors inside the central 68 and 95 % band of a normal error of the predicted
        standard deviation (0.994 and 1.960 of it); calibrated: 0.68 and 0.95.
    scale : float
        Factor by which the predicted standard deviation would have to be multiplied, the root mean
        square of error / standard deviation; 1 is calibrated, above 1 overconfident.
    sharpness_deg : float
        Root mean square of the predicted standard deviation, degrees: among calibrated predictions,
        smaller is better.
    """

    n_samples: int
    coverage_68: float
    coverage_95: float
    scale: float
    sharpness_deg: float


def _standardised(error_rad: ArrayLike, std_rad: ArrayLike) -> tuple[FloatArray, FloatArray]:
    error, std = np.asarray(error_rad, dtype=float), np.asarray(std_rad, dtype=float)
    if error.shape != std.shape:
        raise ValueError(f"errors have shape {error.shape}, standard deviations {std.shape}")
    valid = ~(np.isnan(error) | np.isnan(std))
    error, std = error[valid], std[valid]
    if (std < 0).any():
        raise ValueError(f"a standard deviation is negative ({std.min():g})")
    # with a standard deviation of zero, a zero error is inside every band, any other inside none
    ratio = np.where(error == 0, 0.0, np.inf)
    np.divide(np.abs(error), std, out=ratio, where=std > 0)
    return ratio, std


def coverage_curve(error_rad: ArrayLike, std_rad: ArrayLike, levels: ArrayLike) -> FloatArray:
    """Share of errors inside the central band of each level.

    Parameters
    ----------
    error_rad : array_like, shape (N,)
        Reference minus estimate in rad; NaN where missing.
    std_rad : array_like, shape (N,)
        Predicted standard deviation in rad, not negative; NaN where missing.
    levels : array_like, shape (levels,)
        Nominal coverage of each band, in (0, 1).

    Returns
    -------
    ndarray, shape (levels,)
        Observed coverage, equal to `levels` where the prediction is calibrated; NaN without
        samples.
    """
    ratio, _ = _standardised(error_rad, std_rad)
    bounds = stats.norm.ppf(0.5 + np.asarray(levels, dtype=float) / 2.0)
    if len(ratio) == 0:
        return np.full(bounds.shape, np.nan)
    return np.searchsorted(np.sort(ratio), bounds, side="right") / len(ratio)


def calibration(error_rad: ArrayLike, std_rad: ArrayLike) -> Calibration:
    """Compare a predicted standard deviation with the actual errors.

    Parameters
    ----------
    error_rad : array_like, shape (N,)
        Reference minus estimate in rad; NaN where missing.
    std_rad : array_like, shape (N,)
        Predicted standard deviation in rad, not negative; NaN where missing.

    Returns
    -------
    Calibration
        NaN without samples.
    """
    ratio, std = _standardised(error_rad, std_rad)
    low, high = coverage_curve(error_rad, std_rad, [0.68, 0.95])
    if len(ratio) == 0:
        return Calibration(0, float("nan"), float("nan"), float("nan"), float("nan"))
    return Calibration(
        n_samples=len(ratio),
        coverage_68=float(low),
        coverage_95=float(high),
        scale=float(np.sqrt(np.mean(ratio**2))),
        sharpness_deg=float(np.rad2deg(np.sqrt(np.mean(std**2)))),
    )
