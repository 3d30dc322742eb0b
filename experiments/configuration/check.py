"""Check a composed configuration as a whole, before anything is read or computed."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException
from pydantic import BaseModel

from narx.errors import UserError, user_error_behind
from narx.experiments.configuration.components import schema_for
from narx.experiments.configuration.schemas import SCHEMAS
from narx.experiments.networks import candidate_of, trainer
from narx.settings.checked import validated
from narx.settings.wording import shown

# sources for training and comparison that have no angles to predict
_NOT_PREDICTED = {
    "simulated_gait": "simulated walks have true angles",
    "smartphone_pocket": "its phones are on a thigh of unknown side, or in a hand",
    "broad": "its sensor is moved by hand",
    "joint_1to3dof": "its sensors are moved by hand",
}


def checked_configuration(cfg: DictConfig, command: str) -> DictConfig:
    """Check every key of a command's configuration.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As Hydra composed it.
    command : str
        Name of the command's primary configuration.

    Returns
    -------
    omegaconf.DictConfig
        The same with every value converted to its type (names to text, words for yes and no to
        true and false) and all interpolations resolved.

    Raises
    ------
    UserError
        If a value is not allowed; the message names the key, its value and what is expected.
    """
    if command == "predict":
        _check_predicted(cfg)
    values = _container(cfg)
    schema = schema_for(SCHEMAS[command], values)
    result = OmegaConf.create(validated(schema, values).model_dump(by_alias=True))
    _check_grid(schema, values)
    for path, section in _components(result):
        _made(partial(instantiate, section, _convert_="all"), path)
    if "training" in result:
        _made(partial(trainer, result), "training")
        _check_names_of_sources(result)
        _check_candidates(result, command)
    return result


def _check_predicted(cfg: DictConfig) -> None:
    """Refuse sources without sensors on a leg before anything is read."""
    for name in cfg.get("data") or {}:
        if name in _NOT_PREDICTED:
            raise UserError(
                f"data={name}: {_NOT_PREDICTED[str(name)]}; expected study, motion_bids or "
                "neura_sample (narx-benchmark predicts the others, and compares)"
            )


def _container(cfg: DictConfig) -> dict[str, Any]:
    try:
        values = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)
    except MissingMandatoryValue as error:
        raise UserError(
            f"{error.full_key} is missing, expected a value: {error.full_key}=..."
        ) from error
    except RecursionError as error:
        raise UserError("configuration: an interpolation ${...} refers to itself") from error
    assert isinstance(values, dict)
    return {str(key): value for key, value in values.items()}


def _components(cfg: DictConfig) -> Iterator[tuple[str, DictConfig]]:
    """Sections that the run instantiates; of the methods, only those that it runs."""
    for name in ("model", "optimizer", "teacher", "report"):
        if name in cfg:
            yield name, cfg[name]
    for name, section in cfg.get("data", {}).items():
        if isinstance(section, DictConfig):
            yield f"data.{name}", section
    for name, section in cfg.get("method", {}).items():
        if name in cfg.methods:
            yield f"method.{name}", section


def _check_names_of_sources(cfg: DictConfig) -> None:
    for name in cfg.training.weights:
        if name not in cfg.data:
            known = ", ".join(str(source) for source in cfg.data if source != "seed")
            raise UserError(f"training.weights.{name}: unknown source, data has {known}")


def _check_candidates(cfg: DictConfig, command: str) -> None:
    for number, overrides in enumerate(cfg.candidates):
        try:
            candidate = candidate_of(cfg, overrides)
            candidate.candidates = []
            checked_configuration(candidate, command)
        except (UserError, OmegaConfBaseException) as error:
            said = " ".join(str(error).split())
            raise UserError(f"candidates.{number} is {shown(overrides)}: {said}") from error


def _check_grid(schema: type[BaseModel], values: Mapping[str, Any]) -> None:
    """Check that the method accepts every value of the grid it may be chosen from."""
    for name, choices in values.get("grid", {}).items():
        if name not in values["method"]:
            known = ", ".join(values["method"])
            raise UserError(f"grid.{name}: unknown method, expected one of {known}")
        methods: Any = schema.model_fields["method"].annotation
        model = methods.model_fields[name].annotation
        for key, choice in ((k, c) for k, listed in choices.items() for c in listed):
            validated(model, values["method"][name] | {key: choice}, f"grid.{name}: ")


def _made(make: Callable[[], object], path: str) -> None:
    """Call the constructors, which refuse what types cannot express, e.g. conflicting values."""
    try:
        make()
    except (InstantiationException, UserError) as error:
        mistake = user_error_behind(error)
        cause = mistake or error.__cause__
        if mistake is None and not isinstance(cause, ValueError):
            raise
        said = str(cause)
        raise UserError(said if path.partition(".")[0] in said else f"{path}: {said}") from error
