"""Check arguments against their annotations by pydantic; refuse them with a one-line message."""

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from types import UnionType
from typing import Annotated, Any, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from narx.errors import UserError
from narx.settings.wording import expected, shown

P = ParamSpec("P")
R = TypeVar("R")

# a number given for a name is converted to text; pydantic itself converts words such as `no`
CONFIG = ConfigDict(
    extra="forbid",
    allow_inf_nan=False,
    coerce_numbers_to_str=True,
    arbitrary_types_allowed=True,
    populate_by_name=True,
    protected_namespaces=(),
)


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function refuse arguments that its annotations do not allow.

    Parameters
    ----------
    function : callable
        A function, or the ``__init__`` of a class, whose `name`, or own name, then starts the
        message.

    Returns
    -------
    callable
        The same function, called with values converted to the annotated types. It raises
        `UserError` with the argument's name, its value and what is expected.
    """
    signature = inspect.signature(function)

    @functools.wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        call = signature.bind(*args, **kwargs)
        given = {key: value for key, value in call.arguments.items() if key != "self"}
        made = call.arguments.get("self")
        name = function.__name__ if made is None else getattr(made, "name", type(made).__name__)
        values = validated(_model(function), given, f"{name}: ")
        call.arguments.update({key: getattr(values, key) for key in values.model_fields_set})
        return function(*call.args, **call.kwargs)

    return wrapper


def check_fields(instance: Any, where: str) -> None:
    """Refuse a dataclass whose fields do not match their annotations.

    Parameters
    ----------
    instance : dataclass
        Calls this in its ``__post_init__``; its fields get the annotated types, such as false for
        ``no`` and a tuple for a list.
    where : str
        Begins the message.

    Raises
    ------
    UserError
        If a field is invalid; the message has its name, its value and what is expected.
    """
    made_by: Callable[..., Any] = type(instance)
    values = validated(_model(made_by), vars(instance), f"{where}.")
    for name in values.model_fields_set:
        object.__setattr__(instance, name, getattr(values, name))


@functools.cache
def _model(function: Callable[..., Any]) -> type[BaseModel]:
    return arguments_model(function)


def arguments_model(
    function: Callable[..., Any],
    replaced: Mapping[str, Any] | None = None,
    left_out: tuple[str, ...] = (),
    **more: Any,
) -> type[BaseModel]:
    """Create a pydantic model of the arguments of a function or class.

    Parameters
    ----------
    function : callable
        Function or class; its annotations may contain pydantic's constraints.
    replaced : mapping of str to type, optional
        Annotations that replace the function's own.
    left_out : tuple of str
        Arguments that are not checked.
    **more : tuple of (type, object)
        Further fields, as `pydantic.create_model` takes them.

    Returns
    -------
    type of pydantic.BaseModel
        One field per argument, with the function's defaults.
    """
    source = function.__init__ if isinstance(function, type) else function  # type: ignore[misc]
    hints = get_type_hints(source, include_extras=True) | dict(replaced or {})
    factories = {
        field.name: field.default_factory()
        for field in (dataclasses.fields(function) if dataclasses.is_dataclass(function) else ())
        if field.default_factory is not dataclasses.MISSING
    }
    fields: dict[str, Any] = {}
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name in ("self", *left_out):
            continue
        default = factories.get(parameter.name, parameter.default)
        required = default is inspect.Parameter.empty
        fields[parameter.name] = (
            hints.get(parameter.name, Any),
            ... if required else default,
        )
    return create_model(function.__name__, __config__=CONFIG, **more, **fields)


def validated(model: type[BaseModel], values: Mapping[str, Any], where: str = "") -> BaseModel:
    """Check values, and convert them to the annotated types.

    Parameters
    ----------
    model : type of pydantic.BaseModel
        Model with the allowed types and ranges.
    values : mapping of str to object
        The given values.
    where : str
        Start of the message.

    Returns
    -------
    pydantic.BaseModel
        Values of the annotated types.

    Raises
    ------
    UserError
        If a value is invalid; the message has the first such key, its value and what is expected.
    """
    try:
        result = model.model_validate(values)
    except ValidationError as error:
        raise UserError(where + _message(model, values, error)) from None
    wrong = _truth_taken_for_number(values, result, ())
    if wrong is not None:
        raise UserError(where + _refusal(model, values, wrong))
    return result


def _message(model: type[BaseModel], values: Mapping[str, Any], error: ValidationError) -> str:
    first = error.errors(include_url=False, include_input=False)[0]
    location = first["loc"]
    path, _ = _found(values, location)
    if first["type"] == "extra_forbidden":
        known = [f.alias or n for n, f in _model_at(model, path[:-1]).model_fields.items()]
        nearest = get_close_matches(str(path[-1]), known, n=1, cutoff=0.0)
        parent = "".join(f"{part}." for part in path[:-1])
        hint = f"the closest is {parent}{nearest[0]}" if nearest else "none is expected here"
        return f"{_dotted(path)}: unknown key, {hint}"
    fields = _model_at(model, path).model_fields.items()
    missing = {field.alias or name for name, field in fields} & {location[-1]}
    if first["type"] == "missing" and missing:
        path = (*path, location[-1])
        return f"{_dotted(path)} is missing, expected {expected(_annotation_at(model, path))}"
    if first["type"] in ("value_error", "assertion_error"):
        said = str(first["msg"]).partition(", ")[2]
        return f"{_dotted(path)}: {said}" if path else said
    return _refusal(model, values, path)


def _refusal(model: type[BaseModel], values: Any, path: tuple[str | int, ...]) -> str:
    _, found = _found(values, path)
    wanted = expected(_annotation_at(model, path))
    return f"{_dotted(path) or 'configuration'} is {shown(found)}, expected {wanted}"


def _dotted(path: tuple[str | int, ...]) -> str:
    return ".".join(map(str, path))


def _found(values: Any, location: tuple[str | int, ...]) -> tuple[tuple[str | int, ...], Any]:
    """Follow a location of pydantic into the values, up to where names of union members begin."""
    path: list[str | int] = []
    for part in location:
        inside = (isinstance(values, Mapping) and part in values) or (
            isinstance(values, list | tuple) and isinstance(part, int) and part < len(values)
        )
        if not inside:
            break
        values = values[part]
        path.append(part)
    return tuple(path), values


def _annotation_at(model: Any, path: tuple[str | int, ...]) -> Any:
    annotation = model
    for part in path:
        annotation = _inner(annotation, part)
    return annotation


def _inner(annotation: Any, part: str | int) -> Any:
    for candidate in _alternatives(annotation):
        arguments = get_args(candidate)
        if isinstance(candidate, type) and issubclass(candidate, BaseModel):
            for name, field in candidate.model_fields.items():
                if part in (name, field.alias):
                    return Annotated[field.annotation, field]
        elif isinstance(part, int) and arguments:
            return arguments[0] if Ellipsis in arguments else arguments[part % len(arguments)]
        elif len(arguments) == 2:
            return arguments[1]
    return Any


def _alternatives(annotation: Any) -> list[Any]:
    """Members of a union, without constraints; for other annotations, the annotation itself."""
    if get_origin(annotation) is Annotated:
        return _alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [one for member in get_args(annotation) for one in _alternatives(member)]
    return [annotation]


def _model_at(model: type[BaseModel], path: tuple[str | int, ...]) -> type[BaseModel]:
    for candidate in _alternatives(_annotation_at(model, path)):
        if isinstance(candidate, type) and issubclass(candidate, BaseModel):
            return candidate
    return BaseModel


def _truth_taken_for_number(
    given: Any, result: Any, path: tuple[str | int, ...]
) -> tuple[str | int, ...] | None:
    """Find where true was accepted as 1: pydantic allows it, but here it is a mistake."""
    if isinstance(given, bool):
        return path if type(result) in (int, float) else None
    pairs: list[tuple[Any, Any, Any]] = []
    if isinstance(given, Mapping) and isinstance(result, BaseModel):
        pairs = [
            (field.alias or name, given[field.alias or name], getattr(result, name))
            for name, field in type(result).model_fields.items()
            if (field.alias or name) in given
        ]
    elif isinstance(given, Mapping) and isinstance(result, Mapping):
        pairs = [(key, value, result.get(key)) for key, value in given.items()]
    elif isinstance(given, list | tuple) and isinstance(result, list | tuple):
        pairs = list(zip(range(len(given)), given, result, strict=False))
    for key, value, of in pairs:
        wrong = _truth_taken_for_number(value, of, (*path, key))
        if wrong is not None:
            return wrong
    return None
