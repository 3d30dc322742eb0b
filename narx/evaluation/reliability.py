"""Clinical reliability: intraclass correlation, standard error, detectable change."""

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd

from narx.types import FloatArray


@dataclass(frozen=True)
class Reliability:
    """Reliability of two instruments that each measured a quantity once on n targets.

    Parameters
    ----------
    n : int
        Targets that both instruments measured.
    icc_2_1 : float
        ICC(2,1) of Shrout and Fleiss (1979): two-way random, absolute agreement.
    icc_2_1_interval : tuple of (float, float)
        Its 95 % interval.
    icc_3_1 : float
        ICC(3,1) of Shrout and Fleiss: two-way mixed, consistency.
    icc_3_1_interval : tuple of (float, float)
        Its 95 % interval.
    sem : float
        Standard error of measurement, in the quantity's unit.
    mdc : float
        Minimal detectable change at 95 %: 1.96 sqrt(2) SEM.
    """

    n: int
    icc_2_1: float
    icc_2_1_interval: tuple[float, float]
    icc_3_1: float
    icc_3_1_interval: tuple[float, float]
    sem: float
    mdc: float


def reliability(reference: FloatArray, estimate: FloatArray) -> Reliability | None:
    """Compare two instruments target by target.

    Parameters
    ----------
    reference, estimate : ndarray, shape (n,)
        The quantity by either instrument, in one unit; pairs with a NaN are left out.

    Returns
    -------
    Reliability or None
        None with fewer than five pairs, for which pingouin gives no result, and if the values do
        not vary.

    Notes
    -----
    The standard error of measurement is the root of the error variance of the two-way analysis of
    variance, including the difference between instruments: ``sqrt(mean(d**2) / 2)`` for differences
    d, the within-target standard deviation of Bland and Altman (1996). It differs from the textbook
    ``SD sqrt(1 - ICC)``, which depends on the spread of the targets.
    """
    reference, estimate = np.asarray(reference, float), np.asarray(estimate, float)
    both = np.isfinite(reference) & np.isfinite(estimate)
    reference, estimate = reference[both], estimate[both]
    n = len(reference)
    if n < 5 or not np.ptp(np.concatenate([reference, estimate])):
        return None
    import pingouin  # slow to import, and needed only for tables

    ratings = pd.DataFrame(
        {
            "target": np.tile(np.arange(n), 2),
            "instrument": np.repeat(["reference", "estimate"], n),
            "value": np.concatenate([reference, estimate]),
        }
    )
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # warnings of pandas about its use by pingouin
        table = pingouin.intraclass_corr(ratings, "target", "instrument", "value")
    table = table.set_index("Type")
    # pingouin's names after McGraw and Wong (1996): A for absolute agreement, C for consistency
    absolute, consistent = table.loc["ICC(A,1)"], table.loc["ICC(C,1)"]
    sem = float(np.sqrt(np.mean((reference - estimate) ** 2) / 2.0))
    return Reliability(
        n,
        float(absolute["ICC"]),
        _interval(absolute["CI95"]),
        float(consistent["ICC"]),
        _interval(consistent["CI95"]),
        sem,
        1.96 * np.sqrt(2.0) * sem,
    )


def _interval(bounds: FloatArray) -> tuple[float, float]:
    low, high = map(float, bounds)
    return low, high
