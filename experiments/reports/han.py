"""Han, Wong and Murray: 2-point error estimation compared with plain integration."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.baselines.two_point import TwoPoint
from narx.calibration.calibrate import CalibratedSegment
from narx.errors import MethodNotApplicableError
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.figures.drift import linear_drift
from narx.experiments.figures.waveforms import waveforms
from narx.experiments.gathered import Gathered
from narx.experiments.method_labels import method_label
from narx.experiments.reports.operations import operations_per_angle
from narx.experiments.reports.report import Report, Section
from narx.experiments.tables.abhayasinghe import operations_table
from narx.experiments.tables.han import SEGMENTS, comparison_with_published, han_tables
from narx.method import OrientationMethod
from narx.recordings.trial import Trial, kind_of

# Fig. 6 and 8 show a normal walk, Fig. 7 an abnormal one
_FIGURES = {"normal": "figure_6", "abnormal": "figure_7"}


@dataclass(frozen=True)
class _Walk:
    """Segments of one leg in one trial, from the first movement to the last."""

    segments: list[tuple[str, Evaluated]]
    start_s: float
    stop_s: float

    @property
    def title(self) -> str:
        return self.segments[0][1].name.rpartition("/")[0].replace("/", ", ")


class HanReport(Report):
    """Tables I and II, Fig. 6 to 8, scored from start A to stop B of walking.

    A and B are found by the 2-point method on each segment. A walk with a turn is scored up to the
    turn; the drift line still extends to B, where the walker stands again.
    """

    expects = "a thigh or shank that stands still before and after its walk"

    def __init__(self) -> None:
        self._shown: dict[str, _Walk] = {}
        self._operations: Mapping[str, Mapping[str, float]] = {}
        self._turned: list[str] = []
        self._bias_deg_s: list[float] = []
        self._walk_s: list[float] = []
        self._until_walk_s: list[float] = []

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Find A and B on every thigh and shank; the part between them is scored.

        Parameters
        ----------
        trial : Trial
            The trial.
        calibrated : mapping of str to CalibratedSegment
            Its segments.
        methods : mapping of str to OrientationMethod
            Methods that were run; A and B come from ``two_point`` among them, else from one with
            defaults.
        evaluated : sequence of Evaluated
            Angles of segments and joints.

        Returns
        -------
        evaluated : sequence of Evaluated
            Thighs and shanks with a walk between two standing parts, scored over the walk.
        refusals : sequence of Refusal
            The others.
        """
        ran = methods.get("two_point")
        finder = ran if isinstance(ran, TwoPoint) else TwoPoint(shaky_legs=True)
        scored, refusals = [], []
        ends: dict[str, tuple[float, float]] = {}
        for one in evaluated:
            if kind_of(one.segment) not in SEGMENTS:
                continue
            segment = calibrated[one.segment]
            try:
                start_s, stop_s = _start_and_stop_s(finder, segment)
            except MethodNotApplicableError as error:
                if finder is not ran:
                    refusals.append(Refusal(trial.name, one.segment, finder.name, str(error)))
                continue
            ends[one.segment] = start_s, stop_s
            until_s = self._turn_s(trial, stop_s)
            inside = (one.time_s >= start_s) & (one.time_s <= until_s)
            scored.append(replace(one, scored=one.scored & inside))
            self._bias_deg_s.append(float(np.rad2deg(np.abs(segment.static_bias_rad_s)).mean()))
            self._walk_s.append(until_s - start_s)
            self._until_walk_s.append(start_s)
        self._keep_for_figures(trial, scored, ends)
        if scored and not self._operations:
            signals = calibrated[scored[0].segment].signals.select(scored[0].scored)
            self._operations = operations_per_angle(signals)
        return scored, refusals

    def _turn_s(self, trial: Trial, stop_s: float) -> float:
        """End of the scored part: B, or the turn if there is one."""
        if trial.straight or trial.walking_s is None:
            return stop_s
        turn_s = trial.walking_s[1] - float(trial.time_s[0])
        if turn_s >= stop_s:
            return stop_s
        note = f"{trial.name} turns {turn_s:.1f} s after its start"
        if note not in self._turned:
            self._turned.append(note)
        return turn_s

    def _keep_for_figures(
        self, trial: Trial, scored: Sequence[Evaluated], ends: Mapping[str, tuple[float, float]]
    ) -> None:
        for side in ("right", "left"):
            leg = [one for one in scored if one.segment in (f"thigh_{side}", f"shank_{side}")]
            if len(leg) == 2 and trial.condition not in self._shown:
                starts, stops = zip(*(ends[one.segment] for one in leg), strict=True)
                self._shown[trial.condition] = _Walk(
                    [(one.segment.replace("_", " "), one) for one in leg], min(starts), max(stops)
                )

    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write Tables I and II and the differences from the paper.

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
        simulated = set(gathered.results["dataset"]) == {"simulated_gait"}
        return [
            self._how_scored(cfg),
            *han_tables(gathered.results),
            operations_table(self._operations),
            *self._differences_from_paper(cfg, gathered, simulated),
        ]

    def _how_scored(self, cfg: DictConfig) -> str:
        bias = "removed first" if cfg.remove_static_bias else "not removed, as in the paper"
        text = (
            f"Scored from start A to stop B of walking, {np.mean(self._walk_s):.1f} s on average; "
            f"error = reference - estimate. The gyroscope's static bias is {bias}."
        )
        if self._turned:
            text += (
                " A walk with a turn is scored up to the turn, without its transverse axis: the "
                "method assumes the same heading at A and B. The drift line extends to B, so that "
                "the results of the other two axes include the effect of the turn: "
                f"{'; '.join(self._turned)}."
            )
        return text

    def _differences_from_paper(
        self, cfg: DictConfig, gathered: Gathered, simulated: bool
    ) -> list[Section]:
        found = comparison_with_published(gathered.results)
        sentences = []
        both = found.dropna(subset=["two_point", "gyro_integration"])
        if len(both):
            better = both[both["two_point"] < both["gyro_integration"]]
            factor = both["gyro_integration"] / both["two_point"]
            sentences.append(
                f"2-point has a lower RMSE than plain integration in {len(better)} of {len(both)} "
                f"columns, by a factor of {factor.min():.1f} to {factor.max():.1f}."
            )
        for method in ("two_point", "gyro_integration"):
            pairs = found.dropna(subset=[method])
            if len(pairs):
                ratio = pairs[method] / pairs[f"paper {method}"]
                lowest, highest = ratio.idxmin(), ratio.idxmax()
                sentences.append(
                    f"{method_label(method)}'s overall RMSE is {ratio.min():.2f} "
                    f"({_column(lowest)}) to {ratio.max():.2f} ({_column(highest)}) times the "
                    "printed."
                )
        paragraphs: list[Section] = [
            "**Where and why these results differ from the paper.** " + " ".join(sentences)
        ]
        if "gyro_integration" in found and not cfg.remove_static_bias:
            paragraphs.append(
                "Plain integration depends on the bias of the sensor: that of these gyroscopes is "
                f"{np.mean(self._bias_deg_s):.1f} °/s on average, which over the "
                f"{np.mean(self._until_walk_s):.1f} s before the walk alone gives "
                f"{np.mean(np.multiply(self._bias_deg_s, self._until_walk_s)):.0f}° per axis; the "
                "paper does not give the bias of its two sensors. With `remove_static_bias=true` "
                "both methods start from a gyroscope without it."
            )
        if simulated:
            paragraphs.append(_ABOUT_SIMULATION)
        return paragraphs

    def figures(self, cfg: DictConfig, gathered: Gathered) -> dict[str, Figure]:
        """Draw waveforms (Fig. 6, 7) and errors with the drift line (Fig. 8).

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            By file name without suffix; of the first trial of each condition with both segments.
        """
        figures: dict[str, Figure] = {}
        for condition, walk in self._shown.items():
            name = _FIGURES.get(condition, "figure_6_and_7")
            figures[f"{name}_waveforms_{condition}"] = waveforms(
                walk.segments, marks_s=(walk.start_s, walk.stop_s), title=walk.title
            )
        drifting = self._shown.get("normal", next(iter(self._shown.values()), None))
        if drifting is not None:
            figures["figure_8_error_and_drift"] = linear_drift(
                drifting.segments, drifting.start_s, drifting.stop_s, title=drifting.title
            )
        return figures


_ABOUT_SIMULATION = (
    "The walkers are simulated (docs/simulator.md). Their reference follows the bones, through "
    "markers on the skin, and the sensors are on soft tissue elsewhere on the segment; in the "
    "paper the markers were attached to the sensors, which hides soft tissue and calibration. Both "
    "matter most where the segment turns least. Their contributions, measured by switching one off "
    "at a time, are in docs/experiments.md."
)


def _column(key: object) -> str:
    axis, segment = key if isinstance(key, tuple) else (key, "")
    return f"{axis} {segment}".strip()


def _start_and_stop_s(method: TwoPoint, segment: CalibratedSegment) -> tuple[float, float]:
    parts = method.parts(segment.signals)
    if parts.start is None or parts.stop is None:
        raise MethodNotApplicableError(
            f"{segment.signals.segment} is still throughout, expected a walk"
        )
    rate_hz = segment.signals.sampling_rate_hz
    return parts.start / rate_hz, parts.stop / rate_hz
