"""Meaning of a table's columns: a small description per device, matched to the names found.

A pattern is a column's name with ``{axis}`` for x, y, z, ``{unit}`` for any known unit, ``{sep}``
for a blank, ``_``, ``-``, ``.`` or nothing, and ``{any}`` for anything; case is ignored. Names may
also be listed, with the unit given separately.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field

from narx.errors import UserError
from narx.settings import check_fields

AXES = ("x", "y", "z")
# the time to find that a name does not match grows with the power of their number
_MAX_ANY = 3


@dataclass(frozen=True)
class Columns:
    """Columns of one quantity.

    Parameters
    ----------
    names : str or sequence of str
        Pattern, or the names themselves in the order x, y, z.
    unit : str, optional
        Unit of the numbers, if the pattern has no ``{unit}`` and there is no units row.
    sign : int or sequence of int
        +1 or -1, for all axes or each, for a device with reversed axes.
    wraps : int, optional
        Period of a counter that wraps around to zero, at least 2.
    unit_below : bool
        Whether the columns are these only if there is a row of units.

    Raises
    ------
    UserError
        If a field is not of that form.
    """

    names: str | Sequence[str]
    unit: str | None = None
    sign: int | Sequence[int] = 1
    wraps: Annotated[int, Field(ge=2)] | None = None
    unit_below: bool = False

    def __post_init__(self) -> None:
        names = [self.names] if isinstance(self.names, str) else self.names
        if not isinstance(names, Sequence) or not all(isinstance(one, str) for one in names):
            raise UserError(
                f"columns: names are {names}, expected a name, a pattern or three names"
            )
        for name in names:
            if name.count("{unit}") > 1 or name.count("{any}") > _MAX_ANY:
                raise UserError(
                    f"columns: name is '{name}', expected {{unit}} at most once and {{any}} at "
                    f"most {_MAX_ANY} times"
                )
        signs = [self.sign] if isinstance(self.sign, int) else self.sign
        if not isinstance(signs, Sequence) or len(signs) not in (1, 3) or {*signs} - {1, -1}:
            raise UserError(f"columns: sign is {self.sign}, expected 1 or -1, or three of them")
        check_fields(self, "columns")


@dataclass(frozen=True)
class Opposite:
    """Recordings of an app in which the specific force has the opposite sign.

    Parameters
    ----------
    file : str
        Table with one row about the recording.
    values : mapping of str to str
        Columns of that table and the values of such recordings; a column that is missing, in files
        of earlier versions of the app, fits as well.
    """

    file: str
    values: Mapping[str, str]

    def fits(self, row: Mapping[str, str]) -> bool:
        """Return whether a recording is one of these.

        Parameters
        ----------
        row : mapping of str to str
            The row of the table, by column; empty if there is no table.

        Returns
        -------
        bool
            True if all columns that exist have the values, and at least one exists.
        """
        known = {name: value for name, value in self.values.items() if name in row}
        return bool(known) and all(
            row[name].strip().casefold() == value.casefold() for name, value in known.items()
        )


@dataclass(frozen=True)
class Layout:
    """Names of a device's columns; of several alternatives, the first found in a table is used.

    Parameters
    ----------
    name : str
        Name of the device or program, for messages.
    time, gyroscope : tuple of Columns
        Sampling times and angular rate.
    accelerometer : tuple of Columns
        Specific force (at rest it points up).
    comment : str, optional
        Regular expression that a comment above the header must match; its first group is the rate
        in Hz, if time is a count of ``packets``.
    files : mapping of str to tuple of str
        ``gyroscope`` and ``accelerometer`` to file names, if each sensor has its own file; empty
        for a device that writes one table.
    opposite : Opposite, optional
        Recordings whose accelerometer has the opposite sign.

    Raises
    ------
    UserError
        If a field is not of that form.
    """

    name: str
    time: tuple[Columns, ...]
    gyroscope: tuple[Columns, ...]
    accelerometer: tuple[Columns, ...] = ()
    comment: str | None = None
    files: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    opposite: Opposite | None = None

    def __post_init__(self) -> None:
        check_fields(self, self.name)
        try:
            groups = re.compile(self.comment or "").groups
        except re.error as error:
            raise UserError(
                f"{self.name}: comment is '{self.comment}', expected a regular expression ({error})"
            ) from None
        if not groups and any(one.unit == PACKETS for one in self.time):
            raise UserError(
                f"{self.name}: comment is '{self.comment}', expected a group in it that is the "
                "rate of the packets, such as Rate: ([\\d.]+)"
            )


PACKETS = "packets"
# a column of dates and times has no unit
CALENDAR = "calendar"
_TIMES = ("time", "timestamp", "timestamps", "datetime", "date_time", "date time")


_IN_NAME = ("_{unit}", " ({unit})", " [{unit}]", "({unit})", "[{unit}]")
# other words for the quantities, in the languages of users' spreadsheets
_OTHER_TIMES = ("zeit", "temps", "tiempo", "tempo", "tijd", "tid", "czas", "elapsed", "t")
_OTHER_RATES = (
    "angular{sep}velocity", "angular{sep}rate", "ang{sep}vel", "rotation{sep}rate", "omega",
    "gyros", "gyroskop", "drehrate", "winkelgeschwindigkeit", "gyromètre", "vitesse{sep}angulaire",
    "giroscopio", "giróscopo", "giroscópio", "velocidad{sep}angular", "velocidade{sep}angular",
    "velocità{sep}angolare", "gyroscoop", "hoeksnelheid", "żyroskop", "prędkość{sep}kątowa",
)  # fmt: skip
_OTHER_FORCES = (
    "acceleration", "specific{sep}force", "beschleunigung", "accéléromètre", "accélération",
    "acelerómetro", "aceleración", "acelerômetro", "aceleração", "accelerometro", "accelerazione",
    "versnelling", "przyspieszenie",
)  # fmt: skip


def _own(name: str, *others: str) -> tuple[Columns, ...]:
    """Spellings of a name of the package: unit after it, in brackets, or in the units row.

    Other names need the unit, since devices use them for a unit of their own.
    """
    full = [Columns(name + unit) for unit in (*_IN_NAME, "")]
    named = [Columns(other + unit) for other in others for unit in _IN_NAME]
    return (*full, *named, *(Columns(other, unit_below=True) for other in others))


def _along(*names: str) -> tuple[str, ...]:
    return tuple(name + "{sep}{axis}" for name in names)


OWN = Layout(
    "narx",
    (
        *(columns for columns in _own("time", *_OTHER_TIMES) if columns.names != "time"),
        *(columns for columns in _own("timestamp") if "{unit}" in columns.names),
        Columns("seconds", unit="s"),
        Columns("milliseconds", unit="ms"),
        *(Columns(name, unit=CALENDAR) for name in _TIMES),
    ),
    _own(
        "gyroscope_{axis}", *_along("gyroscope", "gyro", "gyr"), "g{axis}", "w{axis}",
        *_along(*_OTHER_RATES),
    ),
    _own(
        "accelerometer_{axis}", *_along("accelerometer", "accel", "acc"), "a{axis}",
        *_along(*_OTHER_FORCES),
    ),
)  # fmt: skip
