"""What a benchmark leaves for people: summary.md, figures, TensorBoard."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from omegaconf import DictConfig

from experiments.estimation import Refusal
from experiments.evaluated import Evaluated
from experiments.figures.bland_altman import bland_altman
from experiments.figures.calibration import calibration_figure
from experiments.figures.canvas import save_figure
from experiments.figures.drift import error_over_time
from experiments.figures.spectrum import spectrum
from experiments.figures.training import training_figure
from experiments.figures.waveforms import first_and_last_minute, waveforms
from experiments.tables.comparison import comparison_table
from experiments.tables.quality import coverage_table, drift_table
from experiments.tables.table import Table, as_markdown
from experiments.tables.tham import interval_table, tham_tables
from experiments.tensorboard_log import TensorBoardLog
from narx.checkpoint import Checkpoint
from narx.files import atomic_path

FloatArray = NDArray[np.float64]


def training_history_figure(network: Checkpoint, title: str) -> Figure:
    """Draw how the kept restart of a network was trained.

    Parameters
    ----------
    network : Checkpoint
        With a training report in its history.
    title : str
        Above the panels.

    Returns
    -------
    matplotlib.figure.Figure
        Cost, damping and gradient, whatever the optimizer recorded.
    """
    history = network.history["report"]["history"]
    names = list(history[0]) if history else []
    return training_figure(
        {name: [entry.get(name, np.nan) for entry in history] for name in names}, title=title
    )


def write_report(
    cfg: DictConfig,
    results: pd.DataFrame,
    evaluated: Sequence[Evaluated],
    refusals: Sequence[Refusal],
    networks: Mapping[str, Checkpoint],
    gyroscope: tuple[str, FloatArray, float] | None,
    directory: Path,
    log: TensorBoardLog,
) -> str:
    """Write tables and figures.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The benchmark's configuration.
    results : pandas.DataFrame
        Columns of ``results.csv``.
    evaluated : sequence of Evaluated
        Thinned out, for figures.
    refusals : sequence of Refusal
        Methods that a recording did not fit.
    networks : mapping of str to Checkpoint
        By fold.
    gyroscope : tuple of (str, ndarray of shape (N,), float), optional
        Title, sagittal rate in rad/s and sampling rate in Hz for the spectrum.
    directory : pathlib.Path
        Run directory.
    log : TensorBoardLog
        Gets figures and RMSE.

    Returns
    -------
    str
        What ``summary.md`` says.
    """
    tables: list[Table] = []
    paper = cfg.get("paper") == "tham" or (
        cfg.get("paper") is None and set(results["dataset"]) == {"simulated_gait"}
    )
    if paper:
        tables += tham_tables(results, cfg.evaluation.skip_s)
        if "narx" in cfg.methods:
            tables.append(interval_table(results, seed=cfg.seed))
    against = "narx" if "narx" in cfg.methods else str(cfg.methods[0])
    for quantity in ("precision_deg", "rmse_deg"):
        tables.append(comparison_table(results, quantity, against, cfg.seed))
    tables += [
        table
        for table in (drift_table(evaluated, cfg.methods), coverage_table(evaluated))
        if table is not None
    ]
    text = "\n\n".join(
        [
            f"# {', '.join(sorted(set(results['dataset'])))}: "
            f"{results[['subject', 'condition', 'trial']].drop_duplicates().shape[0]} trials",
            f"Scored from {cfg.evaluation.skip_s:g} s after the start of each trial on; "
            "error = reference - estimate; precision is the SD of the error.",
            *(_about_network(fold, network) for fold, network in networks.items()),
            as_markdown(tables),
            *_about_refusals(refusals),
        ]
    )
    with atomic_path(directory / "summary.md") as temporary:
        temporary.write_text(text + "\n")
    for name, figure in _figures(cfg, evaluated, networks, gyroscope).items():
        save_figure(figure, directory / "figures" / f"{name}.png")
        log.figure(name, figure)
    log.results(results)
    return text


def _about_network(fold: str, network: Checkpoint) -> str:
    history = network.history
    if "report" not in history:
        return f"Network of fold {fold}: {history.get('description', 'from a checkpoint')}."
    restarts = history["report"]["restarts"]
    return (
        f"Network of fold {fold}: trained on {history['training_s']:.0f} s of "
        f"{len(history['trained_on'])} segments; {restarts['restarts']:.0f} starts, "
        f"{restarts['dropped']:.0f} dropped, held-back error "
        f"{restarts['validation_rmse_best_deg']:.2f} deg (median of starts "
        f"{restarts['validation_rmse_median_deg']:.2f}, worst "
        f"{restarts['validation_rmse_worst_deg']:.2f})."
    )


def _about_refusals(refusals: Sequence[Refusal]) -> list[str]:
    if not refusals:
        return []
    counted = Counter((refusal.method, refusal.reason) for refusal in refusals)
    lines = [f"- {method}, {count} times: {reason}" for (method, reason), count in counted.items()]
    return ["Left out:\n\n" + "\n".join(lines)]


def _figures(
    cfg: DictConfig,
    evaluated: Sequence[Evaluated],
    networks: Mapping[str, Checkpoint],
    gyroscope: tuple[str, FloatArray, float] | None,
) -> dict[str, Figure]:
    figures: dict[str, Figure] = {}
    if gyroscope is not None:
        title, rate_rad_s, rate_hz = gyroscope
        figures["spectrum"] = spectrum(rate_rad_s, rate_hz, title=title)
    by_kind: dict[str, list[Evaluated]] = {}
    for one in evaluated:
        if np.isfinite(one.reference_rad).any():
            kind = one.segment.removesuffix("_left").removesuffix("_right")
            by_kind.setdefault(kind, []).append(one)
    for kind, pieces in by_kind.items():
        shown = next((piece for piece in pieces if piece.condition == "normal"), pieces[0])
        figures[f"waveforms_{kind}"] = waveforms(
            first_and_last_minute(shown), title=shown.name.replace("/", ", ")
        )
        for method in cfg.methods:
            if any(method in piece.estimates_rad for piece in pieces):
                figures[f"bland_altman_{kind}_{method}"] = bland_altman(pieces, method)
        figures[f"error_over_time_{kind}"] = error_over_time(pieces)
        if any(piece.std_rad for piece in pieces):
            figures[f"calibration_{kind}"] = calibration_figure(pieces)
    for fold, network in networks.items():
        if "report" in network.history:
            figures[f"training_{fold}"] = training_history_figure(network, fold)
    return figures
