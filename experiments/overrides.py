"""Quote command-line arguments where Hydra's grammar requires it.

File names may contain letters, blanks, commas and brackets that Hydra reads as syntax.
"""

import re
from collections.abc import Iterable

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

# contexts in which a comma is part of a name
_FILES = ("input", "output", "checkpoint", "data_root", "still_file")
_OPENING = ("'", '"', "[", "{", "$")
# an element of a list, or a key and its value
_ELEMENT = re.compile(r"""(?<=[\[{,])(\s*(?:\w+\s*:\s*)?)([^\s\[\]{},'"][^\[\]{},'"]*)""")


def readable(arguments: Iterable[str]) -> list[str]:
    """Quote arguments such as file names.

    Parameters
    ----------
    arguments : iterable of str
        Command-line arguments after the program's name.

    Returns
    -------
    list of str
        Values that Hydra's grammar does not accept and file names with a comma are quoted; all
        others are unchanged.
    """
    return [_readable(argument) for argument in arguments]


def _readable(argument: str) -> str:
    key, equals, value = argument.partition("=")
    if not equals or argument.startswith("-") or not value:
        return argument
    if value.startswith(("[", "{")):
        return argument if _is_grammar(argument) else f"{key}={_ELEMENT.sub(_quoted_match, value)}"
    if value.startswith(_OPENING):
        return argument
    if _is_grammar(argument) and not (key in _FILES and "," in value):
        return argument
    return f"{key}={_quoted(value)}"


def _is_grammar(argument: str) -> bool:
    try:
        OverridesParser.create().parse_override(argument)
    except (HydraException, ValueError, RecursionError):
        # raised for numbers with thousands of digits, or brackets nested thousands deep
        return False
    return True


def _quoted(text: str) -> str:
    # a backslash is literal, except before a quote
    return "'" + re.sub(r"(\\*)(?='|$)", r"\1\1", text).replace("'", r"\'") + "'"


def _quoted_match(match: re.Match[str]) -> str:
    text = match[2].rstrip()
    return match[1] + (text if _is_grammar(f"k={text}") else _quoted(text))
