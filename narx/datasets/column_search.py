"""Find the columns named in a description, and determine their unit."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

from narx.datasets.layout import AXES, CALENDAR, PACKETS, Columns
from narx.datasets.units import Quantity, factor_to_si, unit_names
from narx.errors import RecordingError, UserError

# a row of units may show the form of dates, such as yyyy/mm/dd hh:mm:ss.000
_DATE_FORMAT = re.compile(r"(y{2,4}|d{1,2}|m{1,2}|h{1,2})[-/.: ](y|d|m)", re.IGNORECASE)
_OTHER_NAMES = (
    "other names are given as columns={time: {names: T, unit: s}, gyroscope: {names: [WX, WY, WZ], "
    "unit: deg/s}, accelerometer: {names: [AX, AY, AZ], unit: g}}"
)


@dataclass(frozen=True)
class Found:
    """Columns of one quantity in one table.

    Parameters
    ----------
    indices : tuple of int
        From 0; one, or three for x, y, z.
    factors : tuple of float
        To SI, sign included; NaN for a column that must hold dates and times.
    wraps : int, optional
        As in the description.
    also : Found, optional
        The same quantity in another unit, if the table has it twice.
    """

    indices: tuple[int, ...]
    factors: tuple[float, ...]
    wraps: int | None = None
    also: "Found | None" = None


def find(
    columns: Columns,
    quantity: Quantity,
    names: Sequence[str],
    units: Sequence[str] | None,
    where: str,
) -> Found | None:
    """Find the columns of a quantity.

    Parameters
    ----------
    columns : Columns
        Columns to find.
    quantity : {"time", "gyroscope", "accelerometer"}
        Quantity in the columns.
    names : sequence of str
        Names of all columns.
    units : sequence of str, optional
        Units row of the table.
    where : str
        File, for messages.

    Returns
    -------
    Found or None
        None if no column has such a name.

    Raises
    ------
    RecordingError
        If some axes are missing, a name occurs twice, or the unit is unknown or contradicted by
        the units row.
    """
    if columns.unit_below and units is None:
        return None
    axes: Sequence[str] = ("",) if quantity == "time" else AXES
    matches = [_matches(columns, axis, names) for axis in axes]
    if not any(matches):
        return None
    by_unit: dict[str, list[list[int]]] = {}
    for k, matched in enumerate(matches):
        for index, unit in matched:
            by_unit.setdefault(unit.casefold(), [[] for _ in axes])[k].append(index)
    known = {
        unit: found
        for unit, found in by_unit.items()
        if not unit or _factor_of(quantity, unit) is not None
    }
    if not known:
        return None
    complete = {unit: found for unit, found in known.items() if all(found)}
    own: dict[str, Found] = {}
    for unit, found in (complete or known).items():
        own[unit] = _found(columns, quantity, unit, found, names, units, where)
    first, *more = own.values()
    return replace(first, also=more[0]) if more else first


def _found(
    columns: Columns,
    quantity: Quantity,
    unit: str,
    found: Sequence[Sequence[int]],
    names: Sequence[str],
    units: Sequence[str] | None,
    where: str,
) -> Found:
    """Check that each axis has one column."""
    axes: Sequence[str] = ("",) if quantity == "time" else AXES
    for k, of_axis in enumerate(found):
        if not of_axis:
            present = names[next(i[0] for i in found if i)]
            missing = _spelled(columns, axes[k], unit)
            raise RecordingError(
                f"{where}: no column '{missing}' beside '{present}'; found {_listed(names)}; "
                f"{_OTHER_NAMES}"
            )
        if len(of_axis) > 1:
            raise RecordingError(
                f"{where}: column {names[of_axis[0]]} occurs {len(of_axis)} times (columns "
                f"{', '.join(str(index + 1) for index in of_axis)}), expected once"
            )
    indices = tuple(of_axis[0] for of_axis in found)
    if len({*indices}) < len(indices):
        raise RecordingError(
            f"{where}: columns {', '.join(names[index] for index in indices)} are x, y and z, "
            "expected three different ones"
        )
    factor = _factor(columns, quantity, unit, indices, names, units, where)
    signs = [columns.sign] if isinstance(columns.sign, int) else list(columns.sign)
    signs = signs * len(axes) if len(signs) == 1 else signs
    return Found(indices, tuple(factor * sign for sign in signs[: len(axes)]), columns.wraps)


def require(
    alternatives: Sequence[Columns],
    quantity: Quantity,
    names: Sequence[str],
    units: Sequence[str] | None,
    where: str,
    hint: str = _OTHER_NAMES,
) -> Found:
    """Find the columns of a required quantity.

    Parameters
    ----------
    alternatives, quantity, names, units, where
        As for `first_found`.
    hint : str
        How other names are given, the end of the message.

    Returns
    -------
    Found
        The columns.

    Raises
    ------
    RecordingError
        As `find`, and if there are none.
    """
    found = first_found(alternatives, quantity, names, units, where)
    if found is None:
        axis = "" if quantity == "time" else "x"
        spelled = [_spelled(alternatives[0], axis, unit) for unit in unit_names(quantity)[:2]]
        shown = spelled[:1] if quantity == "time" else spelled
        expected = " or ".join(f"'{name}'" for name in dict.fromkeys(shown))
        more = "" if quantity == "time" else " (and y, z)"
        raise RecordingError(
            f"{where}: no column {expected}{more}; found {_listed(names) or 'nothing'}; {hint}"
        )
    return found


def _matches(columns: Columns, axis: str, names: Sequence[str]) -> list[tuple[int, str]]:
    """Columns with the name of an axis, and the unit in that name."""
    if isinstance(columns.names, str):
        pattern = _pattern(columns.names, axis)
    else:
        listed = list(columns.names)
        if axis and len(listed) != len(AXES):
            raise UserError(f"columns are {listed}, expected three names, for x, y and z")
        pattern = re.compile(re.escape(listed[AXES.index(axis) if axis else 0]), re.IGNORECASE)
    found = []
    for index, name in enumerate(names):
        if match := pattern.fullmatch(name.strip()):
            found.append((index, match.groupdict().get("unit") or ""))
    return found


@cache
def _pattern(names: str, axis: str) -> re.Pattern[str]:
    pattern = re.escape(names).replace(r"\{axis\}", re.escape(axis))
    pattern = pattern.replace(r"\{unit\}", "(?P<unit>.+?)").replace(r"\{any\}", ".*")
    pattern = pattern.replace(r"\{sep\}", "[_ .-]?")
    return re.compile(pattern, re.IGNORECASE)


def _spelled(columns: Columns, axis: str, unit: str) -> str:
    if not isinstance(columns.names, str):
        return str(columns.names[AXES.index(axis) if axis else 0])
    name = columns.names.replace("{sep}", "_")
    return name.replace("{axis}", axis).replace("{unit}", unit)


def _listed(names: Sequence[str]) -> str:
    shown = [name for name in names if name]
    return ", ".join(shown[:20]) + (f" and {len(shown) - 20} more" if len(shown) > 20 else "")


def _factor(
    columns: Columns,
    quantity: Quantity,
    in_name: str,
    indices: Sequence[int],
    names: Sequence[str],
    units: Sequence[str] | None,
    where: str,
) -> float:
    """Determine the unit from the name, the description and the units row."""
    below = {units[index].strip() for index in indices} - {"", "-"} if units else set()
    own = in_name or columns.unit or ""
    replaced = own == CALENDAR or any(map(_DATE_FORMAT.match, below))
    given = {"" if replaced and below else own, *below} - {""}
    factors = {unit: _factor_of(quantity, unit) for unit in given}
    unknown = [unit for unit, factor in factors.items() if factor is None]
    first = names[indices[0]]
    if unknown or not factors:
        raise RecordingError(
            f"{where}: column {first} has "
            + (f"unit '{unknown[0]}'" if unknown else "no unit")
            + f", expected one of {', '.join(unit_names(quantity))}"
        )
    if len(set(factors.values())) > 1:
        raise RecordingError(f"{where}: column {first} has units {' and '.join(sorted(given))}")
    factor = next(iter(factors.values()))
    assert factor is not None
    return factor


def _factor_of(quantity: Quantity, unit: str) -> float | None:
    if quantity == "time" and unit == PACKETS:
        return 1.0
    if quantity == "time" and (unit == CALENDAR or _DATE_FORMAT.match(unit)):
        return math.nan
    return factor_to_si(quantity, unit)


def first_found(
    alternatives: Sequence[Columns],
    quantity: Quantity,
    names: Sequence[str],
    units: Sequence[str] | None,
    where: str,
) -> Found | None:
    """Find the columns of the first alternative present in a table.

    Parameters
    ----------
    alternatives : sequence of Columns
        In order of preference.
    quantity, names, units, where
        As for `find`.

    Returns
    -------
    Found or None
        None if none is present.
    """
    found = (find(columns, quantity, names, units, where) for columns in alternatives)
    return next((one for one in found if one is not None), None)
