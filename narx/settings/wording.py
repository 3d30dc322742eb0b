"""Wording of error messages: what is expected of a value, and what was found."""

import types
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo

_PLAIN = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a name",
    type(None): "null",
    dict: "a section",
    Any: "a value",
}
_LONGEST_SHOWN = 60


def shown(value: object) -> str:
    """Format a value as one short line.

    Parameters
    ----------
    value : object
        The value that was found.

    Returns
    -------
    str
        As in a configuration file: null, true, false, strings quoted.
    """
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    try:
        text = ascii(value) if isinstance(value, str) and not value.isprintable() else repr(value)
        text = text.replace("\n", " ")  # between the rows of an array
    except ValueError:
        # Python refuses to print integers with thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."


def expected(annotation: Any) -> str:
    """Describe what an annotation allows.

    Parameters
    ----------
    annotation : type
        Annotation of an argument, with pydantic's constraints.

    Returns
    -------
    str
        Such as ``a number above 0`` or ``one of std, max_abs``.
    """
    constraints: list[object] = []
    while get_origin(annotation) is Annotated:
        annotation, *more = get_args(annotation)
        constraints += more
    described, limits = _constraints(constraints)
    return described or _of_type(annotation) + _range(limits)


def _constraints(metadata: Iterable[object]) -> tuple[str | None, dict[str, float]]:
    described: str | None = None
    limits: dict[str, float] = {}
    for item in metadata:
        if isinstance(item, FieldInfo):
            described = item.description or described
            limits |= _constraints(item.metadata)[1]
        for name in ("gt", "ge", "lt", "le"):
            if isinstance(item, getattr(annotated_types, name.capitalize())):
                limits[name] = getattr(item, name)
    return described, limits


def _range(limits: Mapping[str, float]) -> str:
    if {"ge", "le"} <= set(limits):
        return f" from {_number(limits['ge'])} to {_number(limits['le'])}"
    words = {"gt": "above", "ge": "of at least", "lt": "below", "le": "of at most"}
    parts = [f"{words[name]} {_number(limits[name])}" for name in words if name in limits]
    return " " + " and ".join(parts) if parts else ""


def _number(limit: float) -> str:
    return f"{limit:d}" if isinstance(limit, int) else f"{limit:g}"


def _of_type(annotation: Any) -> str:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Literal:
        names = [str(argument) for argument in arguments]
        return names[0] if len(names) == 1 else f"one of {', '.join(names)}"
    if origin in (Union, types.UnionType):
        *others, last = (expected(argument) for argument in arguments)
        # not one more choice for the elements of a list
        comma = "," if "each" in others[-1] else ""
        return f"{' or '.join(others)}{comma} or {last}"
    if origin in (dict, Mapping):
        return f"a section of names, each with {expected(arguments[1])}"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        names = [field.alias or name for name, field in annotation.model_fields.items()]
        return f"a section with the keys {', '.join(names)}"
    if origin is tuple and Ellipsis not in arguments:
        return f"a list of {len(arguments)}, each {expected(arguments[0])}"
    if origin is not None and arguments:
        return f"a list, each {expected(arguments[0])}"
    return _PLAIN.get(annotation, getattr(annotation, "__name__", "a value"))
