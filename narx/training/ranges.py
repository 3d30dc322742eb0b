"""Settings that are refused where they are made, each in one line."""

from math import inf

import numpy as np

from narx.errors import UserError


def whole(name: str, value: object, least: int, most: int) -> None:
    """Refuse what is not a whole number in a range.

    Parameters
    ----------
    name : str
        Of the setting.
    value : object
        As given.
    least, most : int
        Range, both included.

    Raises
    ------
    UserError
        If it is not.
    """
    is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not is_whole or not least <= int(value) <= most:  # type: ignore[call-overload]
        raise UserError(f"{name} is '{value}', expected a whole number from {least} to {most}")


def between(name: str, value: object, least: float, most: float = inf) -> None:
    """Refuse what is not a finite number in a range.

    Parameters
    ----------
    name : str
        Of the setting.
    value : object
        As given.
    least, most : float
        Range, both included.

    Raises
    ------
    UserError
        If it is not.
    """
    is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    number = float(value) if is_number else np.nan  # type: ignore[arg-type]
    if not np.isfinite(number) or not least <= number <= most:
        allowed = f"of at least {least:g}" if most == inf else f"from {least:g} to {most:g}"
        raise UserError(f"{name} is '{value}', expected a number {allowed}")


def yes_or_no(name: str, value: object) -> None:
    """Refuse what is neither true nor false.

    Parameters
    ----------
    name : str
        Of the setting.
    value : object
        As given.

    Raises
    ------
    UserError
        If it is not.
    """
    if not isinstance(value, bool):
        raise UserError(f"{name} is '{value}', expected true or false")


def one_of(name: str, value: object, allowed: tuple[str, ...]) -> None:
    """Refuse what is none of some names.

    Parameters
    ----------
    name : str
        Of the setting.
    value : object
        As given.
    allowed : tuple of str
        The names.

    Raises
    ------
    UserError
        If it is not.
    """
    if value not in allowed:
        raise UserError(f"{name} is '{value}', expected one of {', '.join(allowed)}")
