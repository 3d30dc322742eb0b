"""Checks of method parameters, so that a wrong value gives one clear line."""

import importlib
from collections.abc import Sequence
from types import ModuleType

import numpy as np

from narx.errors import MethodNotApplicableError, UserError
from narx.kinematics.segment_angles import AXES


def positive(method: str, name: str, value: float) -> float:
    """Return a parameter that must be positive and finite.

    Parameters
    ----------
    method, name : str
        Names of the method and of its parameter, for the message.
    value : float
        Value to check.

    Returns
    -------
    float
        The same value.

    Raises
    ------
    UserError
        If it is not a positive, finite number.
    """
    if not (np.isfinite(value) and value > 0):
        raise UserError(f"method {method}: {name} is {value}, expected a positive number")
    return float(value)


def one_of(method: str, name: str, value: str, allowed: Sequence[str]) -> str:
    """Return a parameter that must be one of a few words.

    Parameters
    ----------
    method, name : str
        Names of the method and of its parameter, for the message.
    value : str
        Value to check.
    allowed : sequence of str
        Allowed values.

    Returns
    -------
    str
        The same value.

    Raises
    ------
    UserError
        If it is none of them.
    """
    if value not in allowed:
        raise UserError(
            f"method {method}: {name} is '{value}', expected one of {', '.join(allowed)}"
        )
    return value


def tilt_axes(method: str, axes: Sequence[str]) -> list[int]:
    """Return the columns of the tilt axes that a method estimates.

    Parameters
    ----------
    method : str
        Name of the method, for the message.
    axes : sequence of str
        One or both of ``sagittal`` and ``frontal``: an accelerometer observes no other.

    Returns
    -------
    list of int
        Columns in the order of `narx.kinematics.segment_angles.AXES`.

    Raises
    ------
    UserError
        If it is empty or names another axis.
    """
    if not axes or not set(axes) <= {"sagittal", "frontal"}:
        raise UserError(
            f"method {method}: axes is {list(axes)}, expected sagittal, frontal or both"
        )
    return [column for column, axis in enumerate(AXES) if axis in axes]


def both_if_coupled(method: str, columns: list[int], coupled: bool) -> list[int]:
    """Refuse coupled axes if one of them is not estimated.

    Parameters
    ----------
    method : str
        Name of the method, for the message.
    columns : list of int
        From `tilt_axes`.
    coupled : bool
        Whether the axes are coupled.

    Returns
    -------
    list of int
        The same columns.

    Raises
    ------
    UserError
        If the axes are coupled and one of them is missing.
    """
    if coupled and len(columns) < 2:
        raise UserError(f"method {method}: coupled=true needs axes [sagittal, frontal]")
    return columns


def optional_library(method: str, package: str) -> ModuleType:
    """Import a library that only some methods need.

    Parameters
    ----------
    method : str
        Name of the method, for the message.
    package : str
        Name of the package, the same on the package index and in `import`.

    Returns
    -------
    module
        The library.

    Raises
    ------
    MethodNotApplicableError
        If it is not installed; the message gives the command to install it.
    """
    try:
        return importlib.import_module(package)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.split(".")[0] != package:
            raise
        raise MethodNotApplicableError(
            f"method {method} needs the package '{package}', which is not installed: "
            "pip install 'narx-orientation[filters]'"
        ) from error
