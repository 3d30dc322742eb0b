"""Compare the optimisers on three kinds of data.

python -m experiments.optimizers data_root=DIR
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from hydra.utils import instantiate
from omegaconf import DictConfig
from tqdm import tqdm

from narx.datasets.splits import TrialPart, load_calibrated
from narx.experiments.command import command, run_directory
from narx.experiments.configuration import composed_configuration
from narx.experiments.networks import trainer
from narx.experiments.runs.record import environment, seed_everything, write_json
from narx.experiments.sources import combined_index, open_sources
from narx.experiments.tables.table import Table
from narx.experiments.train import only_fold
from narx.files import atomic_path
from narx.training.objective import FitReport, Optimizer
from narx.training.trainer import Trainer
from narx.training.trial_reader import Stretch
from narx.windows import TrainingSequence, from_arrays

PLAIN_ARRAYS = "plain_arrays"
_COLUMNS = ("Held-out error (°)", "Cost evaluations", "CPU time (s)")

# sequences for training and for validation; without the latter, the end of the former is held out
_Data = tuple[list[TrainingSequence], list[TrainingSequence]]


class _Timed:
    """An optimiser with measurement of its CPU time, which hardly depends on other load."""

    def __init__(self, optimizer: Optimizer) -> None:
        self._optimizer = optimizer
        self.report: FitReport | None = None
        self.time_s = 0.0

    def fit(self, *arguments: Any) -> FitReport:
        begun = time.process_time()
        self.report = self._optimizer.fit(*arguments)
        self.time_s = time.process_time() - begun
        return self.report


def plain_arrays(seed: int) -> list[TrainingSequence]:
    """Create three recordings similar to a user's arrays.

    Parameters
    ----------
    seed : int
        Seed of the noise and of the differences between the recordings.

    Returns
    -------
    list of TrainingSequence
        30 s each at 100 Hz: five harmonics of a stride about all three axes, rates with noise and
        a bias of their own.
    """
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, 30.0, 0.01)[:, None]
    sequences = []
    for number, stride_hz in enumerate((0.8, 0.9, 1.0)):
        angles = np.zeros((len(time_s), 3))
        for k in range(1, 6):
            size = np.array([0.4, 0.08, 0.1]) / k**2 * rng.uniform(0.5, 1.0, 3)
            phase = rng.uniform(0.0, 2.0 * np.pi, 3)
            angles += size * np.sin(2.0 * np.pi * stride_hz * k * time_s + phase)
        rates = np.gradient(angles, 0.01, axis=0) + rng.normal(0.0, 0.005, 3)
        rates += rng.normal(0.0, 0.02, rates.shape)
        sequences += from_arrays(rates, angles, 100.0, name=f"arrays {number}")
    return sequences


def _configured(cfg: DictConfig, kind: str, optimizer: str) -> DictConfig:
    overrides = [f"seed={cfg.seed}", f"optimizer={optimizer}", *cfg.data[kind], *cfg.overrides]
    if cfg.data_root is not None:
        overrides.insert(0, f"data_root={cfg.data_root}")
    return composed_configuration("train", overrides, f"optimizers {optimizer}, data.{kind}")


def _data(cfg: DictConfig, kind: str) -> _Data:
    if kind == PLAIN_ARRAYS:
        return plain_arrays(cfg.seed), []
    sources = open_sources(cfg)
    fold = only_fold(list(instantiate(cfg.split, _convert_="all")(combined_index(sources))))
    reader = trainer(cfg).reader

    def stretches(parts: Sequence[TrialPart]) -> Iterator[Stretch]:
        for part in parts:
            trial, segments = load_calibrated(sources, part, reader.calibration)
            yield Stretch(trial, part.start_s, part.stop_s, segments)

    return reader.sequences(stretches(fold.training)), reader.sequences(stretches(fold.validation))


def _row(trained_by: Trainer, data: _Data) -> dict[str, float]:
    optimizer: Any = trained_by.optimizer
    # compile or load the machine code before the time is measured
    replace(trained_by, optimizer=replace(optimizer, restarts=1, iterations=1)).fit(*data)
    timed = _Timed(optimizer)
    replace(trained_by, optimizer=timed).fit(*data)
    assert timed.report is not None
    error_deg = timed.report.restarts["validation_rmse_best_deg"]
    return dict(zip(_COLUMNS, (error_deg, timed.report.evaluations, timed.time_s), strict=True))


def _optimizers(cfg: DictConfig) -> None:
    seed_everything(cfg.seed)
    directory = run_directory()
    # every optimiser is checked before the first one runs
    settings = {
        (kind, name): _configured(cfg, kind, name) for kind in cfg.data for name in cfg.optimizers
    }
    data: dict[str, _Data] = {}
    rows = {}
    for (kind, name), setting in tqdm(settings.items(), desc="trainings", disable=None):
        if kind not in data:
            data[kind] = _data(setting, kind)
        rows[kind, name] = _row(trainer(setting), data[kind])
    frame = pd.DataFrame.from_dict(rows, orient="index", columns=list(_COLUMNS))
    frame.index = pd.MultiIndex.from_tuples(
        [(kind.replace("_", " "), name) for kind, name in rows], names=["Data", "Optimiser"]
    )
    frame[_COLUMNS[1]] = frame[_COLUMNS[1]].astype(int)
    table = Table(
        "One training by each optimiser", frame, dict(zip(_COLUMNS, (3, 0, 1), strict=True))
    )
    with atomic_path(directory / "optimizers.csv") as temporary:
        temporary.write_text(table.to_csv())
    write_json(environment(cfg.seed, {}), directory / "environment.json")
    text = table.to_markdown()
    with atomic_path(directory / "optimizers.md") as temporary:
        temporary.write_text(text)
    print(text)
    print(f"\noptimizers.csv and optimizers.md: {directory}")


main = command("optimizers")(_optimizers)

if __name__ == "__main__":
    main()
