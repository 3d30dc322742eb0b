"""Write angles as a Motion-BIDS derivative: samples, their channel table and side file.

As the specification has it: `*_motion.tsv` without a header, `*_channels.tsv`, `*_motion.json`.
Joints are channels of type JNTANG. The angles of segments are clinical angles with signs of their
own, not an orientation by Euler angles, so they are MISC, with a description.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd

import narx
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


def check_name(path: Path) -> None:
    """Refuse a file name that is none of Motion-BIDS.

    Parameters
    ----------
    path : pathlib.Path
        File to write, ending in ``_motion.tsv``.

    Raises
    ------
    UserError
        If its entities are incomplete or in another order.
    """
    if not _NAME.fullmatch(path.name):
        raise UserError(
            f"output: '{path}', expected sub-<label>[_ses-<label>]_task-<label>_tracksys-<label>"
            f"[_acq-<label>][_run-<number>]{ENDING}"
        )


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
    """Write the ``dataset_description.json`` of a folder of derivatives.

    Parameters
    ----------
    folder : pathlib.Path
        Root of the data set.
    """
    made_by = {"Name": "narx-orientation", "Version": narx.__version__}
    write_json(
        {
            "Name": "Angles of segments and joints",
            "BIDSVersion": _BIDS_VERSION,
            "DatasetType": "derivative",
            "GeneratedBy": [made_by],
        },
        folder / "dataset_description.json",
    )


def write_motion_bids(table: pd.DataFrame, path: Path) -> None:
    """Write angles; the samples last, since they stand for the whole.

    Parameters
    ----------
    table : pandas.DataFrame
        ``time_s`` first; angles in degrees.
    path : pathlib.Path
        File of the samples, as in `check_name`.
    """
    stem = path.name.removesuffix(ENDING)
    channels = pd.DataFrame([_channel(str(name)) for name in table])
    with atomic_path(path.with_name(f"{stem}_channels.tsv")) as temporary:
        _write_tsv(channels, temporary, header=True)
    interval_s = float(np.median(np.diff(table["time_s"]))) if len(table) > 1 else float("nan")
    counts = channels["type"].value_counts()
    points = set(channels["tracked_point"]) - {"n/a"}
    about = {
        "TaskName": re.findall("_task-([a-zA-Z0-9]+)", stem)[0],
        "TrackingSystemName": re.findall("_tracksys-([a-zA-Z0-9]+)", stem)[0],
        "SamplingFrequency": round(1.0 / interval_s, 6),
        "MotionChannelCount": len(channels),
        "TrackedPointsCount": len(points),
        "MissingValues": "n/a",
        **{f"{kind}ChannelCount": int(counts[kind]) for kind in sorted(counts.index)},
    }
    write_json(about, path.with_name(f"{stem}_motion.json"))
    with atomic_path(path) as temporary:
        _write_tsv(table, temporary, header=False)


def _channel(name: str) -> dict[str, str]:
    point, kind, units = "n/a", "MISC", "n/a"
    description = "0 network, 1 after a gap, 2 missing, 3 start-up or no walking, 4 unlike a leg"
    column = angle_column(name)
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
