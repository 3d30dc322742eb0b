"""Comparison stride by stride: waveforms over the gait cycle, range of motion, peaks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from narx.evaluation.comparison import Evaluated
from narx.gait.strides import POINTS, normalised_strides
from narx.kinematics.segment_angles import AXES
from narx.missing import finite_rows
from narx.types import FloatArray

KEYS = ("dataset", "subject", "condition", "trial", "segment")


@dataclass(frozen=True)
class StrideSet:
    """Strides of one segment or joint in one trial.

    Parameters
    ----------
    dataset, subject, condition, trial, segment : str
        As in the comparison from which the strides were cut.
    reference_deg : ndarray, shape (S, 101, 3)
        Reference angles over 0-100 % of each stride, degrees.
    estimates_deg : mapping of str to ndarray, shape (S, 101, 3)
        The same strides by method; NaN where the method has no estimate.
    """

    dataset: str
    subject: str
    condition: str
    trial: str
    segment: str
    reference_deg: FloatArray
    estimates_deg: Mapping[str, FloatArray]


def cut_strides(evaluated: Evaluated, contacts_s: FloatArray) -> StrideSet:
    """Cut a comparison at foot contacts.

    Parameters
    ----------
    evaluated : Evaluated
        A segment or joint in one trial.
    contacts_s : ndarray, shape (S + 1,)
        Contacts of its foot, s on the clock of `evaluated`.

    Returns
    -------
    StrideSet
        Strides in which every sample is scored and has a reference in at least one axis.
    """
    observed = np.isfinite(evaluated.reference_rad).any(axis=0)
    reference = np.degrees(evaluated.reference_rad)
    reference[~evaluated.scored] = np.nan
    known = normalised_strides(evaluated.time_s, reference[:, observed], contacts_s)
    strides = np.full((*known.shape[:2], 3), np.nan)
    strides[:, :, observed] = known
    whole = np.isfinite(known).all(axis=(1, 2)) if observed.any() else np.zeros(len(known), bool)
    estimates = {}
    for method in evaluated.estimates_rad:
        angles = np.degrees(evaluated.nearest(method))
        axes = [normalised_strides(evaluated.time_s, angles[:, [k]], contacts_s) for k in range(3)]
        estimates[method] = np.concatenate(axes, axis=2)[whole]
    names = {key: getattr(evaluated, key) for key in KEYS}
    return StrideSet(**names, reference_deg=strides[whole], estimates_deg=estimates)


def stride_table(sets: Iterable[StrideSet]) -> pd.DataFrame:
    """Tabulate the range of motion, maximum and minimum angle of every stride.

    Parameters
    ----------
    sets : iterable of StrideSet
        Strides of any number of trials.

    Returns
    -------
    pandas.DataFrame
        One row per stride, axis and method: `KEYS`, axis, method, stride and, in degrees,
        range_reference, range_estimate, maximum_reference, maximum_estimate, minimum_reference,
        minimum_estimate, rmse. Strides without an estimate are left out.
    """
    frames = []
    for one in sets:
        for method, estimate in one.estimates_deg.items():
            for axis, name in enumerate(AXES):
                reference, angles = one.reference_deg[:, :, axis], estimate[:, :, axis]
                valid = np.flatnonzero(finite_rows(reference + angles))
                if not valid.size:
                    continue
                reference, angles = reference[valid], angles[valid]
                frames.append(
                    pd.DataFrame(
                        {
                            **{key: getattr(one, key) for key in KEYS},
                            "axis": name,
                            "method": method,
                            "stride": valid,
                            "range_reference": np.ptp(reference, axis=1),
                            "range_estimate": np.ptp(angles, axis=1),
                            "maximum_reference": reference.max(axis=1),
                            "maximum_estimate": angles.max(axis=1),
                            "minimum_reference": reference.min(axis=1),
                            "minimum_estimate": angles.min(axis=1),
                            "rmse": np.sqrt(np.mean((reference - angles) ** 2, axis=1)),
                        }
                    )
                )
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()


def mean_waveforms(
    sets: Iterable[StrideSet], method: str, axis: int
) -> tuple[FloatArray, FloatArray]:
    """Average the strides of each subject, for tests over the cycle.

    Parameters
    ----------
    sets : iterable of StrideSet
        Strides of any number of trials.
    method : str
        Method whose estimates are used.
    axis : int
        Index into `narx.kinematics.segment_angles.AXES`.

    Returns
    -------
    reference_deg, estimate_deg : ndarray, shape (subjects, 101)
        Means over all strides of a subject that have both, degrees.
    """
    by_subject: dict[tuple[str, str], list[tuple[FloatArray, FloatArray]]] = {}
    for one in sets:
        if method not in one.estimates_deg:
            continue
        pair = one.reference_deg[:, :, axis], one.estimates_deg[method][:, :, axis]
        valid = finite_rows(pair[0] + pair[1])
        if valid.any():
            by_subject.setdefault((one.dataset, one.subject), []).append(
                (pair[0][valid], pair[1][valid])
            )
    means = [
        [np.concatenate(side).mean(axis=0) for side in zip(*pairs, strict=True)]
        for pairs in by_subject.values()
    ]
    stacked = np.array(means).reshape(len(means), 2, POINTS)
    return stacked[:, 0], stacked[:, 1]
