"""Sections with a `_target_`: their keys are the parameters of that class or function."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from hydra.utils import get_object
from pydantic import BaseModel, Field, create_model

from narx.errors import UserError
from narx.settings.checked import CONFIG, arguments_model
from narx.settings.wording import shown


@dataclass(frozen=True)
class Component:
    """Marks a field of a schema that `hydra.utils.instantiate` turns into an object.

    Parameters
    ----------
    kind : type or None
        Class or protocol of that object; None for a function.
    called_with : tuple of str
        Arguments that the program passes when it calls that function.
    """

    kind: type | None
    called_with: tuple[str, ...] = ()


@dataclass(frozen=True)
class Components:
    """Marks a field with such sections by name, and possibly plain values beside them.

    Parameters
    ----------
    kind : type
        Class or protocol of their objects.
    beside : tuple of (str, type) pairs
        Names and types of the plain values.
    optional : bool
        Whether there may be no section.
    """

    kind: type
    beside: tuple[tuple[str, Any], ...] = ()
    optional: bool = False


def schema_for(schema: type[BaseModel], values: Mapping[str, Any]) -> type[BaseModel]:
    """Complete a command's schema with the parameters of the classes in its configuration.

    Parameters
    ----------
    schema : type of pydantic.BaseModel
        Schema whose component fields are marked.
    values : mapping of str to object
        The configuration; its `_target_` values name the classes.

    Returns
    -------
    type of pydantic.BaseModel
        Schema of every key at all levels.

    Raises
    ------
    UserError
        If a `_target_` is missing, cannot be imported or is of another kind.
    """
    fields: dict[str, Any] = {}
    for name, field in schema.model_fields.items():
        for mark in field.metadata:
            value = values.get(name)
            optional = type(None) in get_args(field.annotation)
            if isinstance(mark, Component) and not (optional and value is None):
                fields[name] = _component_model(mark, value, name), ...
            if isinstance(mark, Components) and not (mark.optional and not value):
                fields[name] = _components_model(mark, value, name), ...
    return create_model(schema.__name__, __base__=schema, **fields) if fields else schema


def _components_model(mark: Components, value: object, path: str) -> type[BaseModel]:
    if not isinstance(value, Mapping):
        raise UserError(f"{path} is {shown(value)}, expected sections by name")
    plain = dict(mark.beside)
    fields: dict[str, Any] = {
        str(name): (_component_model(Component(mark.kind), one, f"{path}.{name}"), ...)
        for name, one in value.items()
        if name not in plain
    }
    if not fields:
        raise UserError(f"{path} is empty, expected at least one section")
    fields |= {name: (annotation, ...) for name, annotation in mark.beside}
    return create_model(path, __config__=CONFIG, **fields)


def _component_model(mark: Component, value: object, path: str) -> type[BaseModel]:
    if not isinstance(value, Mapping):
        raise UserError(f"{path} is {shown(value)}, expected a section with a _target_")
    if "_target_" not in value:
        raise UserError(f"{path}._target_ is missing, expected a class such as the default's")
    target = _located(value["_target_"], mark, f"{path}._target_")
    # pydantic's fields must not begin with an underscore, hence the alias
    more: dict[str, Any] = {"target_": (str, Field(alias="_target_"))}
    if mark.kind is None:
        more["partial_"] = (Literal[True], Field(alias="_partial_"))
    replaced = {
        name: _component_model(Component(kind), value[name], f"{path}.{name}")
        for name, kind in _component_arguments(target).items()
        if value.get(name) is not None
    }
    return arguments_model(target, replaced, mark.called_with, **more)


def _located(target: object, mark: Component, path: str) -> Callable[..., Any]:
    wanted = "a function of a split" if mark.kind is None else f"a {mark.kind.__name__}"
    refusal = f"{path} is {shown(target)}, expected the import path of {wanted}"
    if not isinstance(target, str):
        raise UserError(refusal)
    try:
        found = get_object(target)
    except Exception as error:
        raise UserError(f"{refusal} ({type(error).__name__})") from error
    if not _is_of_kind(found, mark):
        raise UserError(refusal)
    return found


def _is_of_kind(found: object, mark: Component) -> bool:
    if mark.kind is None:
        return inspect.isfunction(found) and set(mark.called_with) <= set(
            inspect.signature(found).parameters
        )
    if not isinstance(found, type) or inspect.isabstract(found):
        return False
    if getattr(mark.kind, "_is_protocol", False):
        return all(hasattr(found, name) for name in vars(mark.kind) if not name.startswith("_"))
    return issubclass(found, mark.kind)


def _component_arguments(target: Callable[..., Any]) -> dict[str, type]:
    """Arguments of a class that are objects of this package, made from their own sections."""
    found = {}
    for name, field in arguments_model(target).model_fields.items():
        kinds = [kind for kind in (field.annotation, *get_args(field.annotation)) if kind]
        ours = [k for k in kinds if isinstance(k, type) and k.__module__.startswith("narx.")]
        # the class itself checks arguments that are given as plain values
        if ours and not any(get_origin(kind) is Mapping for kind in kinds):
            found[name] = ours[0]
    return found
