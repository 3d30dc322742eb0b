"""The report of any source: comparison of all methods, with intervals and tests."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from omegaconf import DictConfig

from narx.calibration.calibrate import CalibratedSegment
from narx.evaluation.comparison import Evaluated
from narx.evaluation.trial import Refusal
from narx.experiments.figures.bland_altman import bland_altman
from narx.experiments.figures.calibration import calibration_figure
from narx.experiments.figures.drift import error_over_time
from narx.experiments.figures.spectrum import spectrum
from narx.experiments.figures.waveforms import first_and_last_minute, waveforms
from narx.experiments.gathered import Gathered
from narx.experiments.method_labels import drawn_rows
from narx.experiments.reports.report import Report, Section
from narx.experiments.reports.strides import Strides
from narx.experiments.reports.tham_wording import differences_from_paper
from narx.experiments.tables.chosen import chosen_table
from narx.experiments.tables.comparison import comparison_table
from narx.experiments.tables.drift import drift_table
from narx.experiments.tables.quality import coverage_table
from narx.experiments.tables.table import Table
from narx.experiments.tables.tham import comparison_with_published, interval_table, tham_tables
from narx.kinematics.segment_angles import SAGITTAL
from narx.method import OrientationMethod
from narx.recordings.trial import Trial, kind_of
from narx.types import FloatArray
from narx.windows.sequences import contiguous


def walking_gyroscope(
    trial: Trial, calibrated: Mapping[str, CalibratedSegment], skip_s: float
) -> tuple[str, FloatArray, float] | None:
    """Find a walking signal for a spectrum.

    Parameters
    ----------
    trial : Trial
        The trial.
    calibrated : mapping of str to CalibratedSegment
        Its segments.
    skip_s : float
        Start of the trial that is left out, s.

    Returns
    -------
    tuple of (str, ndarray of shape (N,), float), or None
        Names, sagittal rate in rad/s and sampling rate in Hz of the longest stretch of a shank
        (or thigh) without gaps; None if there is neither.
    """
    for kind in ("shank", "thigh"):
        for name, segment in calibrated.items():
            if name.startswith(kind):
                signals = segment.signals
                keep = np.arange(signals.n_samples) >= skip_s * signals.sampling_rate_hz
                pieces = contiguous(name, signals, signals.axis_rates_rad_s, keep)
                if pieces:
                    rates = max(pieces, key=lambda p: p.duration_s).signals.axis_rates_rad_s
                    title = f"{trial.name}, {name}".replace("_", " ")
                    return title, rates[:, SAGITTAL], signals.sampling_rate_hz
    return None


class GenericReport(Report):
    """Precision and RMSE of every method; on simulated gait the tables of Tham et al. as well.

    Parameters
    ----------
    skip_s : float
        Start of a trial that is left out of the spectrum, s.
    """

    def __init__(self, skip_s: float = 5.0) -> None:
        self.skip_s = skip_s
        self._gyroscope: tuple[str, FloatArray, float] | None = None
        self._strides = Strides()

    def observe(
        self,
        trial: Trial,
        calibrated: Mapping[str, CalibratedSegment],
        methods: Mapping[str, OrientationMethod],
        evaluated: Sequence[Evaluated],
    ) -> tuple[Sequence[Evaluated], Sequence[Refusal]]:
        """Keep the first walking gyroscope for its spectrum, and all strides; everything is scored.

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
            The same.
        refusals : sequence of Refusal
            None.
        """
        if self._gyroscope is None:
            self._gyroscope = walking_gyroscope(trial, calibrated, self.skip_s)
        self._strides.observe(trial, calibrated, evaluated)
        return evaluated, ()

    def sections(self, cfg: DictConfig, gathered: Gathered) -> list[Section]:
        """Write the tables.

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
        sections: list[Section] = [
            f"Scored from {cfg.evaluation.skip_s:g} s after the start of each trial on; "
            "error = reference - estimate; precision is the SD of the error."
        ]
        knees = results["segment"].str.startswith("knee").any()
        if knees and set(results["dataset"]) == {"simulated_gait"}:
            sections += tham_tables(results, cfg.evaluation.skip_s, not_causal=gathered.not_causal)
            if "narx" in cfg.methods:
                sections.append(interval_table(results, seed=cfg.seed))
                sections += differences_from_paper(comparison_with_published(results), cfg, True)
        return sections + comparison_sections(cfg, gathered) + self._strides.tables()

    def figures(self, cfg: DictConfig, gathered: Gathered) -> dict[str, Figure]:
        """Draw spectrum, waveforms, agreement and error over time.

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
        figures: dict[str, Figure] = {}
        if self._gyroscope is not None:
            title, rate_rad_s, rate_hz = self._gyroscope
            figures["spectrum"] = spectrum(rate_rad_s, rate_hz, title=title)
        by_kind: dict[str, list[Evaluated]] = {}
        for one in gathered.evaluated:
            if np.isfinite(one.reference_rad).any():
                kind = kind_of(one.segment)
                by_kind.setdefault(kind, []).append(one)
        for kind, pieces in by_kind.items():
            rows = drawn_rows(row for piece in pieces for row in piece.estimates_rad)
            shown = next((piece for piece in pieces if piece.condition == "normal"), pieces[0])
            figures[f"waveforms_{kind}"] = waveforms(
                first_and_last_minute(shown), rows, title=shown.name.replace("/", ", ")
            )
            for row in rows:
                figures[f"bland_altman_{kind}_{row}"] = bland_altman(pieces, row)
            figures[f"error_over_time_{kind}"] = error_over_time(
                pieces, methods=rows, title=f"{kind}: mean over trials, each trial thin"
            )
            if any(piece.std_rad for piece in pieces):
                figures[f"calibration_{kind}"] = calibration_figure(
                    pieces,
                    title=f"{kind}: predicted SD (below the diagonal: too small)",
                )
        return figures | self._strides.figures()


def comparison_sections(cfg: DictConfig, gathered: Gathered) -> list[Section]:
    """Compare all methods over subjects, over time and with their predicted bands.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The benchmark's configuration.
    gathered : Gathered
        Its results.

    Returns
    -------
    list of Table
        Precision and RMSE; drift and coverage if applicable.
    """
    against = "narx" if "narx" in cfg.methods else str(cfg.methods[0])
    tables: list[Table | None] = [
        comparison_table(gathered.results, quantity, against, cfg.seed, gathered.not_causal)
        for quantity in ("precision_deg", "rmse_deg")
    ]
    tables.append(drift_table(gathered.evaluated, cfg.methods, seed=cfg.seed))
    tables.append(coverage_table(gathered.evaluated))
    tables.append(chosen_table(gathered.chosen))
    return [table for table in tables if table is not None]
