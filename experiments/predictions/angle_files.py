"""Write tables of angles as CSV, Parquet, OpenSim storage files, C3D, or Motion-BIDS."""

from pathlib import Path

import pandas as pd
import pyarrow
import pyarrow.csv

from narx.errors import UserError
from narx.experiments.predictions import motion_bids_files
from narx.experiments.predictions.c3d_files import write_c3d
from narx.files import atomic_path

# OpenSim's .mot has the same format as its .sto
SUFFIXES = (".csv", ".parquet", ".sto", ".mot", ".c3d")


def check_suffix(path: Path) -> None:
    """Refuse an output file with an unsupported suffix.

    Parameters
    ----------
    path : pathlib.Path
        File to write.

    Raises
    ------
    UserError
        If its suffix is not in `SUFFIXES`, or it ends as a file of Motion-BIDS without
        the name and folder of one.
    """
    if path.name.endswith(motion_bids_files.ENDING):
        motion_bids_files.check_path(path)
    elif path.suffix.lower() not in SUFFIXES:
        known = ", ".join((*SUFFIXES, motion_bids_files.ENDING))
        raise UserError(f"output: '{path}', expected a name ending in {known}")


def write_angles(table: pd.DataFrame, path: Path, segment: str | None = None) -> None:
    """Write a table in the format given by the file's suffix.

    Parameters
    ----------
    table : pandas.DataFrame
        ``time_s`` first; angles in degrees.
    path : pathlib.Path
        File to write; replaced only when complete.
    segment : str, optional
        The segment of a single sensor, if known, for formats that name it.

    Raises
    ------
    UserError
        If the suffix is unknown or the file cannot be written.
    """
    check_suffix(path)
    try:
        if path.name.endswith(motion_bids_files.ENDING):
            motion_bids_files.write_motion_bids(table, path, segment or "segment")
            return
        if path.suffix.lower() == ".c3d":
            write_c3d(table, path, segment or "segment")
            return
        with atomic_path(path) as temporary:
            suffix = path.suffix.lower()
            if suffix == ".csv":
                _write_csv(table, temporary)
            elif suffix == ".parquet":
                table.to_parquet(temporary, index=False)
            else:
                _write_storage(table, temporary, path.stem)
    except OSError as error:
        raise UserError(f"output: '{path}' cannot be written: {error.strerror}") from error


def _write_csv(table: pd.DataFrame, path: Path) -> None:
    """Write the shortest digits that round-trip, six times as fast as pandas."""
    columns = {
        str(name): pyarrow.array(
            column.to_numpy() if column.dtype.kind in "iuf" else column.astype(str).tolist()
        )
        for name, column in table.items()
    }
    options = pyarrow.csv.WriteOptions(include_header=False, quoting_style="needed")
    with open(path, "wb") as stream:
        stream.write((",".join(columns) + "\n").encode())
        pyarrow.csv.write_csv(pyarrow.table(columns), stream, options)


def _write_storage(table: pd.DataFrame, path: Path, name: str) -> None:
    """Write the storage format: a header with row and column counts, then tab-separated values."""
    renamed = table.rename(columns={"time_s": "time"})
    renamed.columns = [column.removesuffix("_deg") for column in renamed.columns]
    header = [
        name,
        "version=1",
        f"nRows={len(renamed)}",
        f"nColumns={len(renamed.columns)}",
        "inDegrees=yes",
        "endheader",
    ]
    with open(path, "w", encoding="utf-8", newline="\n") as stream:
        stream.write("\n".join(header) + "\n")
        renamed.to_csv(stream, sep="\t", index=False, na_rep="nan", lineterminator="\n")
