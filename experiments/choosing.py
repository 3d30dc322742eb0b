"""Choose a method's parameters on the training part of a fold, as for the network."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from hydra.utils import instantiate

from narx.calibration.calibrate import CalibratedSegment
from narx.datasets.splits import Fold, TrialPart
from narx.errors import MethodNotApplicableError
from narx.experiments.side_by_side import side_by_side
from narx.method import OrientationMethod, SegmentSignals
from narx.recordings.trial import Trial
from narx.types import BoolArray, FloatArray

Prepare = Callable[[TrialPart], tuple[Trial, Mapping[str, CalibratedSegment]]]


@dataclass(frozen=True)
class _Stretch:
    """A segment of a training trial up to the end of its training part, and the scored samples."""

    trial: tuple[str, ...]
    signals: SegmentSignals
    reference_rad: FloatArray
    counts: BoolArray


class TrainingPart:
    """The part of a fold that may be used to choose parameters.

    Parameters
    ----------
    fold : Fold
        Its training and validation parts are used; the test part is not.
    prepare : callable
        Loads and calibrates a trial.
    skip_s : float
        Length of the start of each trial that is not scored, s.
    """

    def __init__(
        self,
        fold: Fold,
        prepare: Prepare,
        skip_s: float,
    ) -> None:
        self._stretches: list[_Stretch] = []
        by_trial: dict[tuple[str, ...], list[TrialPart]] = {}
        for part in (*fold.training, *fold.validation):
            by_trial.setdefault(part.key, []).append(part)
        for key, parts in by_trial.items():
            trial, calibrated = prepare(parts[0])
            self._stretches += _stretches(key, trial, calibrated, parts, skip_s)

    def __bool__(self) -> bool:
        return bool(self._stretches)

    def error_rad(
        self, method: OrientationMethod, axis_weights: Sequence[float], offset_free: bool
    ) -> float:
        """Compute the error of a method on the training part.

        Parameters
        ----------
        method : OrientationMethod
            With the parameters to evaluate.
        axis_weights : sequence of float
            Weights of the squared errors of the axes, as in the network's objective.
        offset_free : bool
            Subtract the mean error of each stretch first, as in the network's objective.

        Returns
        -------
        float
            Root mean square error of the weighted axes, mean over trials, rad; infinite if the
            method is not applicable to one of the trials.
        """
        squares: dict[tuple[str, ...], list[float]] = {}
        for stretch in self._stretches:
            try:
                angles = method.estimate(stretch.signals)
            except MethodNotApplicableError:
                return float("inf")
            error = (stretch.reference_rad - angles)[stretch.counts]
            error -= 2.0 * np.pi * np.round(error / (2.0 * np.pi))
            for axis in map(int, np.flatnonzero(axis_weights)):
                here = error[np.isfinite(error[:, axis]), axis]
                if len(here):
                    square = np.var(here) if offset_free else np.mean(here**2)
                    squares.setdefault(stretch.trial, []).append(axis_weights[axis] * square)
        if not squares:
            return float("inf")
        return float(np.mean([np.sqrt(np.mean(of_trial)) for of_trial in squares.values()]))


def _stretches(
    key: tuple[str, ...],
    trial: Trial,
    calibrated: Mapping[str, CalibratedSegment],
    parts: Sequence[TrialPart],
    skip_s: float,
) -> Iterable[_Stretch]:
    time_s = trial.time_s - trial.time_s[0]
    stop = int(np.searchsorted(time_s, max(part.stop_s for part in parts)))
    counts = np.zeros(stop, dtype=bool)
    for part in parts:
        counts |= (time_s[:stop] >= max(skip_s, part.start_s)) & (time_s[:stop] < part.stop_s)
    if trial.scored is not None:
        counts &= trial.scored[:stop]
    for segment in calibrated.values():
        if segment.reference_angles_rad is not None:
            signals = segment.signals.select(slice(0, stop))
            yield _Stretch(key, signals, segment.reference_angles_rad[:stop], counts)


def choose_parameters(
    settings: Mapping[str, Any],
    grid: Mapping[str, Sequence[Any]],
    training: TrainingPart,
    axis_weights: Sequence[float],
    offset_free: bool,
) -> dict[str, Any]:
    """Choose the grid point with the smallest error on the training part.

    This equals leaving out one training trial at a time, as is done for the network's candidates:
    these methods have no trained weights, so the error on a trial does not depend on whether it
    was left out.

    Parameters
    ----------
    settings : mapping
        Settings of the method, with ``_target_``.
    grid : mapping of str to sequence
        Candidate values of each parameter.
    training : TrainingPart
        Computes the error of every grid point.
    axis_weights : sequence of float
        Weights of the squared errors of the axes.
    offset_free : bool
        Whether the mean error does not count.

    Returns
    -------
    dict
        The chosen value of every parameter of the grid (the first point in a tie); empty if no
        point has a finite error.
    """
    points = [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]
    methods = [instantiate(dict(settings) | point, _convert_="all") for point in points]
    errors = list(
        side_by_side(lambda method: training.error_rad(method, axis_weights, offset_free), methods)
    )
    best = int(np.argmin(errors))
    return points[best] if np.isfinite(errors[best]) else {}
