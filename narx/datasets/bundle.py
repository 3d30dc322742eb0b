"""Export of a phone app: a zip or folder with one file per sensor."""

import csv
import io
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from narx.datasets.device_layouts import shipped_layouts
from narx.datasets.layout import Layout
from narx.datasets.table_recording import Sensor, recording_from, sensor_from
from narx.datasets.text_dialect import TextTable, read_table
from narx.errors import RecordingError
from narx.recordings.input_file import check_memory, regular_file
from narx.recordings.one_clock import at_gyroscope_times, union_of_rows
from narx.recordings.trial import ImuRecording

_TEXT = (".csv", ".txt", ".tsv")
# a meta folder contains the device's description, and macOS adds files of its own
_NO_SAMPLES = re.compile(r"meta/|__MACOSX/|(^|/)\.|readme", re.IGNORECASE)


def read_bundle(path: Path, segment: str) -> ImuRecording:
    """Read a recording with one file per sensor.

    Parameters
    ----------
    path : pathlib.Path
        Zip file or folder as a phone app exports it.
    segment : str
        Segment that carries the phone.

    Returns
    -------
    ImuRecording
        At the gyroscope's samples, the accelerometer interpolated to them; or the only table, if it
        contains both.

    Raises
    ------
    RecordingError
        If it contains no gyroscope file of a known app, and not exactly one table.
    """
    contents = _contents(path)
    for layout in shipped_layouts():
        chosen = {
            sensor: next((name for name in names if name in contents), None)
            for sensor, names in layout.files.items()
        }
        gyroscope_file, accelerometer_file = chosen.get("gyroscope"), chosen.get("accelerometer")
        if gyroscope_file is None:
            continue
        try:
            gyroscope = _sensor(path, contents, gyroscope_file, layout, "gyroscope")
        except RecordingError as error:
            if "no column" in str(error):
                continue
            raise
        notes = [f"{layout.name}: gyroscope from {gyroscope_file}", *gyroscope.notes]
        missing = np.full_like(gyroscope.values, np.nan)
        recording = ImuRecording(
            segment, gyroscope.time_s, gyroscope.values, missing, notes=tuple(notes)
        )
        if accelerometer_file is None:
            return recording
        accelerometer = _sensor(path, contents, accelerometer_file, layout, "accelerometer")
        force = accelerometer.values
        if layout.opposite is not None and layout.opposite.fits(
            _about(path, contents, layout.opposite.file)
        ):
            force = -force
            note = f"accelerometer's sign changed, according to {layout.opposite.file}"
            recording = replace(recording, notes=(*recording.notes, note))
        return at_gyroscope_times(union_of_rows(recording, accelerometer.time_s, force))
    if len(contents) == 1:
        ((name, content),) = contents.items()
        return recording_from(_table(path, name, content), None, segment)
    found = ", ".join(sorted(contents)[:20]) or "nothing"
    raise RecordingError(f"{path}: no gyroscope's file of a known app in it; found {found}")


def _about(path: Path, contents: dict[str, bytes | Path], name: str) -> dict[str, str]:
    """First row of a table about the recording, by column; empty without that table."""
    content = contents.get(name, b"")
    data = content.read_bytes() if isinstance(content, Path) else content
    rows = csv.DictReader(io.StringIO(data.decode("utf-8-sig", errors="replace")))
    try:
        first = next(iter(rows), {})
    except csv.Error as error:
        raise RecordingError(f"{path / name}: not a table ({error})") from None
    return {str(name).strip(): str(value) for name, value in first.items()}


def _contents(path: Path) -> dict[str, bytes | Path]:
    """Text files by name; those of a zip are read at once, up to the size limit of one file."""
    if path.is_dir():
        return {one.name: one for one in path.iterdir() if one.suffix.lower() in _TEXT}
    try:
        with zipfile.ZipFile(regular_file(path)) as archive:
            members = [m for m in archive.infolist() if m.filename.lower().endswith(_TEXT)]
            check_memory(path, sum(member.file_size for member in members))
            return {
                Path(member.filename).name: archive.read(member)
                for member in members
                if not _NO_SAMPLES.search(member.filename)
            }
    except RecordingError:
        raise
    except Exception as error:  # the exception depends on the damage
        raise RecordingError(f"{path}: not a whole zip file ({error})") from None


def _sensor(
    path: Path, contents: dict[str, bytes | Path], name: str, layout: Layout, sensor: str
) -> Sensor:
    table = _table(path, name, contents[name])
    return sensor_from(table, layout, "gyroscope" if sensor == "gyroscope" else "accelerometer")


def _table(path: Path, name: str, content: bytes | Path) -> TextTable:
    return read_table(content) if isinstance(content, Path) else read_table(path / name, content)
