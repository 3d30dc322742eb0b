"""The forms in which a method is compared: as printed, with the same ingredients, and chosen."""

import inspect
from collections.abc import Mapping
from typing import Any

from hydra.utils import get_class
from omegaconf import DictConfig, OmegaConf

from narx.errors import UserError

PRINTED = "printed"
CHOSEN = "chosen"


def forms_of(cfg: DictConfig, method: str) -> dict[str, dict[str, Any]]:
    """List the rows of one method and the settings of each.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `method` (settings by name) and `forms` (overrides by name of the form; `only` names
        the methods that have it).
    method : str
        Name of the method.

    Returns
    -------
    dict of str to dict
        Settings with ``_target_``, by row: the method's own name as printed, with the name of
        the form behind it otherwise. A form changes what the method has a parameter for; one that
        changes nothing is no row.

    Raises
    ------
    UserError
        If a form is not a mapping.
    """
    printed = _plain(cfg.method[method])
    takes = inspect.signature(get_class(printed["_target_"])).parameters
    rows: dict[str, dict[str, Any]] = {}
    for form, given in (cfg.forms or {}).items():
        if given is None:  # switched off
            continue
        if not isinstance(given, DictConfig):
            raise UserError(f"forms.{form} is {given!r}, expected parameters and their values")
        overrides = _plain(given)
        if method not in overrides.pop("only", [method]):
            continue
        settings = printed | {key: value for key, value in overrides.items() if key in takes}
        if form == PRINTED:
            rows[method] = settings
        elif settings not in rows.values() and settings != printed:
            rows[f"{method}_{form}"] = settings
    return rows


def grid_of(cfg: DictConfig, method: str) -> Mapping[str, list[Any]]:
    """Look up what a method's parameters are chosen from.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        Holds `grid`.
    method : str
        Name of the method.

    Returns
    -------
    mapping of str to list
        Values by parameter; empty where there is nothing to choose.
    """
    grids = cfg.get("grid") or {}
    return _plain(grids[method]) if method in grids else {}


def _plain(settings: Any) -> dict[str, Any]:
    plain = OmegaConf.to_container(settings, resolve=True)
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}
