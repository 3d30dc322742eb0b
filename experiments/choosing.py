"""Choose a method's parameters on the training part of a fold, as the network's are chosen."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from hydra.utils import instantiate

from narx.calibration.calibrate import CalibratedSegment
from narx.datasets.splits import Fold, TrialPart
from narx.errors import MethodNotApplicableError
from narx.method import OrientationMethod, SegmentSignals
from narx.recordings.trial import Trial
from narx.types import BoolArray, FloatArray

Prepare = Callable[[TrialPart], tuple[Trial, Mapping[str, CalibratedSegment]]]


@dataclass(frozen=True)
class _Stretch:
    """A segment of a training trial up to where training ends, and which samples count."""

    trial: tuple[str, ...]
    signals: SegmentSignals
    reference_rad: FloatArray
    counts: BoolArray


class TrainingPart:
    """The part of a fold that may be used to choose parameters.

    Parameters
    ----------
    fold : Fold
        Its training and validation parts; the test part is not touched.
    prepare : callable
        Loads and calibrates a trial.
    skip_s : float
        Start of each trial that does not count, s.
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
        """Measure a method.

        Parameters
        ----------
        method : OrientationMethod
            With the parameters to be judged.
        axis_weights : sequence of float
            Of the squared errors, as in the network's objective.
        offset_free : bool
            Subtract the mean error of each stretch first, as in the network's objective.

        Returns
        -------
        float
            Root mean square error of the weighted axes, mean over trials, rad; infinite where
            the method does not fit a trial.
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
    """Take the point of a grid with the smallest error on the training part.

    Leaving training trials out one by one, as for the network's candidates, comes down to this:
    what has no weights has the same error on a trial whether it is left out or not.

    Parameters
    ----------
    settings : mapping
        Of the method, with ``_target_``.
    grid : mapping of str to sequence
        Values by parameter.
    training : TrainingPart
        Judges.
    axis_weights : sequence of float
        Of the squared errors.
    offset_free : bool
        Whether the mean error does not count.

    Returns
    -------
    dict
        The chosen value of every parameter of the grid, of equals the first; empty where no
        point can be judged.
    """
    points = [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]
    errors = [
        training.error_rad(
            instantiate(dict(settings) | point, _convert_="all"),
            axis_weights,
            offset_free,
        )
        for point in points
    ]
    best = int(np.argmin(errors))
    return points[best] if np.isfinite(errors[best]) else {}
