"""Searches by Optuna: seeded, stored in the sweep's folder, resumed after an interruption."""

import importlib
from typing import Any

from hydra.experimental.callback import Callback
from omegaconf import DictConfig


class ResumableStudy(Callback):
    """Prepare `hydra/sweeper=optuna`, whose defaults are neither persistent nor seeded.

    Unless configured otherwise, the study is stored in ``optuna.db`` in the sweep's folder under
    the command's name, the sampler uses the run's seed, and failed trials are reported without
    ending the search. ``n_trials`` includes the finished trials of earlier launches.
    """

    def on_multirun_start(self, config: DictConfig, **further: Any) -> None:
        """Set the options that are not configured.

        Parameters
        ----------
        config : omegaconf.DictConfig
            Configuration of the sweep; unchanged unless the sweeper is Optuna.
        **further : object
            Further arguments from Hydra, unused.
        """
        sweeper = config.hydra.sweeper
        if "study_name" not in sweeper:
            return
        sweeper.storage = sweeper.storage or f"sqlite:///{config.hydra.sweep.dir}/optuna.db"
        sweeper.study_name = sweeper.study_name or config.hydra.job.name
        sweeper.max_failure_rate = 1.0
        if sweeper.sampler.get("seed", 0) is None:
            sweeper.sampler.seed = config.seed
        sweeper.n_trials = max(sweeper.n_trials - _finished(sweeper.storage, sweeper.study_name), 0)


def _finished(storage: str, name: str) -> int:
    optuna: Any = importlib.import_module("optuna")  # optional, and slow to import
    if name not in {study.study_name for study in optuna.get_all_study_summaries(storage)}:
        return 0
    study = optuna.load_study(study_name=name, storage=storage)
    states = optuna.trial.TrialState
    for trial in study.trials:
        if trial.state == states.RUNNING:  # interrupted together with its launch
            study.tell(trial.number, state=states.FAIL)
    return sum(trial.state == states.COMPLETE for trial in study.trials)
