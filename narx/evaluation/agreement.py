"""Agreement of an estimated angle with its reference.

Error is reference minus estimate (Tham et al., 2020, eqs. (10) and (11)). Angles are given in rad
and agreement is returned in degrees. Pairs in which either is NaN are left out. Differences are not
wrapped: headings are unwrapped where they are computed, and an error of a whole turn counts as an
error.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from narx.types import FloatArray

# half width of the limits of agreement in standard deviations (Bland and Altman, 1986)
LIMITS_SD = 1.96
# a joint that is held still: what varies is the rounding of its quaternions
_STILL_RAD = 1e-9


@dataclass(frozen=True)
class Agreement:
    """Agreement of one estimated angle with its reference.

    Parameters
    ----------
    n_samples : int
        Number of pairs without a missing value.
    bias_deg : float
        Mean error, degrees.
    precision_deg : float
        Standard deviation of the error (n - 1 in the denominator), degrees.
    rmse_deg : float
        Root mean square error, degrees.
    r : float
        Pearson's correlation; NaN where either signal varies by less than 1e-9 rad.
    loa_lower_deg, loa_upper_deg : float
        95 % limits of agreement, bias -+ 1.96 precision, degrees.
    """

    n_samples: int
    bias_deg: float
    precision_deg: float
    rmse_deg: float
    r: float
    loa_lower_deg: float
    loa_upper_deg: float


def _pairs(a: ArrayLike, b: ArrayLike) -> tuple[FloatArray, FloatArray]:
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if first.ndim != 1 or first.shape != second.shape:
        raise ValueError(f"got shapes {first.shape} and {second.shape}, expected twice (N,)")
    valid = ~(np.isnan(first) | np.isnan(second))
    return first[valid], second[valid]


def correlation(a: ArrayLike, b: ArrayLike) -> float:
    """Pearson's correlation of the pairs without a missing value.

    Parameters
    ----------
    a, b : array_like, shape (N,)
        Two signals; NaN where missing.

    Returns
    -------
    float
        In [-1, 1]; NaN below two pairs or where a signal is constant.
    """
    first, second = _pairs(a, b)
    if len(first) < 2 or not (np.isfinite(first).all() and np.isfinite(second).all()):
        return float("nan")
    normed = []
    for signal in (first, second):
        # squares of very small or large values would under- or overflow
        scaled = signal / (np.abs(signal).max() or 1.0)
        centred = scaled - scaled.mean()
        norm = np.linalg.norm(centred)
        # rounding errors of a constant are not variation
        if norm <= 1e-13 * np.sqrt(len(signal)):
            return float("nan")
        normed.append(centred / norm)
    return float(np.clip(normed[0] @ normed[1], -1.0, 1.0))


def agreement(reference_rad: ArrayLike, estimate_rad: ArrayLike) -> Agreement:
    """Compare an estimated angle with its reference.

    Parameters
    ----------
    reference_rad, estimate_rad : array_like, shape (N,)
        Both angles in rad on the same clock; NaN where missing.

    Returns
    -------
    Agreement
        In degrees. Without pairs, everything except the count is NaN; with a single pair, the
        values that need a standard deviation are. An infinite estimate is not missing: its RMSE is
        infinite and the rest NaN.
    """
    reference, estimate = _pairs(reference_rad, estimate_rad)
    n = len(reference)
    nan = float("nan")
    if n == 0 or not (np.isfinite(reference).all() and np.isfinite(estimate).all()):
        return Agreement(n, nan, nan, float("inf") if n else nan, nan, nan, nan)
    error = np.rad2deg(reference - estimate)
    bias = float(error.mean())
    precision = float(error.std(ddof=1)) if n > 1 else float("nan")
    still = min(np.ptp(reference), np.ptp(estimate)) < _STILL_RAD
    return Agreement(
        n_samples=n,
        bias_deg=bias,
        precision_deg=precision,
        rmse_deg=float(np.sqrt(np.mean(error**2))),
        r=nan if still else correlation(reference, estimate),
        loa_lower_deg=bias - LIMITS_SD * precision,
        loa_upper_deg=bias + LIMITS_SD * precision,
    )


@dataclass(frozen=True)
class LimitsOfAgreement:
    """Bias and limits of agreement with confidence intervals, all in the unit of the errors.

    Parameters
    ----------
    n_subjects, n_samples : int
        Number of subjects, and of their errors.
    bias, sd, lower, upper : float
        Mean error, its standard deviation, and the limits ``bias -+ 1.96 sd``.
    bias_interval, lower_interval, upper_interval : tuple of float
        Confidence intervals of the three.
    """

    n_subjects: int
    n_samples: int
    bias: float
    sd: float
    lower: float
    upper: float
    bias_interval: tuple[float, float]
    lower_interval: tuple[float, float]
    upper_interval: tuple[float, float]


def limits_of_agreement(errors: ArrayLike, confidence: float = 0.95) -> LimitsOfAgreement:
    """Limits of agreement of independent errors, one per subject, with exact intervals.

    Parameters
    ----------
    errors : array_like, shape (n,)
        Independent errors in any unit; NaN are left out. For the samples of recordings, which are
        not independent, use `repeated_limits_of_agreement`.
    confidence : float
        Coverage of the intervals.

    Returns
    -------
    LimitsOfAgreement
        Its intervals are exact for normal errors: a limit is a quantile of the population, whose
        interval follows from the non-central t distribution (A. Carkeet, Optom. Vis. Sci. 92
        (2015) e71-e80); Bland and Altman (1986) use an approximation.
    """
    error = np.asarray(errors, dtype=float).ravel()
    error = error[np.isfinite(error)]
    n = len(error)
    if n < 2:
        raise ValueError(f"limits of agreement need two errors, got {n}")
    bias, sd = float(error.mean()), float(error.std(ddof=1))
    tails = np.array([0.5 - confidence / 2, 0.5 + confidence / 2])
    half_width = float(stats.t.ppf(tails[1], n - 1)) * sd / np.sqrt(n)
    reach = stats.nct.ppf(tails, n - 1, LIMITS_SD * np.sqrt(n)) / np.sqrt(n)
    near, far = (float(x) * sd for x in reach)
    return LimitsOfAgreement(
        n_subjects=n,
        n_samples=n,
        bias=bias,
        sd=sd,
        lower=bias - LIMITS_SD * sd,
        upper=bias + LIMITS_SD * sd,
        bias_interval=(bias - half_width, bias + half_width),
        lower_interval=(bias - far, bias - near),
        upper_interval=(bias + near, bias + far),
    )


def repeated_limits_of_agreement(
    errors: ArrayLike, subjects: ArrayLike, confidence: float = 0.95
) -> LimitsOfAgreement:
    """Limits of agreement with many errors per subject.

    Parameters
    ----------
    errors : array_like, shape (N,)
        Errors in any unit; NaN are left out.
    subjects : array_like, shape (N,)
        Subject of each error.
    confidence : float
        Coverage of the intervals.

    Returns
    -------
    LimitsOfAgreement
        `sd` is that of one error of a new subject: variance between subjects plus variance within.

    Notes
    -----
    Pooling all samples treats each as a new person: the limits are then too narrow if people
    differ, and their intervals far too narrow. Variance components as in Bland and Altman, J.
    Biopharm. Stat. 17 (2007) 571-582 (true value varies); intervals by the method of variance
    estimates recovery (G. Y. Zou, Stat. Methods Med. Res. 22 (2013) 630-642). All subjects have the
    same weight. Autocorrelation within a recording affects only the within-subject part, whose
    share in the intervals is small for long recordings.
    """
    error = np.asarray(errors, dtype=float).ravel()
    _, code = np.unique(np.asarray(subjects).ravel(), return_inverse=True)
    valid = np.isfinite(error)
    _, code = np.unique(code[valid], return_inverse=True)
    error = error[valid]
    count = np.bincount(code)
    n = len(count)
    if n < 2:
        raise ValueError(f"repeated limits of agreement need two subjects, got {n}")
    means = np.bincount(code, error) / count
    bias, between = float(means.mean()), float(means.var(ddof=1))
    df_within = len(error) - n
    within = float(np.sum((error - means[code]) ** 2) / df_within) if df_within else 0.0
    # the variance of the means already contains within / count
    share = 1.0 - float(np.mean(1.0 / count))
    variance = between + share * within
    sd = float(np.sqrt(variance))

    tails = np.array([0.5 + confidence / 2, 0.5 - confidence / 2])
    variance_interval = []
    for tail, sign in zip(tails, (-1.0, 1.0), strict=True):
        spread = between * ((n - 1) / stats.chi2.ppf(tail, n - 1) - 1.0)
        if df_within:
            part = share * within * (df_within / stats.chi2.ppf(tail, df_within) - 1.0)
            spread = np.hypot(spread, part)
        variance_interval.append(max(variance + sign * abs(spread), 0.0))
    sd_low, sd_high = np.sqrt(variance_interval)
    half_width = float(stats.t.ppf(tails[0], n - 1)) * np.sqrt(between / n)
    inward = float(np.hypot(half_width, LIMITS_SD * (sd - sd_low)))
    outward = float(np.hypot(half_width, LIMITS_SD * (sd_high - sd)))
    lower, upper = bias - LIMITS_SD * sd, bias + LIMITS_SD * sd
    return LimitsOfAgreement(
        n_subjects=n,
        n_samples=len(error),
        bias=bias,
        sd=sd,
        lower=lower,
        upper=upper,
        bias_interval=(bias - float(half_width), bias + float(half_width)),
        lower_interval=(lower - outward, lower + inward),
        upper_interval=(upper - inward, upper + outward),
    )
