"""Train a network and write it as a checkpoint.

narx-train data=smartphone_pocket data_root=DIR teacher=reference seed=1
"""

import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from hydra.utils import instantiate
from omegaconf import DictConfig
from tqdm import tqdm

from narx.datasets.base import TrialSource
from narx.datasets.splits import Fold, load_calibrated
from narx.errors import UserError
from narx.evaluation.comparison import Evaluated, rows
from narx.evaluation.results import results_table, write_results
from narx.evaluation.trial import evaluate_trial
from narx.evaluation.workload import Workload
from narx.experiments.command import command, in_sweep, run_directory, states_folder
from narx.experiments.figures.canvas import save_figure
from narx.experiments.networks import choose, train
from narx.experiments.reports.networks import training_history_figure
from narx.experiments.reports.training import pieces, training_summary
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.sources import combined_index, open_sources
from narx.experiments.tensorboard_log import TensorBoardLog
from narx.files import atomic_path
from narx.inference import checkpoint as checkpoints
from narx.inference.checkpoint import Checkpoint

HELD_BACK = "held_back_error_deg"
WEIGHTS = "n_weights"


def _train(cfg: DictConfig) -> float | list[float]:
    """Train on the only fold of the split; return the values that a search minimises."""
    seed_everything(cfg.seed)
    workload = Workload()
    directory = run_directory()
    sources = open_sources(cfg)
    fold = only_fold(list(instantiate(cfg.split, _convert_="all")(combined_index(sources))))
    with TensorBoardLog(directory / "tensorboard") as log:
        log.configuration(cfg, fold.name)
        with tqdm(desc="iterations", unit="it", disable=in_sweep() or None) as progress:

            def log_iteration(iteration: int, numbers: dict[str, float]) -> None:
                log.iteration(iteration, numbers)
                progress.update()

            begun = time.perf_counter()
            last = states_folder(cfg)
            chosen = choose(cfg, sources, fold, last) if cfg.candidates else cfg
            network = train(chosen, sources, fold, log_iteration, last)
            workload.training_s = time.perf_counter() - begun
        checkpoints.save(network, directory / "checkpoint.pt")
        results, evaluated = _on_own_trials(chosen, sources, fold, network, workload)
        restarts = network.history["report"]["restarts"]
        metrics = {
            HELD_BACK: float(restarts["validation_rmse_best_deg"]),
            WEIGHTS: float(network.model.structure.n_weights),
        }
        summary = training_summary(fold.name, network, results, cfg.training.skip_s)
        _write(directory, cfg, network, results, pieces(evaluated), summary)
        log.weights(network)
        log.best_start(network)
        log.scalars(metrics)
        metrics |= log.results(results)
        log.table_of_runs(chosen, metrics)
        write_json(metrics, directory / "metrics.json")
        write_json(workload.report(), directory / "timing.json")
        # last, since it can be drawn again
        figure = training_history_figure(network, fold.name)
        drawn = directory / "figures" / "training.png"
        save_figure(figure, drawn)
        log.figure("training", drawn)
    print(
        f"{fold.name}: held-out error {metrics[HELD_BACK]:.3f} deg, stopped by "
        f"{network.history['report']['code']}\n{directory / 'checkpoint.pt'}"
        if in_sweep()
        else f"{summary}\n{directory / 'checkpoint.pt'}"
    )
    return _objectives(cfg, metrics)


def only_fold(folds: list[Fold]) -> Fold:
    """Return the fold of a split that is to have one.

    Parameters
    ----------
    folds : list of Fold
        All folds of the split.

    Returns
    -------
    Fold
        The only one.

    Raises
    ------
    UserError
        If there are none or several, or the only one has nothing to train on.
    """
    if len(folds) != 1:
        raise UserError(
            f"split: training makes one network, this split has {len(folds)} folds; use "
            "split=everything or split=one_window, or narx-benchmark to test every fold"
        )
    if not folds[0].training:
        raise UserError(
            "split: this split only tests, there is nothing to train on; use split=everything or "
            "split=one_window"
        )
    return folds[0]


def _on_own_trials(
    cfg: DictConfig,
    sources: Mapping[str, TrialSource],
    fold: Fold,
    network: Checkpoint,
    workload: Workload,
) -> tuple[pd.DataFrame, list[Evaluated]]:
    all_rows, evaluated = [], []
    methods = {"narx": network.method()}
    for part in {part.key: part for part in fold.training}.values():
        trial, segments = load_calibrated(sources, part, cfg.calibration)
        here, _ = evaluate_trial(
            trial, segments, methods, part.whole(), cfg.training.skip_s, workload
        )
        all_rows += [row for one in here for row in rows(one)]
        evaluated += here[-2:]
    return results_table(all_rows), evaluated


def _write(
    directory: Path,
    cfg: DictConfig,
    network: Checkpoint,
    results: pd.DataFrame,
    angles: pd.DataFrame,
    summary: str,
) -> None:
    history = network.history
    write_results(results, directory / "results.csv")
    with atomic_path(directory / "angles.csv") as temporary:
        angles.to_csv(temporary, index=False)
    with atomic_path(directory / "summary.md") as temporary:
        temporary.write_text(summary, encoding="utf-8")
    write_json(environment(cfg.seed, history["data_sha256"]), directory / "environment.json")
    write_json(
        {key: value for key, value in history.items() if key != "config"},
        directory / "training.json",
    )


def _objectives(cfg: DictConfig, metrics: Mapping[str, float]) -> float | list[float]:
    values = []
    for name in cfg.objectives:
        # Optuna reports a value that is not finite as an error of the program
        if not np.isfinite(metrics.get(name, np.nan)):
            raise UserError(f"objectives: {name} has no finite value in this run")
        values.append(metrics[name])
    return values[0] if len(values) == 1 else values


main = command("train")(_train)

if __name__ == "__main__":
    main()
