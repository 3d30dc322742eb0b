"""A session of many hours: in parts, so that memory does not grow with its length."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet
from omegaconf import DictConfig

from narx.datasets.array_table import read_parquet
from narx.datasets.layout import Layout
from narx.datasets.table_recording import recording_from, stamps_from
from narx.errors import UserError
from narx.experiments.predictions.angle_files import write_angles
from narx.experiments.predictions.jobs import Job, key_of
from narx.experiments.predictions.options import layout_of
from narx.experiments.predictions.session_tables import angle_table
from narx.inference.pretrained import load_or_pretrained
from narx.inference.session import predict_session
from narx.recordings.input_file import regular_file
from narx.types import FloatArray

# read before each part, so that the network has settled where the part begins
_LEAD_S = 60.0
# a session of more rows is not predicted at once
_MANY_ROWS = 2_000_000
_PIECE_ROWS = 2_000_000
_PARQUET = (".parquet", ".pq")

Rows = tuple[Path, int, int]


@dataclass(frozen=True)
class PartJob(Job):
    """One part of a session.

    Parameters
    ----------
    cfg, name, target, key
        As of `Job`.
    rows : mapping of str to tuple
        By segment: file, first row, and the row after the last; with the lead before the part.
    begin_s, end_s : float
        The part itself, on the first sensor's clock.
    first : bool
        Whether the recording begins with it.
    """

    rows: Mapping[str, Rows]
    begin_s: float
    end_s: float
    first: bool

    @property
    def recordings(self) -> tuple[Path, ...]:
        """The files of the session."""
        return tuple(file for file, _, _ in self.rows.values())

    def _predicted(self) -> tuple[tuple[str, ...], int, int]:
        layout = layout_of(self.cfg)
        session = predict_session(
            {
                segment: recording_from(read_parquet(file, (start, stop)), layout, segment)
                for segment, (file, start, stop) in self.rows.items()
            },
            load_or_pretrained(self.cfg.checkpoint).method(self.cfg.smoothing),
            calibration=self.cfg.calibration,
            # a rest amid a day may be sitting: neither the zero nor the vertical is taken from it
            start_pose=self.cfg.start_pose if self.first else "unknown",
            still_s=None if self.first else (),
            align="stamps",
            where=self.name,
        )
        table = angle_table(session)
        table = table[(table.time_s >= self.begin_s) & (table.time_s < self.end_s)]
        write_angles(table.reset_index(drop=True), self.target)
        last = list(session.angles_rad)[-1]
        n_angles = int(table[f"{last}_sagittal_deg"].notna().sum())
        return session.notes, len(table), n_angles


def is_partitioned(files: Mapping[str, Path], target: Path) -> bool:
    """Tell whether a session is predicted in parts.

    Parameters
    ----------
    files : mapping of str to pathlib.Path
        File of each segment.
    target : pathlib.Path
        Output.

    Returns
    -------
    bool
        True for Parquet files and an output that is a folder.

    Raises
    ------
    UserError
        If the session is too long to be predicted at once, and the output is a file.
    """
    if any(file.suffix.lower() not in _PARQUET for file in files.values()):
        return False
    if not target.suffix or target.is_dir():
        return True
    n_rows = sum(_n_rows(file) for file in files.values())
    if n_rows > _MANY_ROWS:
        raise UserError(
            f"output: '{target}' is one file for {n_rows} rows, which are predicted in parts; "
            "expected a folder"
        )
    return False


def part_jobs(cfg: DictConfig, files: Mapping[str, Path], folder: Path) -> list[Job]:
    """Make a job of every part of a session.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``; a part lasts ``partition_s``.
    files : mapping of str to pathlib.Path
        Parquet file of each segment, on one clock.
    folder : pathlib.Path
        Folder of the output.

    Returns
    -------
    list of Job
        In the order of time.

    Raises
    ------
    UserError
        If a file cannot be read, time goes back, or the sensors have no time in common.
    """
    layout = layout_of(cfg)
    begin, end = -np.inf, np.inf
    # the stamps of one sensor at a time: those of a day and four sensors are 300 MB
    for file in files.values():
        time = _stamps(file, layout)
        if (time[1:] < time[:-1]).any():
            raise UserError(f"{file}: time goes back, expected it to increase")
        begin, end = max(begin, float(time[0])), min(end, float(time[-1]))
    if begin >= end:
        raise UserError("input: the sensors have no time in common")
    state = "".join(f"{file}{file.stat().st_size}-{file.stat().st_mtime_ns}"
                    for file in files.values())  # fmt: skip
    edges = np.arange(begin, end, cfg.partition_s)
    if len(edges) > 1 and end - edges[-1] < _LEAD_S:
        edges = edges[:-1]  # a last part too short to calibrate from belongs to the one before
    leads = edges - np.where(np.arange(len(edges)) > 0, _LEAD_S, 0.0)
    ends = np.append(edges[1:], np.inf)
    of_segment = {}
    for segment, file in files.items():
        time = _stamps(file, layout)
        of_segment[segment] = np.searchsorted(time, leads), np.searchsorted(time, ends)
    jobs: list[Job] = []
    for number, (start, stop) in enumerate(zip(edges, ends, strict=True)):
        rows = {
            segment: (files[segment], int(firsts[number]), int(lasts[number]))
            for segment, (firsts, lasts) in of_segment.items()
        }
        target = folder / f"{number:04d}_angles.{cfg.format}"
        key = key_of(f"{state}{rows}", cfg)
        name = f"{number:04d}"
        jobs.append(PartJob(cfg, name, target, key, rows, float(start), float(stop), number == 0))
    return jobs


def _stamps(file: Path, layout: Layout | None) -> FloatArray:
    """Read all time stamps, a piece at a time."""
    n = _n_rows(file)
    time = np.empty(n)
    for start in range(0, n, _PIECE_ROWS):
        stop = min(start + _PIECE_ROWS, n)
        time[start:stop] = stamps_from(read_parquet(file, (start, stop)), layout)
    if n < 2:
        raise UserError(f"{file}: {n} rows, expected a Parquet file with samples")
    if not np.array_equal(time[-2:], stamps_from(read_parquet(file, (n - 2, n)), layout)):
        raise UserError(
            f"{file}: dates or counters as time cannot be read in parts, expected seconds in a "
            "column such as time_s"
        )
    return time


def _n_rows(file: Path) -> int:
    try:
        return int(pyarrow.parquet.read_metadata(regular_file(file)).num_rows)
    except (pyarrow.ArrowException, OSError):
        return 0  # refused where it is read
