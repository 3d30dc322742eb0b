"""Extract training sequences from trials, and measure the error of a trained method on them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import inf

import numpy as np

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.calibration.calibrate import CalibratedSegment, Mode, calibrate
from narx.errors import UserError
from narx.inference.narx_method import NarxMethod
from narx.recordings.trial import Trial
from narx.settings import Positive, Seconds, check_fields
from narx.training.teachers import AutomaticTeacher, Teacher
from narx.types import BoolArray, FloatArray
from narx.windows.sequences import TrainingSequence, contiguous

Std = tuple[float, float, float]

# half-widths of the 68 and 95 % bands of a normal distribution, in standard deviations
_NORMAL_BANDS = np.array([0.9945, 1.96])


@dataclass(frozen=True)
class Stretch:
    """A trial and the part of it that may be used for training.

    Parameters
    ----------
    trial : Trial
        The whole trial.
    start_s, stop_s : float
        Start and end of that part, in s from the first sample.
    segments : mapping of str to CalibratedSegment, optional
        Segments of the trial, if it is already calibrated.
    """

    trial: Trial
    start_s: float = 0.0
    stop_s: float = inf
    segments: Mapping[str, CalibratedSegment] | None = None


def _default_teacher() -> Teacher:
    return AutomaticTeacher(ComplementaryFilter(crossover_hz=0.1))


@dataclass(frozen=True)
class TrialReader:
    """Reader of training sequences from trials.

    Parameters
    ----------
    teacher : Teacher
        Source of target angles: by default the reference if there is one, but the complementary
        filter on simulated gait, as in Tham et al.
    calibration : {"auto", "leg", "knee", "functional", "walking", "sensor"}
        As `narx.calibration.calibrate`.
    skip_s : float
        Length of the start of each trial that is left out, s.
    segments : sequence of str, optional
        Names of the segments to train on; by default all.
    weights : mapping of str to float
        Factor on the squared errors of each dataset; 1 by default.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    teacher: Teacher = field(default_factory=_default_teacher)
    calibration: Mode = "auto"
    skip_s: Seconds = 5.0
    segments: tuple[str, ...] | None = None
    weights: Mapping[str, Positive] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_fields(self, "training")

    def sequences(self, stretches: Iterable[Stretch]) -> list[TrainingSequence]:
        """Cut trials into sequences without gaps.

        Parameters
        ----------
        stretches : iterable of Stretch
            Read one at a time, so that trials need not be in memory together.

        Returns
        -------
        list of TrainingSequence
            Sequences by trial, then segment, then time.

        Raises
        ------
        UserError
            If a part lies outside its trial, no trial has a requested segment, or there is no
            sequence without gaps.
        """
        found: list[TrainingSequence] = []
        names: list[str] = []
        present: set[str] = set()
        for stretch in stretches:
            trial = stretch.trial
            names.append(trial.name)
            keep = self._inside(stretch)
            weight = float(self.weights.get(trial.dataset, 1.0))
            for name, segment in self._calibrated(stretch).items():
                present.add(name)
                if self.segments is not None and name not in self.segments:
                    continue
                target = self.teacher.angles_rad(trial.dataset, segment)
                found += contiguous(f"{trial.name}/{name}", segment.signals, target, keep, weight)
        unknown = sorted(set(self.segments or ()) - present)
        if unknown and names:
            raise UserError(
                f"training.segments holds '{unknown[0]}', which none of the trials has; they have "
                f"{', '.join(sorted(present))}"
            )
        if not found and names:
            raise UserError(f"training: no stretch of 2 s without gaps in {', '.join(names)}")
        return found

    def _calibrated(self, stretch: Stretch) -> Mapping[str, CalibratedSegment]:
        if stretch.segments is None:
            return calibrate(stretch.trial, self.calibration)
        return stretch.segments

    def _inside(self, stretch: Stretch) -> BoolArray:
        since_start_s = stretch.trial.time_s - stretch.trial.time_s[0]
        start_s = max(self.skip_s, stretch.start_s)
        inside: BoolArray = np.asarray(
            (since_start_s >= start_s) & (since_start_s < stretch.stop_s)
        )
        if not inside.any():
            raise UserError(
                f"training: {stretch.trial.name} lasts {since_start_s[-1]:.1f} s, no part of it "
                f"lies between {start_s:g} s and {stretch.stop_s:g} s"
            )
        return inside

    def error_stds(
        self, method: NarxMethod, stretches: Iterable[Stretch]
    ) -> tuple[Std, Std] | tuple[None, None]:
        """Measure the error of a trained network on whole trials with a reference.

        Parameters
        ----------
        method : NarxMethod
            The network with its start-up and washout.
        stretches : iterable of Stretch
            Training trials; the whole of each is used.

        Returns
        -------
        after, start : tuple of three floats, or None
            Root mean square error of each axis after the start-up and during it, rad: used as the
            standard deviation of an estimate. None without a reference.
        """
        total, count = np.zeros((2, 3)), np.zeros((2, 3))
        for stretch in stretches:
            time_s = stretch.trial.time_s
            keep = time_s - time_s[0] >= self.skip_s
            for segment in self._calibrated(stretch).values():
                if segment.reference_angles_rad is None:
                    continue
                found = method.run(segment.signals)
                error = segment.reference_angles_rad - found.angles_rad
                for row, when in enumerate((keep & found.starting, keep & ~found.starting)):
                    total[row] += np.nansum(error[when] ** 2, axis=0)
                    count[row] += np.isfinite(error[when]).sum(axis=0)
        if not count.any():
            return None, None
        start, after = np.sqrt(
            np.divide(total, count, out=np.full((2, 3), np.nan), where=count > 0)
        )
        return _as_std(np.where(np.isfinite(after), after, start)), _as_std(start)

    def std_scale(self, method: NarxMethod, stretches: Iterable[Stretch]) -> Std:
        """Compute the factor by which a tracker's standard deviations are too small.

        Parameters
        ----------
        method : NarxMethod
            The network with its tracker.
        stretches : iterable of Stretch
            Training trials; the whole of each is used.

        Returns
        -------
        tuple of three floats
            Factor for each axis with which 68 and 95 % of the errors lie within their bands (mean
            of both). An axis without a reference gets the mean of the others; 1 without any
            reference.
        """
        ratios: list[FloatArray] = []
        for stretch in stretches:
            time_s = stretch.trial.time_s
            keep = time_s - time_s[0] >= self.skip_s
            for segment in self._calibrated(stretch).values():
                if segment.reference_angles_rad is None:
                    continue
                found = method.run(segment.signals)
                if found.std_rad is not None:
                    error = segment.reference_angles_rad - found.angles_rad
                    ratios.append(np.abs(error / found.std_rad)[keep])
        if not ratios:
            return 1.0, 1.0, 1.0
        joined = np.concatenate(ratios)
        scales = [
            np.mean(np.quantile(axis[np.isfinite(axis)], [0.68, 0.95]) / _NORMAL_BANDS)
            if np.isfinite(axis).any()
            else np.nan
            for axis in joined.T
        ]
        known = np.nanmean(scales) if np.isfinite(scales).any() else 1.0
        return _as_std(np.where(np.isfinite(scales), scales, known))


def _as_std(values_rad: FloatArray) -> Std:
    sagittal, frontal, transverse = map(float, values_rad)
    return sagittal, frontal, transverse
