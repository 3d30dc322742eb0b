"""Overrides that Hydra cannot compose: its message in one line, with what is expected."""

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from importlib import resources
from typing import Any

from hydra import compose, initialize_config_module
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException, OverrideParseException
from omegaconf import OmegaConf

CONFIG_MODULE = "narx.configs"

_UNKNOWN_KEY = re.compile(r"Could not (?:override|delete from config\.) '([^']*)'")
_UNKNOWN_OPTION = re.compile(r"Could not (?:find|load) '([^']*)/([^'/]*)'")


def composition_mistake(error: BaseException, command: str, overrides: Sequence[str]) -> str:
    """Describe in one line which override cannot be composed, and what is expected.

    Parameters
    ----------
    error : BaseException
        Raised by Hydra before a job has started.
    command : str
        Name of the command's primary configuration.
    overrides : sequence of str
        As on the command line.

    Returns
    -------
    str
        The message, with the closest existing key for an unknown one, the options of a group, or
        the missing quotes.
    """
    text = str(error)
    if "maximum recursion depth" in text:
        deepest = max(overrides, key=lambda override: override.count("[") + override.count("{"))
        return f"{_beginning(deepest)}: nested too deeply"
    if isinstance(error, OverrideParseException) or not isinstance(error, HydraException):
        for override in (text for text in overrides if not text.startswith("-")):
            reason = _unreadable(override)
            if reason:
                return reason
    unknown = _UNKNOWN_KEY.search(text)
    if unknown:
        key = unknown[1].partition("@")[0]
        known = _known_keys(command)
        if key not in known:
            nearest = get_close_matches(key, known, n=1, cutoff=0.0)
            return f"{unknown[1]}: unknown key, the closest is {nearest[0]}"
    option = _UNKNOWN_OPTION.search(text)
    if option:
        listed = re.search(r"Available options in '[^']*':(.*?)Config search path", text, re.DOTALL)
        files = ", ".join(listed[1].split()) if listed else f"the files of configs/{option[1]}"
        return f"{option[1]} is '{option[2]}', expected one of {files}"
    if not text:  # an assertion on Hydra's own settings
        own = [override for override in overrides if override.startswith("hydra")]
        given = _beginning(", ".join(own or overrides))
        return f"Hydra refuses one of its settings: {given or type(error).__name__}"
    return _one_line(text.partition("Config search path")[0])


def _one_line(text: str) -> str:
    # Hydra and OmegaConf put the location or the options on separate lines
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return re.sub(r"\s+", " ", "; ".join(lines))


def _beginning(override: str) -> str:
    return override if len(override) <= 80 else f"{override[:80]}..."


def _unreadable(override: str) -> str | None:
    begin = _beginning(override)
    try:
        read = OverridesParser.create().parse_override(override)
    except (HydraException, ValueError, RecursionError) as error:
        return f"{begin}: cannot be read ({_one_line(str(error).partition('See https')[0])[:100]})"
    if read.key_or_group in _groups() and not isinstance(read.value(), str | list | dict):
        found = override.partition("=")[2]
        return f"{read.key_or_group} is {found}, expected the name of a file of configs"
    return None


def _groups() -> set[str]:
    return {entry.name for entry in resources.files(CONFIG_MODULE).iterdir() if entry.is_dir()}


def _known_keys(command: str) -> list[str]:
    GlobalHydra.instance().clear()
    with initialize_config_module(CONFIG_MODULE, version_base="1.3"):
        cfg = compose(command, overrides=[])
    return list(_dotted(OmegaConf.to_container(cfg), ""))


def _dotted(values: Any, prefix: str) -> Iterator[str]:
    for name, value in values.items():
        yield f"{prefix}{name}"
        if isinstance(value, Mapping):
            yield from _dotted(value, f"{prefix}{name}.")
