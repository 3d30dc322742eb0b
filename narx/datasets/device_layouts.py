"""Descriptions of devices in YAML: those of the package, and those of the user."""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from narx.datasets.column_search import first_found
from narx.datasets.layout import OWN, Columns, Layout, Opposite
from narx.errors import UserError
from narx.recordings.input_file import regular_file

_KEYS = {"time", "gyroscope", "accelerometer", "comment", "files", "opposite"}
_COLUMN_KEYS = {"names", "unit", "sign", "wraps"}


def layout_from(description: Mapping[str, Any], name: str) -> Layout:
    """Build a layout from a description.

    Parameters
    ----------
    description : mapping
        ``time``, ``gyroscope`` and, if there is one, ``accelerometer``: each a pattern, a list of
        three names, a mapping with ``names``, ``unit``, ``sign`` and ``wraps``, or a list of such
        mappings or patterns as alternatives. ``comment``, ``files`` and ``opposite`` as of
        `Layout`.
    name : str
        Source of the description, for messages.

    Returns
    -------
    Layout
        The validated layout.

    Raises
    ------
    UserError
        If a key is unknown or missing, or a value has the wrong type.
    """
    unknown = set(description) - _KEYS
    if unknown:
        raise UserError(
            f"{name}: '{sorted(map(str, unknown))[0]}' is unknown, expected "
            f"{', '.join(sorted(_KEYS))}"
        )
    for key in ("time", "gyroscope"):
        if not description.get(key):
            raise UserError(f"{name}: no '{key}', expected the name of its columns")
    return Layout(
        name,
        _alternatives(description["time"], f"{name}: time"),
        _alternatives(description["gyroscope"], f"{name}: gyroscope"),
        _alternatives(description.get("accelerometer") or [], f"{name}: accelerometer"),
        description.get("comment"),
        description.get("files") or {},
        _opposite(description.get("opposite"), name),
    )


def read_layout(path: Path) -> Layout:
    """Read a user's description of a device.

    Parameters
    ----------
    path : pathlib.Path
        YAML file.

    Returns
    -------
    Layout
        As `layout_from`.

    Raises
    ------
    UserError
        If the file is not YAML, or not such a description.
    """
    try:
        content = OmegaConf.to_container(OmegaConf.load(regular_file(path)))
    except (YAMLError, OmegaConfBaseException, ValueError, OSError, RecursionError) as error:
        # OmegaConf raises an OSError for YAML that is a number alone
        reason = " ".join(str(error).split())[:160]
        raise UserError(f"{path}: not YAML of keys and values ({reason})") from None
    if not isinstance(content, dict):
        raise UserError(f"{path}: holds no mapping, expected time, gyroscope and accelerometer")
    return layout_from({str(key): value for key, value in content.items()}, str(path))


@cache
def shipped_layouts() -> tuple[Layout, ...]:
    """Return the layouts of the described devices, then the package's own.

    Returns
    -------
    tuple of Layout
        In the order in which they are tried: devices first, since their names are more specific.
    """
    folder = resources.files("narx.datasets.devices")
    files = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".yaml"))
    described = []
    for file in files:
        with resources.as_file(folder / file) as path:
            content = OmegaConf.to_container(OmegaConf.load(path))
        assert isinstance(content, dict)
        described.append(
            layout_from({str(k): v for k, v in content.items()}, file.removesuffix(".yaml"))
        )
    # a required comment makes a description more specific
    return (*sorted(described, key=lambda layout: layout.comment is None), OWN)


def recognised(
    names: Sequence[str], units: Sequence[str] | None, comments: str, where: str
) -> Layout:
    """Find the layout of a table.

    Parameters
    ----------
    names : sequence of str
        Names of its columns.
    units : sequence of str, optional
        Its units row.
    comments : str
        Lines above the header.
    where : str
        File, for messages.

    Returns
    -------
    Layout
        The first that matches; the package's own, if none does.
    """
    for layout in shipped_layouts():
        if layout.comment is not None and not re.search(layout.comment, comments):
            continue
        time = first_found(layout.time, "time", names, units, where)
        if time and first_found(layout.gyroscope, "gyroscope", names, units, where):
            return layout
    return OWN


def _opposite(value: object, name: str) -> Opposite | None:
    if value is None:
        return None
    values = value.get("values") if isinstance(value, dict) else None
    if not isinstance(value, dict) or set(value) != {"file", "values"} or not values:
        raise UserError(f"{name}: opposite is {value}, expected a mapping with file and values")
    if not isinstance(values, dict):
        raise UserError(f"{name}: opposite.values is {values}, expected columns and their values")
    return Opposite(str(value["file"]), {str(k): str(v) for k, v in values.items()})


def _alternatives(value: object, where: str) -> tuple[Columns, ...]:
    if isinstance(value, list) and not _is_triple(value):
        return tuple(_columns(one, where) for one in value)
    return (_columns(value, where),)


def _is_triple(value: list[object]) -> bool:
    plain = all(isinstance(one, str) and "{" not in one for one in value)
    return len(value) == 3 and plain


def _columns(value: object, where: str) -> Columns:
    if isinstance(value, str | list):
        return Columns(value)
    if not isinstance(value, dict) or "names" not in value or set(value) - _COLUMN_KEYS:
        raise UserError(
            f"{where} is {value}, expected a pattern, three names, or a mapping with names and, "
            "where needed, unit, sign, wraps"
        )
    return Columns(**value)
