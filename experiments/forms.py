"""The forms of a method in a benchmark: as printed, with equal ingredients, parameters chosen."""

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
        With `method` (settings by name) and `forms` (overrides by name of the form; `only` lists
        the methods that the form applies to).
    method : str
        Name of the method.

    Returns
    -------
    dict of str to dict
        Settings with ``_target_``, by row. The row as printed has the method's name, every other
        row has the name of the form appended. Overrides that the method has no parameter for are
        ignored; a form that changes nothing gets no row.

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
    """Look up the grid from which a method's parameters are chosen.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `grid`.
    method : str
        Name of the method.

    Returns
    -------
    mapping of str to list
        Candidate values of each parameter; empty if nothing is chosen.
    """
    grids = cfg.get("grid") or {}
    return _plain(grids[method]) if method in grids else {}


def _plain(settings: Any) -> dict[str, Any]:
    plain = OmegaConf.to_container(settings, resolve=True)
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}
