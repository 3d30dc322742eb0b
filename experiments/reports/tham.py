"""Tham et al.: three knee angles by NARX, at three speeds, over minutes of walking."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.calibration.calibrate import CalibratedSegment
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.figures.bland_altman import bland_altman
from narx.experiments.figures.drift import error_over_time
from narx.experiments.figures.spectrum import spectrum
from narx.experiments.figures.waveforms import first_and_last_minute, waveforms
from narx.experiments.gait_cycles import gait_cycles
from narx.experiments.gathered import Gathered
from narx.experiments.published import published
from narx.experiments.reports import tham_wording
from narx.experiments.reports.generic import comparison_sections, walking_gyroscope
from narx.experiments.reports.report import Report, Section
from narx.experiments.reports.strides import Strides
from narx.experiments.tables.subjects import condition_order
from narx.experiments.tables.table import Table
from narx.experiments.tables.tham import comparison_with_published, interval_table, tham_tables
from narx.gait.spectrum import hidden_neurons
from narx.method import OrientationMethod
from narx.recordings.trial import Trial, side_of
from narx.simulation.body import body_of


class ThamReport(Report):
    """Tables 1 to 4, intervals and gait cycles; Fig. 3, 6 and 7.

    Parameters
    ----------
    skip_s : float
        Start of a trial that is left out of the spectrum of Fig. 3, s.
    """

    expects = "a knee: thigh and shank of one leg, with a reference"

    def __init__(self, skip_s: float = 5.0) -> None:
        self.skip_s = skip_s
        self._gyroscopes: dict[str, tuple[str, np.ndarray, float]] = {}
        self._cycles: Counter[tuple[str, str]] = Counter()
        self._strides = Strides()

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Count the gait cycles of every knee; a trial without a knee is left out.

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
            The same, if there is a knee.
        refusals : sequence of Refusal
            The reason, if there is none.
        """
        knees = [one for one in evaluated if one.segment.startswith("knee")]
        if not knees:
            found = ", ".join(calibrated)
            return (), [Refusal(trial.name, found, "knee angle", f"no knee among {found}")]
        for knee in knees:
            thigh = calibrated[knee.segment.replace("knee", "thigh")].signals
            cycles = gait_cycles(trial, knee, thigh)
            self._cycles[trial.condition, "compared"] += cycles.compared
            self._cycles[trial.condition, "complete"] += cycles.complete
            if side_of(knee.segment) == "right":
                self._cycles[trial.condition, "right"] += cycles.compared
        if trial.condition not in self._gyroscopes:
            gyroscope = walking_gyroscope(trial, calibrated, self.skip_s)
            if gyroscope is not None:
                self._gyroscopes[trial.condition] = gyroscope
        self._strides.observe(trial, calibrated, knees)
        return evaluated, ()

    @property
    def _gyroscope(self) -> tuple[str, np.ndarray, float] | None:
        """Gyroscope of a walk at normal speed, if there is one."""
        any_speed = next(iter(self._gyroscopes.values()), None)
        return self._gyroscopes.get("normal", any_speed)

    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write Tables 1 to 4, intervals, cycles and the differences from the paper.

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
        results = gathered.results
        skip_s = float(cfg.evaluation.skip_s)
        simulated = set(results["dataset"]) == {"simulated_gait"}
        sections: list[Section] = [
            f"Scored from {skip_s:g} s after the start of each trial on, without samples whose "
            "markers were hidden; error = reference - estimate.",
            *tham_tables(results, skip_s, _subjects(cfg, results), gathered.not_causal),
        ]
        if "narx" in set(results["method"]):
            sections.append(interval_table(results, seed=cfg.seed))
        sections.append(self._cycle_table())
        if self._gyroscope is not None:
            title, rate_rad_s, rate_hz = self._gyroscope
            sections.append(
                tham_wording.about_components(hidden_neurons(rate_rad_s, rate_hz), title)
            )
        sections += tham_wording.differences_from_paper(
            comparison_with_published(results), cfg, simulated
        )
        return sections + comparison_sections(cfg, gathered) + self._strides.tables()

    def _cycle_table(self) -> Table:
        text = published("tham_text").set_index("quantity")["value"].astype(float)
        conditions = condition_order({condition for condition, _ in self._cycles})
        rows = [
            {
                "Speed": condition.capitalize(),
                "cycles compared": self._cycles[condition, "compared"],
                "of the right leg": self._cycles[condition, "right"],
                "without a hidden marker": self._cycles[condition, "complete"],
                "paper": text.get(f"cycles_{condition}"),
            }
            for condition in conditions
        ]
        frame = pd.DataFrame(rows).set_index("Speed")
        frame.loc["Total"] = frame.sum(min_count=1)
        frame.loc["Total", "paper"] = text["cycles_total"]
        return Table(
            "Gait cycles compared",
            frame.astype("Int64"),
            note="From one heel strike to the next of the same foot, both legs; the paper does not "
            "state whether its count is for one leg or both.",
        )

    def figures(self, cfg: DictConfig, gathered: Gathered) -> dict[str, Figure]:
        """Draw Fig. 3, 6 and 7, and the error over time.

        Parameters
        ----------
        cfg : omegaconf.DictConfig
            The benchmark's configuration.
        gathered : Gathered
            Its results.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            By file name without suffix; Fig. 7 of every compared method.
        """
        figures: dict[str, Figure] = {}
        if self._gyroscope is not None:
            title, rate_rad_s, rate_hz = self._gyroscope
            figures["figure_3_spectrum"] = spectrum(rate_rad_s, rate_hz, title=title)
        knees = [one for one in gathered.evaluated if one.segment.startswith("knee")]
        shown = next((one for one in knees if one.condition == "normal"), knees[0])
        figures["figure_6_knee_angle"] = waveforms(
            first_and_last_minute(shown), title=shown.name.replace("/", ", ")
        )
        for method in cfg.methods:
            if any(method in one.estimates_rad for one in knees):
                figures[f"figure_7_bland_altman_{method}"] = bland_altman(knees, method)
        figures["error_over_time"] = error_over_time(knees)
        return figures | self._strides.figures()


def _subjects(cfg: DictConfig, results: pd.DataFrame) -> list[dict[str, object]]:
    """Subjects: bodies of virtual walkers; sex and age of those modelled on the paper."""
    printed = published("tham_table_1").set_index("subject")
    people = []
    for subject in results["subject"].unique():
        person: dict[str, object] = {"subject": subject}
        if set(results["dataset"]) == {"simulated_gait"}:
            body = body_of(subject, int(cfg.data.simulated_gait.seed))
            person |= {"height_m": body.height_m, "mass_kg": body.mass_kg}
            if subject in printed.index:
                person |= printed.loc[subject, ["gender", "age_years"]].to_dict()
        people.append(person)
    return people
