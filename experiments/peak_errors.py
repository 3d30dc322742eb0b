"""A thigh's swing angle as Abhayasinghe et al. (2019, sections 2 and 3.1) compare it.

Both angles go to 1000 samples a second by linear interpolation and are trimmed from the first to
the last minimum; then come correlation, RMSE, and the errors of the positive and negative peaks,
because those give the opening angle of a stride. In the paper the two recordings had separate
clocks, and "identical points" were matched by hand; here reference and estimate share one clock,
so both are trimmed at the reference's minima and a method's lag increases its error.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import signal

from narx.errors import MethodNotApplicableError
from narx.evaluation.agreement import agreement
from narx.evaluation.comparison import Evaluated
from narx.kinematics.segment_angles import SAGITTAL
from narx.types import BoolArray, FloatArray

RATE_HZ = 1000.0
# shorter than any stride, running included
SHORTEST_STRIDE_S = 0.5
# prominence of a peak as a share of the waveform's range; ripples are less prominent
PROMINENCE = 0.3
# an estimated peak further away than this belongs to a different event
LARGEST_LAG_S = 0.25

PEAKS = ("positive", "negative")


@dataclass(frozen=True)
class Swing:
    """Reference and estimate from minimum to minimum.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Clock at `RATE_HZ`.
    reference_deg, estimate_deg : ndarray, shape (N,)
        Both angles, degrees.
    """

    time_s: FloatArray
    reference_deg: FloatArray
    estimate_deg: FloatArray


def _longest_run(there: BoolArray) -> slice:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], there, [False]]).astype(int)))
    starts, stops = edges[::2], edges[1::2]
    if not len(starts):
        return slice(0, 0)
    k = int(np.argmax(stops - starts))
    return slice(int(starts[k]), int(stops[k]))


def _peaks(angle_deg: FloatArray, kind: str) -> NDArray[np.intp]:
    upright = angle_deg if kind == "positive" else -angle_deg
    low, high = np.percentile(upright, [2.5, 97.5])
    peaks, _ = signal.find_peaks(
        upright,
        distance=max(1, round(SHORTEST_STRIDE_S * RATE_HZ)),
        prominence=max(PROMINENCE * (high - low), 1e-9),
    )
    return np.asarray(peaks)


def swing(evaluated: Evaluated, method: str, axis: int = SAGITTAL) -> Swing:
    """Resample and trim one angle as the paper does.

    Parameters
    ----------
    evaluated : Evaluated
        A thigh (any segment whose angle goes up and down once a stride).
    method : str
        Method whose estimate is used.
    axis : int
        Index into `narx.kinematics.segment_angles.AXES`.

    Returns
    -------
    Swing
        The longest scored stretch without a gap, from the reference's first to its last minimum.

    Raises
    ------
    MethodNotApplicableError
        If fewer than two minima are in it.
    """
    reference = np.rad2deg(evaluated.reference_rad[:, axis])
    estimate = np.rad2deg(evaluated.estimates_rad[method][:, axis])
    run = _longest_run(evaluated.scored & np.isfinite(reference) & np.isfinite(estimate))
    time = evaluated.time_s[run]
    minima: NDArray[np.intp] = np.empty(0, dtype=np.intp)
    if len(time) > 1:
        fine = np.arange(time[0], time[-1], 1.0 / RATE_HZ)
        reference = np.interp(fine, time, reference[run])
        estimate = np.interp(fine, time, estimate[run])
        minima = _peaks(reference, "negative")
    if len(minima) < 2:
        raise MethodNotApplicableError(
            f"{evaluated.name}: {len(minima)} minima of the reference angle in the longest scored "
            "stretch without a gap, expected two to trim between"
        )
    part = slice(int(minima[0]), int(minima[-1]) + 1)
    return Swing(fine[part], reference[part], estimate[part])


def peak_errors(angles: Swing) -> pd.DataFrame:
    """Match the peaks of reference and estimate.

    Parameters
    ----------
    angles : Swing
        From `swing`.

    Returns
    -------
    pandas.DataFrame
        One row per pair of peaks that are mutual nearest neighbours, at most `LARGEST_LAG_S` apart:
        ``peak`` (positive, negative), ``time_s``, ``lag_s`` (estimate after reference),
        ``reference_deg``, ``estimate_deg``, ``error_deg``. Each angle is read at its own peak.
        The two minima at which the waveforms are trimmed are left out: only half of each remains.
    """
    reference, estimate = angles.reference_deg, angles.estimate_deg
    farthest = round(LARGEST_LAG_S * RATE_HZ)
    tables = []
    for kind in PEAKS:
        true, found = _peaks(reference, kind), _peaks(estimate, kind)
        pairs = []
        for k in true:
            if not len(found):
                break
            nearest = found[np.argmin(np.abs(found - k))]
            mutual = true[np.argmin(np.abs(true - nearest))] == k
            if mutual and abs(nearest - k) <= farthest:
                pairs.append((k, nearest))
        index = np.array(pairs, dtype=int).reshape(-1, 2)
        tables.append(
            pd.DataFrame(
                {
                    "peak": kind,
                    "time_s": angles.time_s[index[:, 0]],
                    "lag_s": (index[:, 1] - index[:, 0]) / RATE_HZ,
                    "reference_deg": reference[index[:, 0]],
                    "estimate_deg": estimate[index[:, 1]],
                    "error_deg": reference[index[:, 0]] - estimate[index[:, 1]],
                }
            )
        )
    return pd.concat(tables, ignore_index=True)


def swing_results(
    all_evaluated: Iterable[Evaluated], groups: dict[str, str] | None = None
) -> tuple[pd.DataFrame, pd.DataFrame, list[str]]:
    """Compare the swing angle of every trial and method.

    Parameters
    ----------
    all_evaluated : iterable of Evaluated
        Thighs.
    groups : dict of str to str, optional
        Group of each subject (in the paper: Males and Females); by default there is only ``All``.

    Returns
    -------
    trials : pandas.DataFrame
        One row per trial, segment and method: its names, ``group``, ``r``, ``rmse_deg``,
        ``bias_deg``, ``precision_deg``.
    peaks : pandas.DataFrame
        The rows of `peak_errors` with the same names.
    refused : list of str
        Reasons for missing trials, one line each.
    """
    trials: list[dict[str, object]] = []
    peaks, refused = [], []
    for evaluated in all_evaluated:
        names: dict[str, str] = {
            key: getattr(evaluated, key)
            for key in ("dataset", "subject", "condition", "trial", "segment")
        }
        names["group"] = (groups or {}).get(evaluated.subject, "All")
        for method in evaluated.estimates_rad:
            try:
                angles = swing(evaluated, method)
            except MethodNotApplicableError as error:
                refused.append(f"{method}: {error}")
                continue
            result = agreement(np.deg2rad(angles.reference_deg), np.deg2rad(angles.estimate_deg))
            trials.append(
                {
                    **names,
                    "method": method,
                    "r": result.r,
                    "rmse_deg": result.rmse_deg,
                    "bias_deg": result.bias_deg,
                    "precision_deg": result.precision_deg,
                }
            )
            peaks.append(peak_errors(angles).assign(**names, method=method))
    columns = ["dataset", "subject", "condition", "trial", "segment", "group", "method"]
    return (
        pd.DataFrame(trials, columns=[*columns, "r", "rmse_deg", "bias_deg", "precision_deg"]),
        pd.concat(peaks, ignore_index=True)
        if peaks
        else pd.DataFrame(columns=[*columns, "peak", "error_deg"]),
        refused,
    )
