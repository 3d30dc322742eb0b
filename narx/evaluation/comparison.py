"""Results of the methods in an experiment: estimated angles with their reference.

Tables are made from `rows`, which use every sample; figures from `Evaluated.decimated`, so that
hours of every method at 500 Hz need not stay in memory.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from narx.evaluation.agreement import agreement
from narx.evaluation.results import COLUMNS, NAMES
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import AXES, TRANSVERSE, orientation_from_angles
from narx.recordings.trial import side_of
from narx.types import BoolArray, FloatArray

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Evaluated:
    """Reference and estimated angles of one segment or joint in one trial.

    Parameters
    ----------
    dataset, subject, condition, trial : str
        Names used by the source.
    segment : str
        ``thigh_right``, ``shank_left``, ``knee_right``, ...
    sampling_rate_hz : float
        Rate of the clock.
    time_s : ndarray, shape (N,)
        Clock of the trial, s.
    reference_rad : ndarray, shape (N, 3)
        Angles in the order of `narx.kinematics.segment_angles.AXES`; NaN where missing.
    estimates_rad : mapping of str to ndarray, shape (N, 3)
        The same by method.
    scored : ndarray of bool, shape (N,)
        Samples that are scored.
    std_rad : mapping of str to ndarray, shape (N, 3)
        Standard deviation predicted by the methods that do so.

    Raises
    ------
    ValueError
        If lengths differ.
    """

    dataset: str
    subject: str
    condition: str
    trial: str
    segment: str
    sampling_rate_hz: float
    time_s: FloatArray
    reference_rad: FloatArray
    estimates_rad: Mapping[str, FloatArray]
    scored: BoolArray
    std_rad: Mapping[str, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = len(self.time_s)
        angles = {"reference": self.reference_rad, **self.estimates_rad}
        angles |= {f"standard deviation of {name}": std for name, std in self.std_rad.items()}
        for name, array in angles.items():
            if array.shape != (n, 3):
                raise ValueError(f"{self.name}: {name} has shape {array.shape}, not ({n}, 3)")
        if self.scored.shape != (n,):
            raise ValueError(f"{self.name}: scored has shape {self.scored.shape}, not ({n},)")

    @property
    def name(self) -> str:
        """All names joined, for messages and titles."""
        return "/".join((self.dataset, self.subject, self.condition, self.trial, self.segment))

    def error_deg(self, method: str) -> FloatArray:
        """Errors of a method, reference minus estimate, at scored samples.

        Parameters
        ----------
        method : str
            Key of `estimates_rad`.

        Returns
        -------
        ndarray, shape (N, 3)
            Degrees; NaN where something is missing or not scored.
        """
        error = np.rad2deg(self.reference_rad - self.nearest(method))
        error[~self.scored] = np.nan
        return error

    def nearest(self, method: str) -> FloatArray:
        """Estimates of a method, shifted by whole turns to be nearest to the reference.

        Parameters
        ----------
        method : str
            Key of `estimates_rad`.

        Returns
        -------
        ndarray, shape (N, 3)
            rad, within half a turn of the reference: an angle of 350 degrees is 10 degrees off.
        """
        estimate = self.estimates_rad[method]
        difference = self.reference_rad - estimate
        # the rule; rounding takes several times as long
        if not (np.abs(difference) > 0.5 * _TURN).any():
            return estimate
        turns = np.round(difference / _TURN)
        return np.where(np.isfinite(turns), estimate + _TURN * turns, estimate)

    def between(self, start_s: float, stop_s: float) -> "Evaluated":
        """Cut out a piece of time.

        Parameters
        ----------
        start_s, stop_s : float
            Start (included) and end (excluded), on the trial's clock.

        Returns
        -------
        Evaluated
            With views of the same arrays.
        """
        return self._select(
            slice(*(int(k) for k in np.searchsorted(self.time_s, (start_s, stop_s))))
        )

    def decimated(self, rate_hz: float) -> "Evaluated":
        """Keep about `rate_hz` samples a second, for figures.

        Parameters
        ----------
        rate_hz : float
            Requested rate; every k-th sample is kept, with k rounded to the nearest whole number.

        Returns
        -------
        Evaluated
            With copies, so that the long arrays can be freed. Samples are selected, not filtered:
            each is still a true pair of reference and estimate.
        """
        step = max(1, round(self.sampling_rate_hz / rate_hz))
        picked = self._select(slice(None, None, step))
        return replace(
            picked,
            sampling_rate_hz=self.sampling_rate_hz / step,
            time_s=picked.time_s.copy(),
            reference_rad=picked.reference_rad.copy(),
            estimates_rad={name: a.copy() for name, a in picked.estimates_rad.items()},
            scored=picked.scored.copy(),
            std_rad={name: a.copy() for name, a in picked.std_rad.items()},
        )

    def _select(self, part: slice) -> "Evaluated":
        return replace(
            self,
            time_s=self.time_s[part],
            reference_rad=self.reference_rad[part],
            estimates_rad={name: a[part] for name, a in self.estimates_rad.items()},
            scored=self.scored[part],
            std_rad={name: a[part] for name, a in self.std_rad.items()},
        )


def knee(
    thigh: Evaluated,
    shank: Evaluated,
    reference_wxyz: tuple[FloatArray, FloatArray] | None = None,
) -> Evaluated:
    """Compute knee angles from the angles of thigh and shank.

    Parameters
    ----------
    thigh, shank : Evaluated
        Segments of one leg in one trial; methods present for only one of them are left out.
    reference_wxyz : tuple of two ndarrays, shape (N, 4), optional
        Reference orientations of thigh and shank (mirrored to a right leg), for walks with turns,
        where the reference angles lack the heading. Otherwise composed from the angles.

    Returns
    -------
    Evaluated
        Of ``knee_right`` (or left), Grood and Suntay (`narx.kinematics.joint_angles.grood_suntay`).
        A method that never observes the transverse axis of a segment is composed with a
        heading of zero there, as Tham et al. compute the complementary filter's knee in two
        dimensions, and the knee's transverse angle is NaN. Predicted variances of both segments add
        up, which assumes independent errors and a nearly straight knee in the frontal plane.

    Raises
    ------
    ValueError
        If the two are not of the same leg, trial and length.
    """
    names = ("dataset", "subject", "condition", "trial", "sampling_rate_hz")
    different = [name for name in names if getattr(thigh, name) != getattr(shank, name)]
    side = side_of(thigh.segment)
    if different or side != side_of(shank.segment) or len(thigh.time_s) != len(shank.time_s):
        raise ValueError(f"{thigh.name} and {shank.name} do not meet in a knee")
    if reference_wxyz is None:
        reference_wxyz = (
            orientation_from_angles(thigh.reference_rad),
            orientation_from_angles(shank.reference_rad),
        )
    estimates = {
        method: _knee_angles(angles, shank.estimates_rad[method])
        for method, angles in thigh.estimates_rad.items()
        if method in shank.estimates_rad
    }
    return replace(
        thigh,
        segment="knee" if side is None else f"knee_{side}",
        reference_rad=grood_suntay(*reference_wxyz),
        estimates_rad=estimates,
        scored=thigh.scored & shank.scored,
        std_rad={
            method: np.hypot(std, shank.std_rad[method])
            for method, std in thigh.std_rad.items()
            if method in shank.std_rad
        },
    )


def _knee_angles(thigh_rad: FloatArray, shank_rad: FloatArray) -> FloatArray:
    orientations, observed = [], True
    for angles in (thigh_rad, shank_rad):
        if np.isnan(angles[:, TRANSVERSE]).all():
            observed = False
            angles = angles.copy()
            angles[:, TRANSVERSE] = 0.0
        orientations.append(orientation_from_angles(angles))
    angles = grood_suntay(*orientations)
    if not observed:
        angles[:, TRANSVERSE] = np.nan
    return angles


def lag_s(error: FloatArray, slope: FloatArray) -> float:
    """Estimate the lag of an angle.

    Parameters
    ----------
    error : ndarray, shape (N,)
        Reference minus estimate; NaN where missing.
    slope : ndarray, shape (N,)
        Derivative of the reference by time, 1/s.

    Returns
    -------
    float
        Lag, s; positive if the estimate is late, NaN if the reference does not move. To first
        order ``reference(t) - reference(t - lag) = lag * slope``, so it is the regression
        coefficient of the error on the slope. Other phase errors are included in it.
    """
    there = np.isfinite(error) & np.isfinite(slope)
    slope = slope[there] - slope[there].mean() if there.any() else slope[there]
    size = float(slope @ slope)
    return float(slope @ error[there]) / size if size > 0.0 else float("nan")


def rows(evaluated: Evaluated) -> list[dict[str, Any]]:
    """Compare every method with the reference, axis by axis.

    Parameters
    ----------
    evaluated : Evaluated
        One segment or joint in one trial.

    Returns
    -------
    list of dict
        One row per axis and method with the keys `COLUMNS`; an axis without valid pairs has
        ``n_samples`` 0 and NaN.
    """
    table = []
    slope = np.full_like(evaluated.reference_rad, np.nan)
    if len(slope) > 1:
        slope = np.gradient(evaluated.reference_rad, 1.0 / evaluated.sampling_rate_hz, axis=0)
    # one contiguous row per axis
    references = np.ascontiguousarray(evaluated.reference_rad[evaluated.scored].T)
    slopes = np.ascontiguousarray(slope[evaluated.scored].T)
    for method in evaluated.estimates_rad:
        estimates = np.ascontiguousarray(evaluated.nearest(method)[evaluated.scored].T)
        for axis, name in enumerate(AXES):
            result = agreement(references[axis], estimates[axis])
            row = {key: getattr(evaluated, key) for key in NAMES[:5]}
            row |= {"axis": name, "method": method, **vars(result)}
            row["lag_ms"] = 1e3 * lag_s(references[axis] - estimates[axis], slopes[axis])
            table.append({key: row[key] for key in COLUMNS})
    return table
