"""Write angles as a Motion-BIDS derivative: samples, their channel table and side file.

As the specification has it: `*_motion.tsv` without a header, `*_channels.tsv`, `*_motion.json`.
Joints are channels of type JNTANG. The angles of segments are clinical angles with signs of their
own, not an orientation by Euler angles, so they are MISC, with a description.
"""

import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

import narx
from narx.datasets.bids_files import entities_of
from narx.errors import UserError
from narx.experiments.predictions.angle_columns import angle_column
from narx.experiments.runs.record import write_json
from narx.files import atomic_path
from narx.kinematics.joints import JOINTS
from narx.kinematics.segment_angles import AXES

ENDING = "_motion.tsv"
_NAME = re.compile(
    r"sub-[a-zA-Z0-9]+(_ses-[a-zA-Z0-9]+)?_task-[a-zA-Z0-9]+_tracksys-[a-zA-Z0-9]+"
    r"(_acq-[a-zA-Z0-9]+)?(_run-[0-9]+)?_motion\.tsv"
)
_MEANING = dict(
    zip(AXES, ("flexion positive", "abduction positive", "internal rotation positive"), strict=True)
)
_BIDS_VERSION = "1.10.0"
_DESCRIPTION, _MADE_BY = "dataset_description.json", "narx-orientation"
_NOT_BIDS = (
    "*_strides.csv",
    "*_cycle.csv",
    "*_cycle.png",
    "*_record.json",
    "record.json",
    "summary.csv",
)


def check_path(path: Path) -> None:
    """Refuse a file name or folder that is none of Motion-BIDS.

    Parameters
    ----------
    path : pathlib.Path
        File to write, ending in ``_motion.tsv``.

    Raises
    ------
    UserError
        If its entities are incomplete or in another order, or it is not in the folder of its
        subject and session, or the root of these is that of another data set.
    """
    if not _NAME.fullmatch(path.name):
        raise UserError(
            f"output: '{path}', expected sub-<label>[_ses-<label>]_task-<label>_tracksys-<label>"
            f"[_acq-<label>][_run-<number>]{ENDING}"
        )
    entities = entities_of(path.name)
    own = [f"{key}-{entities[key]}" for key in ("sub", "ses") if key in entities] + ["motion"]
    if list(path.absolute().parent.parts[-len(own) :]) != own:
        raise UserError(f"output: '{path}', expected DATASET/{'/'.join(own)}/{path.name}")
    _check_root(root_of(path))


def root_of(path: Path) -> Path:
    """Return the root of the data set of a file.

    Parameters
    ----------
    path : pathlib.Path
        As accepted by `check_path`.

    Returns
    -------
    pathlib.Path
        The folder above that of the subject.
    """
    return path.absolute().parents[3 if "ses" in entities_of(path.name) else 2]


def files_beside(path: Path) -> list[Path]:
    """List the files that are written with a file of samples.

    Parameters
    ----------
    path : pathlib.Path
        As accepted by `check_path`.

    Returns
    -------
    list of pathlib.Path
        Table of channels and side file.
    """
    stem = path.name.removesuffix(ENDING)
    return [path.with_name(f"{stem}{ending}") for ending in ("_channels.tsv", "_motion.json")]


def file_of_trial(subject: str, condition: str, trial: str) -> Path:
    """Name the file of a trial below the folder of a data set.

    Parameters
    ----------
    subject, condition, trial : str
        Names of the trial; characters that a label may not have are left out.

    Returns
    -------
    pathlib.Path
        ``sub-<subject>/motion/sub-<subject>_task-<condition>_tracksys-narx_acq-<trial>_motion.tsv``.
    """
    who, task, one = (
        re.sub(r"[^a-zA-Z0-9]", "", name) or "unnamed" for name in (subject, condition, trial)
    )
    name = f"sub-{who}_task-{task}_tracksys-narx_acq-{one}{ENDING}"
    return Path(f"sub-{who}", "motion", name)


def write_description(folder: Path) -> None:
    """Write ``dataset_description.json`` of a folder of derivatives, and ``.bidsignore``.

    Strides, gait cycles and records have no name in BIDS; ``.bidsignore`` lists them, so that the
    data set is valid with them. Lines that are in it already are kept.

    Parameters
    ----------
    folder : pathlib.Path
        Root of the data set.

    Raises
    ------
    UserError
        If it is the root of another data set, such as that of the recordings, or its
        ``.bidsignore`` cannot be read.
    """
    _check_root(folder)
    made_by = {"Name": _MADE_BY, "Version": narx.__version__}
    write_json(
        {
            "Name": "Angles of segments and joints",
            "BIDSVersion": _BIDS_VERSION,
            "DatasetType": "derivative",
            "GeneratedBy": [made_by],
        },
        folder / _DESCRIPTION,
    )
    _add_lines(folder / ".bidsignore", _NOT_BIDS)


def _add_lines(path: Path, lines: Sequence[str]) -> None:
    """Append the lines that a file of text lacks."""
    try:
        present = path.read_text(encoding="utf-8-sig").splitlines() if path.exists() else []
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"output: '{path}' is no text ({error})") from None
    missing = [line for line in lines if line not in present]
    if missing:
        with atomic_path(path) as temporary:
            temporary.write_text("\n".join([*present, *missing]) + "\n", encoding="utf-8")


def _check_root(folder: Path) -> None:
    try:
        about = json.loads((folder / _DESCRIPTION).read_text("utf-8-sig"))
        makers = [one["Name"] for one in about["GeneratedBy"]]
    except FileNotFoundError:
        return
    except (OSError, ValueError, KeyError, TypeError):
        makers = []
    if makers != [_MADE_BY]:
        raise UserError(
            f"output: '{folder / _DESCRIPTION}' describes another data set; expected a folder of "
            "its own, such as derivatives/narx below it"
        )


def write_motion_bids(table: pd.DataFrame, path: Path, alone: str) -> None:
    """Write angles; the samples last, since they stand for the whole.

    Parameters
    ----------
    table : pandas.DataFrame
        ``time_s`` first; angles in degrees.
    path : pathlib.Path
        File of the samples, as in `check_path`.
    alone : str
        Name of the segment of a single sensor.
    """
    entities = entities_of(path.name)
    channel_file, side_file = files_beside(path)
    channels = pd.DataFrame([_channel(str(name), alone) for name in table])
    with atomic_path(channel_file) as temporary:
        _write_tsv(channels, temporary, header=True)
    interval_s = float(np.median(np.diff(table["time_s"]))) if len(table) > 1 else float("nan")
    counts = channels["type"].value_counts()
    points = set(channels["tracked_point"]) - {"n/a"}
    about = {
        "TaskName": entities["task"],
        "TrackingSystemName": entities["tracksys"],
        "SamplingFrequency": round(1.0 / interval_s, 6),
        "MotionChannelCount": len(channels),
        "TrackedPointsCount": len(points),
        "MissingValues": "n/a",
        **{f"{kind}ChannelCount": int(counts[kind]) for kind in sorted(counts.index)},
    }
    write_json(about, side_file)
    with atomic_path(path) as temporary:
        _write_tsv(table, temporary, header=False)


def _channel(name: str, alone: str) -> dict[str, str]:
    point, kind, units = "n/a", "MISC", "n/a"
    description = "0 network, 1 after a gap, 2 missing, 3 start-up or no walking, 4 unlike a leg"
    column = angle_column(name, alone)
    if name == "time_s":
        kind, units, description = "LATENCY", "s", "time of the sample"
    elif column is not None:
        point, units = column.point, "deg"
        of = "joint" if point in JOINTS else "segment"
        kind = "JNTANG" if of == "joint" and not column.is_std else "MISC"
        description = f"{column.axis} angle of the {of}, {_MEANING[column.axis]}"
        if column.is_std:
            description = f"standard deviation of the {description}"
    elif name.endswith("_quality"):
        point = name.removesuffix("_quality")
    return {
        "name": name,
        "component": "n/a",
        "type": kind,
        "tracked_point": point,
        "units": units,
        "description": description,
    }


def _write_tsv(table: pd.DataFrame, path: Path, *, header: bool) -> None:
    table.to_csv(path, sep="\t", index=False, header=header, na_rep="n/a", lineterminator="\n")
