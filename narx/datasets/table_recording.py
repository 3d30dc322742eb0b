"""Conversion of a table with named columns to a sensor's samples, by a device's description."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from narx.datasets.column_search import Found, first_found, require
from narx.datasets.device_layouts import recognised
from narx.datasets.layout import OWN, PACKETS, Layout
from narx.errors import RecordingError
from narx.recordings.one_clock import at_gyroscope_times
from narx.recordings.stamps import checked_rate_hz, sampling_times
from narx.recordings.trial import ImuRecording
from narx.types import FloatArray

# no sensor measures as much, and its squares still fit into a float
_BEYOND_SENSORS = 1e30
# two columns of one quantity in different units may be rounded
_SAME = 0.01
# times without a unit: the rates of inertial sensors span less than a factor of 1000
_RATES_HZ = (8.0, 4000.0)
_TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "days": 86400.0}


class Table(Protocol):
    """Named columns of a file, whatever its format."""

    @property
    def path(self) -> Path:
        """The file, for messages."""

    @property
    def names(self) -> tuple[str, ...]:
        """One name per column."""

    @property
    def units(self) -> tuple[str, ...] | None:
        """Units of the columns, if the file has a row of units."""

    @property
    def comments(self) -> tuple[str, ...]:
        """Lines above the header."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Peculiarities of the file, as text."""

    def numbers(self, column: int) -> FloatArray:
        """Return a column of numbers.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        ndarray, shape (N,)
            NaN where missing.
        """

    def seconds(self, column: int) -> tuple[FloatArray, tuple[str, ...]] | None:
        """Return a column of dates and times as seconds from the first.

        Parameters
        ----------
        column : int
            From 0.

        Returns
        -------
        tuple of ndarray and tuple of str, or None
            Seconds and a note; None for a column of numbers.
        """


@dataclass(frozen=True)
class Sensor:
    """Samples of one sensor.

    Parameters
    ----------
    time_s : ndarray, shape (N,)
        Increasing, s.
    values : ndarray, shape (N, 3)
        SI; NaN where missing.
    notes : tuple of str
        Processing applied, as text.
    """

    time_s: FloatArray
    values: FloatArray
    notes: tuple[str, ...]


def sensor_from(
    table: Table, layout: Layout, quantity: Literal["gyroscope", "accelerometer"]
) -> Sensor:
    """Read one sensor from its own table.

    Parameters
    ----------
    table : Table
        Its file.
    layout : Layout
        Names of its columns.
    quantity : {"gyroscope", "accelerometer"}
        Which sensor.

    Returns
    -------
    Sensor
        Its samples.

    Raises
    ------
    RecordingError
        If a column is missing, or time does not increase.
    """
    where = str(table.path)
    alternatives = layout.gyroscope if quantity == "gyroscope" else layout.accelerometer
    found = require(alternatives, quantity, table.names, table.units, where)
    stamps, notes = _stamps(table, layout)
    values = _vectors(table, found)
    times = sampling_times(stamps, values, where)
    return Sensor(times.time_s, values[times.rows], (*table.notes, *notes, *times.notes))


def recording_from(table: Table, layout: Layout | None, segment: str) -> ImuRecording:
    """Read gyroscope and accelerometer from one table.

    Parameters
    ----------
    table : Table
        The file.
    layout : Layout, optional
        Names of its columns; None detects the device from them.
    segment : str
        Segment that carries the sensor.

    Returns
    -------
    ImuRecording
        In SI; the accelerometer is NaN throughout if there is none.

    Raises
    ------
    RecordingError
        If a column is missing or duplicated, has an unknown unit or not the same unit as its
        neighbours, a cell is not a number, or time does not increase.
    """
    where, names, units = str(table.path), table.names, table.units
    if layout is None:
        layout = recognised(names, units, "\n".join(table.comments), where)
    device = [] if layout is OWN else [f"columns as of {layout.name}"]
    if not layout.accelerometer:
        unused = [name for name in names if re.match("acc", name, re.I)]
        if unused:
            device.append(f"no accelerometer in {layout.name}, {', '.join(unused)} not used")
    stamps, notes = _stamps(table, layout)
    gyroscope = _vectors(table, require(layout.gyroscope, "gyroscope", names, units, where))
    found = first_found(layout.accelerometer, "accelerometer", names, units, where)
    if (
        layout.accelerometer
        and found is None
        and any(re.match("accelerometer[_ ]", name, re.I) for name in names)
    ):
        found = require(layout.accelerometer, "accelerometer", names, units, where)
    force = np.full_like(gyroscope, np.nan) if found is None else _vectors(table, found)
    if len(stamps) == 0:
        raise RecordingError(f"{where}: no data, expected samples")
    times = sampling_times(stamps, np.hstack([gyroscope, force]), where)
    return at_gyroscope_times(
        ImuRecording(
            segment,
            times.time_s,
            gyroscope[times.rows],
            force[times.rows],
            notes=(*device, *table.notes, *notes, *times.notes),
        )
    )


def stamps_from(table: Table, layout: Layout | None) -> FloatArray:
    """Read the time stamps alone.

    Parameters
    ----------
    table : Table
        The file.
    layout : Layout, optional
        Names of its columns; None detects the device from them.

    Returns
    -------
    ndarray, shape (N,)
        As in the file, s.

    Raises
    ------
    RecordingError
        If the column is missing, or a stamp is.
    """
    where = str(table.path)
    if layout is None:
        layout = recognised(table.names, table.units, "\n".join(table.comments), where)
    stamps, _ = _stamps(table, layout)
    if not len(stamps) or not np.isfinite(stamps).all():
        raise RecordingError(f"{where}: no time stamps, or some are missing")
    return stamps


def _vectors(table: Table, found: Found) -> FloatArray:
    columns = []
    for index, factor in zip(found.indices, found.factors, strict=True):
        values = table.numbers(index)
        infinite = np.flatnonzero(np.isinf(values))
        if infinite.size:
            raise RecordingError(
                f"{table.path}: column {table.names[index]}, data row {infinite[0] + 1}: found "
                f"{values[infinite[0]]:g}, expected a finite number"
            )
        columns.append(np.clip(values, -_BEYOND_SENSORS, _BEYOND_SENSORS) * factor)
    vectors = np.column_stack(columns)
    if found.also is not None:
        tolerance = _SAME * float(np.nanmax(np.abs(vectors), initial=0.0))
        other = _vectors(table, found.also)
        if not np.allclose(vectors, other, atol=tolerance, equal_nan=True):
            both = " and ".join(table.names[one.indices[0]] for one in (found, found.also))
            raise RecordingError(
                f"{table.path}: columns {both} disagree; expected one of them, or columns=..."
            )
    return vectors


def _stamps(table: Table, layout: Layout) -> tuple[FloatArray, tuple[str, ...]]:
    """Stamps in s; calendar times relative to the first, packets at the rate given in a comment."""
    where = str(table.path)
    found = require(layout.time, "time", table.names, table.units, where)
    column = found.indices[0]
    calendar = table.seconds(column)
    if calendar is not None:
        return calendar
    stamps = table.numbers(column)
    if np.isnan(found.factors[0]):
        return _in_likely_unit(stamps, table.names[column], where)
    if found.wraps is not None:
        stamps = _unwrapped(stamps, found.wraps)
    stamps = stamps * found.factors[0]
    if found.also is not None and np.isfinite(found.also.factors[0]):
        other = table.numbers(found.also.indices[0]) * found.also.factors[0]
        durations = [float(one[-1] - one[0]) if len(one) else 0.0 for one in (stamps, other)]
        if abs(durations[1] - durations[0]) > _SAME * durations[0]:
            names = " and ".join(table.names[one.indices[0]] for one in (found, found.also))
            raise RecordingError(
                f"{where}: columns {names} last {durations[0]:g} and {durations[1]:g} s; expected "
                "one of them, or columns=..."
            )
    if layout.time[0].unit == PACKETS:
        match = re.search(layout.comment or "", "\n".join(table.comments))
        rate = checked_rate_hz(match[1] if match else None, f"{where}: rate in the comments")
        stamps = (stamps - stamps[0]) / rate
    return stamps, ()


def _in_likely_unit(
    stamps: FloatArray, name: str, where: str
) -> tuple[FloatArray, tuple[str, ...]]:
    """Convert times without a unit, by the only unit that gives the rate of an inertial sensor."""
    step = float(stamps[-1] - stamps[0]) / max(1, len(stamps) - 1) if len(stamps) else np.nan
    for unit, factor in _TIME_UNITS.items():
        if step > 0 and _RATES_HZ[0] <= 1.0 / (step * factor) < _RATES_HZ[1]:
            note = f"column {name} has no unit: taken as {unit}, {1.0 / (step * factor):.4g} Hz"
            return stamps * factor, (note,)
    raise RecordingError(
        f"{where}: column {name} has numbers without a unit, which are {step:g} apart; expected a "
        "name such as time_s or time_ms, or dates and times"
    )


def _unwrapped(counter: FloatArray, wraps: int) -> FloatArray:
    """Unwrap a counter that wraps around to zero."""
    steps = np.diff(counter)
    return counter + np.r_[0.0, np.cumsum(steps < -0.5 * wraps)] * wraps
