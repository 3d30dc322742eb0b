"""The stride-by-stride part of a report, for walking trials."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from narx.calibration.calibrate import CalibratedSegment
from narx.evaluation.comparison import Evaluated
from narx.evaluation.strides import StrideSet, cut_strides, stride_table
from narx.experiments.figures.strides import stride_bands
from narx.experiments.gait_cycles import foot_contacts_s
from narx.experiments.method_labels import drawn_rows
from narx.experiments.tables.strides import cycle_table, reliability_table, stride_errors_table
from narx.experiments.tables.table import Table
from narx.recordings.trial import Trial, kind_of


class Strides:
    """Strides of all trials, of the few rows that `drawn_rows` chooses, kept trial by trial."""

    def __init__(self) -> None:
        self._sets: list[StrideSet] = []

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        evaluated: Sequence[Evaluated],
    ) -> None:
        """Cut the strides of a trial's knees, or of its thighs if it has no knee.

        Parameters
        ----------
        trial : Trial
            The trial.
        calibrated : mapping of str to CalibratedSegment
            Its segments.
        evaluated : sequence of Evaluated
            Angles of segments and joints at the full rate.
        """
        kinds = [kind_of(one.segment) for one in evaluated]
        kind = "knee" if "knee" in kinds else "thigh"
        for one in evaluated:
            shown = drawn_rows(one.estimates_rad)
            one = replace(one, estimates_rad={row: one.estimates_rad[row] for row in shown})
            thigh = calibrated.get(one.segment.replace("knee", "thigh"))
            if kind_of(one.segment) != kind or thigh is None:
                continue
            strides = cut_strides(one, foot_contacts_s(trial, one.segment, thigh.signals))
            if len(strides.reference_deg):
                self._sets.append(strides)

    def tables(self) -> list[Table]:
        """Summarise all strides.

        Returns
        -------
        list of Table
            Errors per stride, reliability, tests over the cycle; empty without walking.
        """
        tables: list[Table | None] = []
        for kind, sets in self._by_kind().items():
            strides = stride_table(sets)
            if not len(strides):
                continue
            title = kind.capitalize()
            tables.append(stride_errors_table(strides, title))
            tables.append(reliability_table(strides, title))
            tables.append(cycle_table(sets, self._rows(sets), title))
        return [table for table in tables if table is not None]

    def figures(self) -> dict[str, Figure]:
        """Draw mean and standard deviation over the cycle.

        Returns
        -------
        dict of str to matplotlib.figure.Figure
            By file name without suffix.
        """
        return {
            f"strides_{kind}": stride_bands(
                sets,
                self._rows(sets),
                f"{kind}: mean (line) and SD (band) of all strides",
            )
            for kind, sets in self._by_kind().items()
        }

    @staticmethod
    def _rows(sets: Sequence[StrideSet]) -> list[str]:
        return drawn_rows(row for one in sets for row in one.estimates_deg)

    def _by_kind(self) -> dict[str, list[StrideSet]]:
        by_kind: dict[str, list[StrideSet]] = {}
        for one in self._sets:
            by_kind.setdefault(kind_of(one.segment), []).append(one)
        return by_kind
