"""Searches by Optuna: seeded, stored in the sweep's folder, resumed after an interruption."""

import hashlib
import importlib
import json
import sys
from typing import Any, Literal

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, ListConfig, OmegaConf
from pydantic import BaseModel

from narx.errors import UserError
from narx.experiments.runs.identity import run_identity
from narx.experiments.runs.sweep import USER_ERROR_STATUS
from narx.settings.checked import CONFIG, validated
from narx.settings.values import Count

Direction = Literal["minimize", "maximize"]


class _Search(BaseModel):
    model_config = CONFIG
    n_trials: Count
    n_jobs: Count
    direction: Direction | tuple[Direction, ...]


class ResumableStudy(Callback):
    """Prepare `hydra/sweeper=optuna`, whose defaults are neither persistent nor seeded.

    Unless configured otherwise, the study is stored in ``optuna.db`` in the sweep's folder under
    the command's name and a digest of what is searched, the sampler uses the run's seed, and failed
    trials are reported without ending the search. ``n_trials`` includes the finished trials of
    earlier launches.
    """

    def on_multirun_start(self, config: DictConfig, **further: Any) -> None:
        """Set the options that are not configured; end the command if an option is invalid.

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
        try:
            search = _checked(config)
            sweeper.storage = sweeper.storage or f"sqlite:///{config.hydra.sweep.dir}/optuna.db"
            sweeper.study_name = sweeper.study_name or _name(config, search)
            finished = _finished(sweeper.storage, sweeper.study_name, _n_values(search))
        except UserError as error:  # Hydra turns exceptions of its callbacks into warnings
            print(f"error: {error}", file=sys.stderr)
            sys.exit(USER_ERROR_STATUS)
        sweeper.max_failure_rate = 1.0
        if sweeper.sampler.get("seed", 0) is None:
            sweeper.sampler.seed = config.seed
        sweeper.n_trials = max(sweeper.n_trials - finished, 0)


def _checked(config: DictConfig) -> _Search:
    given = OmegaConf.to_container(config.hydra.sweeper, enum_to_str=True)
    assert isinstance(given, dict)
    values = {key: given[key] for key in _Search.model_fields}
    search = validated(_Search, values, "hydra.sweeper.")
    assert isinstance(search, _Search)
    if "objectives" not in config:
        raise UserError(
            f"hydra/sweeper is optuna, which {config.hydra.job.config_name} has no objectives for; "
            "expected narx-train, or another sweeper"
        )
    objectives = config.objectives
    n_objectives = len(objectives) if isinstance(objectives, ListConfig) else 1
    if _n_values(search) != n_objectives:
        raise UserError(
            f"hydra.sweeper.direction has {_n_values(search)} for {n_objectives} objectives; "
            "expected one of minimize, maximize for each, in a list if there are several"
        )
    searched = config.hydra.sweeper
    if not (_swept(config) or searched.params or searched.search_space
            or searched.custom_search_space):  # fmt: skip
        raise UserError(
            "hydra/sweeper is optuna, and nothing varies; expected a range to search in, such as "
            "'model.hidden=range(1,8)'"
        )
    return search


def _n_values(search: _Search) -> int:
    return 1 if isinstance(search.direction, str) else len(search.direction)


def _swept(config: DictConfig) -> list[str]:
    overrides = OverridesParser.create().parse_overrides(list(config.hydra.overrides.task))
    return sorted(str(o.input_line) for o in overrides if o.is_sweep_override())


def _name(config: DictConfig, search: _Search) -> str:
    """Name a study such that only searches of the same among the same share their trials."""
    sweeper = OmegaConf.to_container(config.hydra.sweeper, enum_to_str=True)
    assert isinstance(sweeper, dict)
    spaces = [sweeper[key] for key in ("params", "search_space", "custom_search_space")]
    text = json.dumps([run_identity(config), _swept(config), spaces, search.direction])
    return f"{config.hydra.job.name}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _finished(storage: str, name: str, n_values: int) -> int:
    optuna: Any = importlib.import_module("optuna")  # optional, and slow to import
    try:
        names = {study.study_name for study in optuna.get_all_study_summaries(storage)}
    except Exception as error:  # SQLAlchemy's own, and ImportError of a database's driver
        reason = str(error).partition("\n")[0]
        raise UserError(f"hydra.sweeper.storage is '{storage}': {reason}") from error
    if name not in names:
        return 0
    study = optuna.load_study(study_name=name, storage=storage)
    if len(study.directions) != n_values:
        raise UserError(
            f"hydra.sweeper.study_name is '{name}', a study of {len(study.directions)} objectives, "
            f"not {n_values}; expected another name"
        )
    states = optuna.trial.TrialState
    for trial in study.trials:
        if trial.state == states.RUNNING:  # interrupted together with its launch
            study.tell(trial.number, state=states.FAIL)
    return sum(trial.state == states.COMPLETE for trial in study.trials)
