"""Abhayasinghe, Murray and Sharif Bidabadi: thigh angle by GIOF, swing by swing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.calibration.calibrate import CalibratedSegment
from narx.errors import UserError
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.figures.histograms import peak_histograms, trial_histograms
from narx.experiments.figures.phases import phases as phases_figure
from narx.experiments.figures.swing import swing_figure
from narx.experiments.figures.waveforms import waveforms
from narx.experiments.gathered import Gathered
from narx.experiments.peak_errors import Swing, swing, swing_results
from narx.experiments.phase_timing import event_errors, phase_shares
from narx.experiments.reports import abhayasinghe_wording
from narx.experiments.reports.operations import operations_per_angle
from narx.experiments.reports.report import Report, Section
from narx.experiments.tables.abhayasinghe import (
    correlation_table,
    method_table,
    operations_table,
    phase_tables,
)
from narx.gait.phases import GaitPhases, gait_phases, smooth_rate_and_derivative
from narx.kinematics.segment_angles import SAGITTAL
from narx.method import OrientationMethod
from narx.recordings.trial import Trial, kind_of, side_of
from narx.types import BoolArray, FloatArray

# length of the example, so that a stride fills the figure
_STRIDES_SHOWN = 2.0


@dataclass(frozen=True)
class _Example:
    """The walk shown in the figures."""

    swing: Swing
    evaluated: Evaluated
    rate_rad_s: FloatArray
    phases: GaitPhases
    events_s: Mapping[str, FloatArray]


class AbhayasingheReport(Report):
    """Tables 1 to 3, peaks, phases and cost; Fig. 7 to 11.

    The walk itself is scored if the source marks it (up to the turn, if there is one), else
    everything after a settling time; within it, from the first to the last minimum of the
    reference, as in the paper.

    Parameters
    ----------
    groups : mapping of str to sequence of str, optional
        Subjects of each row of Table 1.
    settling_s : float
        Start that is not scored if a recording does not begin in the calibration posture, s.
    method : str
        Method to compare with the paper.
    """

    expects = "a thigh that walks, with a reference angle"

    def __init__(
        self,
        groups: Mapping[str, Sequence[str]] | None = None,
        settling_s: float = 5.0,
        method: str = "giof",
    ) -> None:
        self.settling_s = settling_s
        self.method = method
        self._groups = {one: group for group, all_ in (groups or {}).items() for one in all_}
        self._trials: list[pd.DataFrame] = []
        self._peaks: list[pd.DataFrame] = []
        self._shares: list[pd.DataFrame] = []
        self._timing: list[pd.DataFrame] = []
        self._operations: dict[str, dict[str, float]] = {}
        self._example: _Example | None = None
        self._turned: list[str] = []
        self._mean_deg: list[float] = []

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Compare the swings of every thigh, and find its gait phases.

        Parameters
        ----------
        trial : Trial
            The trial.
        calibrated : mapping of str to CalibratedSegment
            Its segments.
        methods : mapping of str to OrientationMethod
            Methods that were run, by name.
        evaluated : sequence of Evaluated
            Angles of segments and joints.

        Returns
        -------
        evaluated : sequence of Evaluated
            Thighs, scored over the walk.
        refusals : sequence of Refusal
            Thighs without a walk.
        """
        kept: list[Evaluated] = []
        refusals: list[Refusal] = []
        for one in evaluated:
            if kind_of(one.segment) != "thigh":
                continue
            one = replace(one, scored=one.scored & self._walk(trial, one))
            trials, peaks, refused = swing_results([one], self._groups)
            refusals += [Refusal(trial.name, one.segment, "swing", line) for line in refused]
            if trials.empty:
                continue
            kept.append(one)
            self._mean_deg.append(
                float(np.rad2deg(np.nanmean(one.reference_rad[one.scored, SAGITTAL])))
            )
            self._trials.append(trials)
            self._peaks.append(peaks)
            try:
                self._find_phases(trial, calibrated[one.segment], one)
            except UserError as error:
                refusals.append(Refusal(trial.name, one.segment, "gait phases", str(error)))
        return kept, refusals

    def _walk(self, trial: Trial, one: Evaluated) -> BoolArray:
        if trial.walking_s is None:
            settling_s = 0.0 if trial.starts_in_calibration_posture else self.settling_s
            return np.asarray(one.time_s >= settling_s)
        begin_s, end_s = (moment - float(trial.time_s[0]) for moment in trial.walking_s)
        if not trial.straight and trial.name not in self._turned:
            self._turned.append(trial.name)
        return np.asarray((one.time_s >= begin_s) & (one.time_s <= end_s))

    def _find_phases(
        self,
        trial: Trial,
        segment: CalibratedSegment,
        one: Evaluated,
    ) -> None:
        rate = segment.signals.axis_rates_rad_s[:, SAGITTAL]
        found = gait_phases(rate, trial.sampling_rate_hz)
        self._shares.append(phase_shares(found))
        side = side_of(one.segment)
        if side is not None and trial.events:
            start_s = float(trial.time_s[0])
            self._timing.append(event_errors(found, trial.events, side, start_s))
        if self._example is None and self.method in one.estimates_rad and found.n_strides:
            events_s = {
                name: np.asarray(times) - float(trial.time_s[0])
                for name, times in trial.events.items()
                if side is not None and name.endswith(side)
            }
            self._example = _Example(swing(one, self.method), one, rate, found, events_s)
            self._operations = operations_per_angle(segment.signals.select(one.scored))

    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write the tables and the differences from the paper.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        list of str or Table
            Paragraphs and tables.
        """
        trials, peaks = pd.concat(self._trials), pd.concat(self._peaks)
        shares = pd.concat(self._shares) if self._shares else None
        timing = pd.concat(self._timing) if self._timing else None
        sections: list[Section] = [self._how_scored()]
        if self.method in set(trials["method"]):
            sections.append(correlation_table(trials, self.method))
        sections.append(method_table(trials, peaks))
        if self._operations:
            sections.append(operations_table(self._operations))
        sections += phase_tables(shares, timing)
        simulated = set(gathered.results["dataset"]) == {"simulated_gait"}
        return sections + abhayasinghe_wording.differences_from_paper(
            trials, peaks, self.method, float(np.mean(self._mean_deg)), simulated
        )

    def _how_scored(self) -> str:
        text = (
            "Sagittal angle of the thigh, forward positive; error = reference - estimate. "
            "`results.csv` is scored over the walk, the tables below from the first to the last "
            "minimum in it."
        )
        if self._turned:
            text += f" Scored until the walk turns: {', '.join(self._turned)}."
        return text

    def figures(self, cfg: DictConfig, gathered: Gathered) -> dict[str, Figure]:
        """Draw Fig. 7 to 11.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            By file name without suffix.
        """
        trials, peaks = pd.concat(self._trials), pd.concat(self._peaks)
        beside = [m for m in (self.method, "complementary_filter") if m in set(trials["method"])]
        figures = {
            "figure_8_peak_errors": peak_histograms(peaks, beside),
            "figure_9_correlation_and_rmse": trial_histograms(trials, beside),
        }
        if self._example is not None:
            shown = self._example
            title = shown.evaluated.name.replace("/", ", ")
            causal = [m for m in shown.evaluated.estimates_rad if m.endswith("_real_time")]
            walk = shown.evaluated.between(
                float(shown.swing.time_s[0]) - 2.0, float(shown.swing.time_s[-1]) + 2.0
            )
            figures["figure_7_thigh_angle"] = swing_figure(shown.swing, self.method)
            figures["figure_10_real_time"] = waveforms(
                [("", walk)], causal or None, axes=[SAGITTAL], title=title
            )
            figures["figure_11_phases"] = self._phases_figure(shown)
        return figures

    def _phases_figure(self, shown: _Example) -> Figure:
        time_s = shown.evaluated.time_s
        valid = np.isfinite(shown.rate_rad_s)
        rate = np.interp(time_s, time_s[valid], shown.rate_rad_s[valid])
        smooth, _ = smooth_rate_and_derivative(rate, shown.evaluated.sampling_rate_hz)
        # the first stride in which every point was found
        whole = np.isfinite(list(shown.phases.times_s.values())).all(axis=0)
        first = int(np.argmax(whole))
        stride_s = float(np.nanmedian(shown.phases.times_s["g"] - shown.phases.times_s["b"]))
        begin_s = float(shown.phases.times_s["a"][first]) - 0.15 * stride_s
        part = (time_s >= begin_s) & (time_s <= begin_s + _STRIDES_SHOWN * stride_s)
        angle = shown.evaluated.estimates_rad[self.method][part, SAGITTAL]
        return phases_figure(
            time_s[part], angle, smooth[part], shown.phases.times_s, shown.events_s
        )
