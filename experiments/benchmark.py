"""Run every method on every trial, compare with the reference, and report.

python -m experiments.benchmark data=smartphone_pocket data_root=DIR split=leave_one_subject_out
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from hydra.utils import instantiate
from numpy.typing import NDArray
from omegaconf import DictConfig
from tqdm import tqdm

from experiments.command import command, environment, run_directory, seed_everything, write_json
from experiments.estimation import Refusal, evaluate_trial
from experiments.evaluated import Evaluated, rows
from experiments.networks import network_of
from experiments.report import write_report
from experiments.results import results_table, write_results
from experiments.sources import combined_index, load, open_sources
from experiments.splits import Fold
from experiments.tensorboard_log import TensorBoardLog
from narx import checkpoint as checkpoints
from narx.calibration import CalibratedSegment, calibrate
from narx.checkpoint import Checkpoint
from narx.datasets.base import TrialSource
from narx.errors import UserError
from narx.method import OrientationMethod
from narx.segment_angles import SAGITTAL
from narx.training import contiguous

FloatArray = NDArray[np.float64]


@dataclass
class Benchmark:
    """What a benchmark has gathered.

    Parameters
    ----------
    results : pandas.DataFrame
        The rows of ``results.csv``.
    evaluated : list of Evaluated
        Thinned out, for figures: joints where there are any, else segments.
    refusals : list of Refusal
        Methods that a recording did not fit.
    networks : dict of str to Checkpoint
        By fold; empty where no network ran.
    sources : dict of str to str
        Data files and their SHA-256.
    notes : list of str
        What the sources did to their data.
    gyroscope : tuple of (str, ndarray of shape (N,), float), optional
        Title, sagittal rate in rad/s and sampling rate in Hz of one segment, for its spectrum.
    """

    results: pd.DataFrame
    evaluated: list[Evaluated] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)
    networks: dict[str, Checkpoint] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    gyroscope: tuple[str, FloatArray, float] | None = None


def run(cfg: DictConfig, log: TensorBoardLog | None = None) -> Benchmark:
    """Train where the split wants it, run every method, and compare.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/benchmark.yaml``.
    log : TensorBoardLog, optional
        Told how training goes.

    Returns
    -------
    Benchmark
        Everything that tables and figures need.
    """
    rng = np.random.default_rng(cfg.seed)
    sources = open_sources(cfg)
    folds = list(instantiate(cfg.split)(combined_index(sources), rng))
    classical = _classical_methods(cfg)
    gathered = Benchmark(pd.DataFrame())
    all_rows = []
    progress = tqdm(
        total=sum(len(fold.test) for fold in folds), desc="trials", unit="trial", disable=None
    )
    for fold in folds:
        methods = dict(classical)
        if "narx" in cfg.methods:
            methods = _with_network(cfg, sources, fold, rng, log, gathered) | methods
        for part in fold.test:
            progress.set_postfix_str("/".join(part.key[1:]))
            trial = load(sources, part)
            calibrated = calibrate(trial, cfg.calibration)
            evaluated, refusals = evaluate_trial(
                trial, calibrated, methods, part, cfg.evaluation.skip_s
            )
            if gathered.gyroscope is None:
                gathered.gyroscope = _gyroscope(trial.name, calibrated, cfg.evaluation.skip_s)
            for one in evaluated:
                all_rows += rows(one)
            # hours at 500 Hz would not stay in memory: figures get a thinned copy
            joints = [one for one in evaluated if one.segment.startswith(("knee", "joint"))]
            gathered.evaluated += [
                one.decimated(cfg.evaluation.figure_rate_hz) for one in joints or evaluated
            ]
            gathered.refusals += refusals
            gathered.sources |= trial.sources
            gathered.notes += [f"{trial.name}: {note}" for note in trial.notes]
            progress.update()
    progress.close()
    gathered.results = results_table(all_rows)
    return gathered


def _with_network(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    rng: np.random.Generator,
    log: TensorBoardLog | None,
    gathered: Benchmark,
) -> dict[str, OrientationMethod]:
    told = log.for_fold(fold.name) if log else lambda iteration, numbers: None
    network = network_of(cfg, sources, fold, rng, told)
    gathered.networks[fold.name] = network
    return {"narx": network.method()}


def _gyroscope(
    trial: str, calibrated: Mapping[str, CalibratedSegment], skip_s: float
) -> tuple[str, FloatArray, float] | None:
    """Longest stretch of a walking shank (or thigh) without gaps, for the spectrum."""
    for kind in ("shank", "thigh"):
        for name, segment in calibrated.items():
            if name.startswith(kind):
                signals = segment.signals
                keep = np.arange(signals.n_samples) >= skip_s * signals.sampling_rate_hz
                pieces = contiguous(name, signals, signals.axis_rates_rad_s, keep)
                if pieces:
                    rates = max(pieces, key=lambda p: p.duration_s).signals.axis_rates_rad_s
                    return f"{trial}, {name}", rates[:, SAGITTAL], signals.sampling_rate_hz
    return None


def _classical_methods(cfg: DictConfig) -> dict[str, OrientationMethod]:
    methods: dict[str, OrientationMethod] = {}
    for name in cfg.methods:
        if name == "narx":
            continue
        if name not in cfg.method:
            known = ", ".join(["narx", *sorted(cfg.method)])
            raise UserError(f"methods: no method is named '{name}', expected some of {known}")
        methods[name] = instantiate(cfg.method[name])
    return methods


def _benchmark(cfg: DictConfig) -> None:
    seed_everything(cfg.seed)
    directory = run_directory()
    with TensorBoardLog(directory / "tensorboard") as log:
        gathered = run(cfg, log)
        write_results(gathered.results, directory / "results.csv")
        write_json(environment(cfg.seed, gathered.sources), directory / "environment.json")
        for fold, network in gathered.networks.items():
            checkpoints.save(network, directory / "networks" / f"{_file_name(fold)}.pt")
        summary = write_report(cfg, gathered.results, gathered.evaluated, gathered.refusals,
                               gathered.networks, gathered.gyroscope, directory, log)  # fmt: skip
    print(summary)
    print(f"\nresults.csv, summary.md, figures and TensorBoard events: {directory}")


def _file_name(fold: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "._-" else "_" for letter in fold)


main = command("benchmark")(_benchmark)

if __name__ == "__main__":
    main()
