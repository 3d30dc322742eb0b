"""The words on the command line, made into what Hydra's grammar takes.

File names may hold letters, blanks, commas and brackets that Hydra reads as syntax.
"""

import re
from collections.abc import Iterable

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

# where a comma is part of a name
_FILES = ("input", "output", "checkpoint", "data_root", "still_file")
_OPENING = ("'", '"', "[", "{", "$")
# an element of a list, or a key and its value
_ELEMENT = re.compile(r"""(?<=[\[{,])(\s*(?:\w+\s*:\s*)?)([^\s\[\]{},'"][^\[\]{},'"]*)""")


def readable(arguments: Iterable[str]) -> list[str]:
    """Quote file names.

    Parameters
    ----------
    arguments : iterable of str
        Words of the command line after the program's name.

    Returns
    -------
    list of str
        A value that Hydra's grammar does not take, and a file name with a comma, in quotes; all
        others as they are.
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
        # a number of thousands of digits, brackets within thousands of brackets
        return False
    return True


def _quoted(text: str) -> str:
    # backslashes count as such but before a quote
    return "'" + re.sub(r"(\\*)(?='|$)", r"\1\1", text).replace("'", r"\'") + "'"


def _quoted_match(match: re.Match[str]) -> str:
    text = match[2].rstrip()
    return match[1] + (text if _is_grammar(f"k={text}") else _quoted(text))
