"""Spellings of units in files, and their factors to SI."""

import re
from typing import Literal

import numpy as np

from narx.recordings.trial import GRAVITY_M_S2

Quantity = Literal["time", "gyroscope", "accelerometer"]

# The first spelling of a unit is the suffix of the package's own column names; others are as
# `_plain` leaves them.
_SPELLINGS: dict[Quantity, dict[float, tuple[str, ...]]] = {
    "time": {
        1.0: ("s",),
        1e-3: ("ms", "msec", "msecs", "millis", "milliseconds"),
        1e-6: ("us", "usec", "usecs", "micros", "microseconds"),
        1e-9: ("ns", "nsec", "nsecs", "nanos", "nanoseconds"),
        60.0: ("min", "mins", "minute", "minutes"),
        3600.0: ("h", "hr", "hrs", "hour", "hours"),
        86400.0: ("d", "day", "days"),
    },
    "gyroscope": {
        1.0: ("rad_s", "rad/s", "rads", "radps"),
        np.pi / 180.0: ("deg_s", "deg/s", "dps", "degs", "degps", "d/s"),
        np.pi / 180e3: ("mdps", "mdeg/s", "mdeg_s"),
        1e-3: ("mrad_s", "mrad/s", "mrads"),
        np.pi / 30.0: ("rpm", "rev/min", "rev_min", "1/min", "r/min"),
        2.0 * np.pi: ("rev_s", "rev/s", "rps", "turns/s"),
    },
    "accelerometer": {
        1.0: ("m_s2", "m/s2", "m/s/s", "m/(s2)", "m/(sec2)", "ms-2", "mps2"),
        GRAVITY_M_S2: ("g", "gs"),
        1e-3 * GRAVITY_M_S2: ("mg", "mgs"),
        1e-2: ("cm_s2", "cm/s2", "gal"),
        1e-3: ("mm_s2", "mm/s2"),
    },
}
_PLAIN = (
    (r"[\u00b5\u03bc]", "u"),
    (r"[\u00b0\u00ba]", "deg"),
    (r"[\u207b\u2212]", "-"),
    ("\u00b9", "1"),
    ("\u00b2", "2"),
    (r"\bper\b", "/"),
    (r"\^|\*\*", ""),
    (r"\*+$", ""),
    (r"[*\u00b7\u22c5.]+", " "),
    (r"\b(seconds?|secs?)\b", "s"),
    (r"(?<=[_/])(seconds?|secs?)", "s"),
    (r"radians?", "rad"),
    (r"degrees?", "deg"),
    (r"\b(metres?|meters?)\b", "m"),
    (r"\s*/\s*", "/"),
    (r"\s+s-([12])$", lambda match: "/s" + match[1].replace("1", "")),
)


def factor_to_si(quantity: Quantity, unit: str) -> float | None:
    """Look up the factor from a unit to SI.

    Parameters
    ----------
    quantity : {"time", "gyroscope", "accelerometer"}
        What was measured.
    unit : str
        As a header or a table of channels writes it, with or without brackets around it.

    Returns
    -------
    float or None
        To s, rad/s or m/s^2; None for an unknown unit.
    """
    bare = _plain(_without_brackets(unit))
    for factor, spellings in _SPELLINGS[quantity].items():
        if bare in spellings:
            return factor
    return None


def unit_names(quantity: Quantity) -> list[str]:
    """List the units of a quantity, one spelling each, for messages.

    Parameters
    ----------
    quantity : {"time", "gyroscope", "accelerometer"}
        What was measured.

    Returns
    -------
    list of str
        As this package's own column names end.
    """
    return [spellings[0] for spellings in _SPELLINGS[quantity].values()]


def is_unit(text: str) -> bool:
    """Return whether a cell is a unit and not a name or a value.

    Parameters
    ----------
    text : str
        Cell of a table.

    Returns
    -------
    bool
        True for a unit of any quantity, and for ``-`` or nothing where there is none.
    """
    if _without_brackets(text) in ("", "-", "1", "n/a"):
        return True
    return any(factor_to_si(quantity, text) is not None for quantity in _SPELLINGS)


def _plain(unit: str) -> str:
    """Reduce spellings: ``rad·s⁻¹``, ``radians per second`` and ``rad / sec`` are ``rad/s``."""
    text = unit.casefold()
    for pattern, plain in _PLAIN:
        text = re.sub(pattern, plain, text)
    return text.strip()


def _without_brackets(text: str) -> str:
    enclosed = re.fullmatch(r"\[(.*)\]|\((.*)\)", text.strip())
    return (enclosed[1] or enclosed[2] or "" if enclosed else text).strip()
