"""Run every method on every trial, compare the angles with the reference, and report.

python -m experiments.benchmark data=smartphone_pocket data_root=DIR split=leave_one_subject_out
"""

import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import DictConfig
from tqdm import tqdm

from narx.calibration.calibrate import CalibratedSegment
from narx.datasets.base import TrialSource
from narx.datasets.splits import Fold, TrialPart, load_calibrated
from narx.errors import UserError
from narx.evaluation.comparison import Evaluated, rows
from narx.evaluation.results import results_table, write_results
from narx.evaluation.trial import Refusal, evaluate_trial
from narx.experiments import as_printed
from narx.experiments.command import command, run_directory, states_folder
from narx.experiments.gathered import Gathered
from narx.experiments.networks import network_of
from narx.experiments.raw_gyroscope import with_static_bias
from narx.experiments.reports.report import Report
from narx.experiments.reports.summary import write_report
from narx.experiments.rivals import NETWORK_METHODS, rivals_of
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.side_by_side import side_by_side
from narx.experiments.sources import combined_index, open_sources
from narx.experiments.tensorboard_log import TensorBoardLog
from narx.files import safe_name
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint
from narx.method import OrientationMethod
from narx.recordings.trial import Trial

_Evaluation = tuple[Trial, Mapping[str, CalibratedSegment], Sequence[Evaluated], Sequence[Refusal]]


def run(
    cfg: DictConfig,
    log: TensorBoardLog | None = None,
    report: Report | None = None,
    progress_folder: Path | None = None,
) -> Gathered:
    """Train a network for each fold that needs one, run every method, and compare.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/benchmark.yaml``.
    log : TensorBoardLog, optional
        Receives the training progress.
    report : Report, optional
        Observes every trial while it is in memory and selects the parts that are scored; by
        default the report named in the configuration.
    progress_folder : pathlib.Path, optional
        As `narx.Trainer`.

    Returns
    -------
    Gathered
        Everything that tables and figures need.

    Raises
    ------
    UserError
        If nothing in the data can be scored.
    """
    if report is None:
        report = instantiate(cfg.report, _convert_="all")
    sources = open_sources(cfg)
    index = combined_index(sources)
    # most sources have to read a trial to know: their absence of references is found at the end
    if "has_reference" in index and index["has_reference"].eq(False).all():
        raise UserError(_no_reference(sources))
    folds = list(instantiate(cfg.split, _convert_="all")(index))
    gathered = Gathered(pd.DataFrame())
    rivals = rivals_of(cfg, gathered)
    all_rows = []
    progress = tqdm(
        total=sum(len(fold.test) for fold in folds), desc="trials", unit="trial", disable=None
    )

    def prepare(part: TrialPart) -> tuple[Trial, Mapping[str, CalibratedSegment]]:
        trial, calibrated = load_calibrated(sources, part, cfg.calibration)
        if not cfg.remove_static_bias:
            calibrated = {name: with_static_bias(c) for name, c in calibrated.items()}
        return trial, calibrated

    def evaluate(part: TrialPart, methods: Mapping[str, OrientationMethod]) -> _Evaluation:
        trial, calibrated = prepare(part)
        evaluated, refusals = evaluate_trial(
            trial,
            calibrated,
            methods,
            part,
            cfg.evaluation.skip_s,
            gathered.workload,
            cfg.evaluation.scored_rate_hz,
        )
        return trial, calibrated, evaluated, refusals

    for fold in folds:
        methods: dict[str, OrientationMethod] = {}
        if NETWORK_METHODS & set(cfg.methods):
            methods = _with_network(cfg, sources, fold, log, gathered, progress_folder)
        methods |= rivals.methods_for(fold, prepare)
        gathered.not_causal |= {name for name, method in methods.items() if not method.causal}
        for trial, calibrated, evaluated, refusals in side_by_side(
            partial(evaluate, methods=methods), fold.test
        ):
            progress.set_postfix_str("/".join((trial.subject, trial.condition, trial.trial)))
            scored, further = report.observe(trial, calibrated, methods, evaluated)
            gathered.refusals += [*further, *refusals]
            for one in scored:
                all_rows += rows(one)
            # hours at 500 Hz would not fit in memory: figures get a decimated copy
            joints = [one for one in scored if one.segment.startswith(("knee", "joint"))]
            gathered.evaluated += [
                one.decimated(cfg.evaluation.figure_rate_hz) for one in joints or scored
            ]
            gathered.sources |= trial.sources
            gathered.notes += [f"{trial.name}: {note}" for note in trial.notes]
            progress.update()
    progress.close()
    if not all_rows:
        raise UserError(_nothing_to_score(sources, report, gathered))
    gathered.results = results_table(all_rows)
    if not gathered.results["n_samples"].any():
        if any(np.isfinite(one.reference_rad).any() for one in gathered.evaluated):
            raise UserError(
                f"evaluation.skip_s is {cfg.evaluation.skip_s:g}: nothing is left to score, "
                "expected less than the trials last"
            )
        raise UserError(_no_reference(sources))
    return gathered


def _no_reference(sources: Mapping[str, TrialSource]) -> str:
    return (
        f"data={','.join(sources)}: nothing to score, no trial has a reference; "
        "use narx-predict to compute angles only"
    )


def _nothing_to_score(
    sources: Mapping[str, TrialSource], report: Report, gathered: Gathered
) -> str:
    message = f"data={','.join(sources)}: nothing to score, expected {report.expects}"
    if gathered.refusals:
        first = gathered.refusals[0]
        message += f"; {len(gathered.refusals)} refused, first {first.trial}: {first.reason}"
    return message


def _with_network(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    log: TensorBoardLog | None,
    gathered: Gathered,
    progress_folder: Path | None,
) -> dict[str, OrientationMethod]:
    begun = time.perf_counter()
    methods: dict[str, OrientationMethod] = {}
    if {"narx", "narx_smoothed"} & set(cfg.methods):
        network = _trained(cfg, sources, fold, log, progress_folder)
        gathered.networks[fold.name] = network
        methods |= {
            name: network.method(smoothing=name == "narx_smoothed")
            for name in cfg.methods
            if name in ("narx", "narx_smoothed")
        }
    if "narx_axis_by_axis" in cfg.methods and fold.training:
        printed = cfg.copy()
        printed.model = cfg.model_axis_by_axis
        printed.candidates = []
        network = network_of(printed, sources, fold, _silent, progress_folder)
        methods["narx_axis_by_axis"] = network.method()
    gathered.workload.training_s += time.perf_counter() - begun
    return methods


def _trained(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    log: TensorBoardLog | None,
    progress_folder: Path | None,
) -> Checkpoint:
    if log is None:
        return network_of(cfg, sources, fold, _silent, progress_folder)
    with log.of_fold(safe_name(fold.name, 120)) as fold_log:
        return network_of(cfg, sources, fold, fold_log.iteration, progress_folder)


def _silent(iteration: int, numbers: dict[str, float]) -> None:
    """Log nothing."""


def _benchmark(cfg: DictConfig) -> None:
    """Run a benchmark and write its results, summary and figures to the run directory."""
    if cfg.get("as_printed") is not None:
        as_printed.check_overrides(HydraConfig.get().overrides.task)
        as_printed.report(cfg.as_printed)
        return
    seed_everything(cfg.seed)
    directory = run_directory()
    report = instantiate(cfg.report, _convert_="all")
    with TensorBoardLog(directory / "tensorboard") as log:
        gathered = run(cfg, log, report, states_folder(cfg))
        write_results(gathered.results, directory / "results.csv")
        about = environment(cfg.seed, gathered.sources)
        about["not_causal"] = sorted(gathered.not_causal)
        write_json(about, directory / "environment.json")
        write_json(by_fold(gathered.chosen), directory / "chosen.json")
        write_json(gathered.workload.report(), directory / "timing.json")
        for fold, network in gathered.networks.items():
            checkpoints.save(network, directory / "networks" / f"{safe_name(fold, 120)}.pt")
        summary = write_report(report, cfg, gathered, directory, log)
    print(summary)
    print(f"\nAll tables: {directory / 'summary.md'}\nresults.csv, figures and events: {directory}")


def by_fold(
    chosen: Mapping[tuple[str, str], Mapping[str, object]],
) -> dict[str, dict[str, Mapping[str, object]]]:
    """Nest chosen parameters for a file.

    Parameters
    ----------
    chosen : mapping of tuple of str to mapping
        Values by parameter, by fold and row.

    Returns
    -------
    dict of str to dict
        The same by fold, then by row.
    """
    nested: dict[str, dict[str, Mapping[str, object]]] = {}
    for (fold, row), values in chosen.items():
        nested.setdefault(fold, {})[row] = values
    return nested


main = command("benchmark")(_benchmark)

if __name__ == "__main__":
    main()
