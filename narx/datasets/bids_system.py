"""One tracking system of a Motion-BIDS trial: its channels by tracked point, in SI."""

import re
from pathlib import Path

import numpy as np

from narx.datasets.bids_files import channel_table, sidecar
from narx.datasets.text_table import read_numbers
from narx.datasets.units import Quantity, factor_to_si, unit_names
from narx.errors import RecordingError, UserError
from narx.recordings.stamps import checked_rate_hz, sampling_times
from narx.types import FloatArray

VECTOR = ("x", "y", "z")
QUATERNION = ("quat_w", "quat_x", "quat_y", "quat_z")
_QUANTITIES: dict[str, Quantity] = {
    "GYRO": "gyroscope",
    "ACCEL": "accelerometer",
    "LATENCY": "time",
}


class TrackingSystem:
    """One ``*_motion.tsv`` with its channel table and metadata.

    Parameters
    ----------
    path : pathlib.Path
        The motion file.
    root : pathlib.Path
        The data set's folder, where the inheritance of side files ends.
    begins_s : float
        Start of its recording on the trial's clock, s.

    Attributes
    ----------
    path : pathlib.Path
        The motion file.
    rate_hz : float
        Effective sampling rate if the metadata contain it, otherwise the nominal one.
    notes : list of str
        Data that were left out, and why.

    Raises
    ------
    RecordingError
        If a side file is missing or invalid, or the table does not match its channels.
    """

    def __init__(self, path: Path, root: Path, begins_s: float) -> None:
        self.path = path
        self.notes: list[str] = []
        self.rate_hz = self._rate_hz(root)
        self._channels, self._channel_file = channel_table(path, root)
        self._types = self._channels["type"].str.strip().str.upper()
        self._points = self._channels["tracked_point"].str.strip()
        self._values = read_numbers(path, separator="\t", missing_allowed=True)
        if self._values.shape[1] != len(self._channels):
            raise RecordingError(
                f"{path}: {self._values.shape[1]} columns, but {self._channel_file.name} lists "
                f"{len(self._channels)} channels"
            )
        self._drop_bad_channels()
        self._time_s = self._own_time_s() + begins_s

    def _rate_hz(self, root: Path) -> float:
        metadata, file = sidecar(self.path, root)
        key = "SamplingFrequency"
        # measured where it is a number; some write "n/a", or the number as text
        effective = metadata.get("SamplingFrequencyEffective")
        if re.fullmatch(r"\s*\d*\.?\d+\.?(e[+-]?\d+)?\s*", str(effective), re.IGNORECASE):
            key = "SamplingFrequencyEffective"
        if key not in metadata:
            raise RecordingError(f"{file}: no number '{key}'")
        try:
            return checked_rate_hz(metadata[key], f"{file}: {key}")
        except UserError as error:
            raise RecordingError(str(error)) from None

    def _drop_bad_channels(self) -> None:
        if "status" not in self._channels:
            return
        bad = np.flatnonzero(self._channels["status"].str.strip().str.lower() == "bad")
        if bad.size:
            self._values[:, bad] = np.nan
            names = sorted({f"{self._types[k]} of {self._points[k]}" for k in bad})
            self.notes.append(f"{self.path.name}: status bad, not read: {', '.join(names)}")

    def _own_time_s(self) -> FloatArray:
        latency = np.flatnonzero(self._types == "LATENCY")
        if not latency.size:
            return np.arange(len(self._values)) / self.rate_hz
        stamps = self._column(int(latency[0]), "LATENCY")
        others = np.delete(self._values, latency, axis=1)
        times = sampling_times(stamps, others, str(self.path))
        self._values = self._values[times.rows]
        self.notes += [f"{self.path.name}: {note}" for note in times.notes]
        return times.time_s

    def points(self, kind: str) -> list[str]:
        """List the tracked points that have channels of a type.

        Parameters
        ----------
        kind : str
            ``GYRO``, ``ACCEL``, ``ORNT``, ...

        Returns
        -------
        list of str
            In the order of the channels.
        """
        return list(dict.fromkeys(self._points[self._types == kind]))

    def table(self, point: str, kind: str, components: tuple[str, ...]) -> FloatArray | None:
        """Read the components of a tracked point.

        Parameters
        ----------
        point : str
            Tracked point.
        kind : str
            Type of the channels.
        components : tuple of str
            Components, in order.

        Returns
        -------
        ndarray, shape (N, 1 + number of components), or None
            Time in s, then SI; NaN where missing. None unless each component has one channel
            with a sample.

        Raises
        ------
        RecordingError
            If a unit is unknown.
        """
        columns = [self._time_s]
        for component in components:
            found = np.flatnonzero(
                (self._points == point)
                & (self._types == kind)
                & (self._channels["component"].str.strip().str.lower() == component)
            )
            if len(found) != 1:
                return None
            columns.append(self._column(int(found[0]), kind))
        table = np.column_stack(columns)
        return table if np.isfinite(table[:, 1:]).all(axis=1).any() else None

    def _column(self, channel: int, kind: str) -> FloatArray:
        values = self._values[:, channel]
        if kind not in _QUANTITIES:
            return values
        quantity, unit = _QUANTITIES[kind], self._channels["units"][channel].strip()
        factor = factor_to_si(quantity, unit)
        if factor is None and quantity == "time":
            factor = 1.0  # fixed by the specification
        if factor is None:
            raise RecordingError(
                f"{self.path}: channel {channel + 1} ({kind}) has unit '{unit}', expected one of "
                f"{', '.join(unit_names(quantity))}"
            )
        return values * factor
