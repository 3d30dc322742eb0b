"""Names and side files of a BIDS data set: entities, the inheritance principle, acquisition times.

Brain Imaging Data Structure, https://bids-specification.readthedocs.io, "Motion" and "Common
principles": a side file applies to every data file in its folder and below whose entities include
all of its own; for each key, the nearest one takes precedence.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from narx.errors import RecordingError
from narx.recordings.input_file import regular_file

# folders of a data set without raw data
_NOT_RAW = frozenset({"derivatives", "sourcedata", "code", "phenotype", "stimuli"})


def entities_of(name: str) -> dict[str, str]:
    """Split a file name into its entities, in any order.

    Parameters
    ----------
    name : str
        Such as ``sub-01_task-walk_tracksys-imu_acq-fast_motion.tsv``.

    Returns
    -------
    dict of str to str
        Entity to label; the suffix has the key ``""``.
    """
    *pairs, suffix = name.split(".")[0].split("_")
    found = {"": suffix}
    for pair in pairs:
        key, _, label = pair.partition("-")
        found[key] = label
    return found


def raw_motion_files(root: Path) -> list[Path]:
    """List the raw motion recordings of a data set, without derived ones.

    Parameters
    ----------
    root : pathlib.Path
        The data set's folder.

    Returns
    -------
    list of pathlib.Path
        Files with the entities ``sub``, ``task`` and ``tracksys``, sorted.
    """
    files = []
    for path in sorted(root.rglob("*_motion.tsv")):
        folders = path.relative_to(root).parts[:-1]
        raw = not any(part in _NOT_RAW or part.startswith(".") for part in folders)
        if raw and {"sub", "task", "tracksys"} <= entities_of(path.name).keys():
            files.append(path)
    return files


def applicable(path: Path, root: Path, suffix: str, extension: str) -> list[Path]:
    """Find the side files that apply to a data file.

    Parameters
    ----------
    path : pathlib.Path
        Data file.
    root : pathlib.Path
        The data set's folder, at which the search ends.
    suffix, extension : str
        Suffix and extension of the side file, such as ``channels`` and ``.tsv``.

    Returns
    -------
    list of pathlib.Path
        The nearest last; within one folder, the one with more entities last.
    """
    own = entities_of(path.name)
    found: list[Path] = []
    for folder in (path.parent, *path.parent.parents):
        here = []
        for other in folder.glob(f"*{suffix}{extension}"):
            entities = entities_of(other.name)
            if entities.pop("") == suffix and entities.items() <= own.items():
                here.append((len(entities), other.name, other))
        found = [other for *_, other in sorted(here)] + found
        if folder == root:
            break
    return found


def sidecar(path: Path, root: Path) -> tuple[dict[str, object], Path]:
    """Read the metadata of a motion file.

    Parameters
    ----------
    path : pathlib.Path
        ``*_motion.tsv``.
    root : pathlib.Path
        The data set's folder.

    Returns
    -------
    metadata : dict
        All applicable ``*_motion.json``, merged; nearer files take precedence.
    nearest : pathlib.Path
        The nearest of them, for messages.

    Raises
    ------
    RecordingError
        If there is none, or one is not a JSON object.
    """
    files = applicable(path, root, "motion", ".json")
    if not files:
        expected = path.with_suffix(".json")
        raise RecordingError(f"{expected}: no such file, and no other *_motion.json applies")
    merged: dict[str, object] = {}
    for file in files:
        try:
            content = json.loads(regular_file(file).read_text("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise RecordingError(f"{file}: not JSON ({error})") from None
        if not isinstance(content, dict):
            raise RecordingError(f"{file}: holds a {type(content).__name__}, expected an object")
        merged |= content
    return merged, files[-1]


def channel_table(path: Path, root: Path) -> tuple[pd.DataFrame, Path]:
    """Read the table of channels of a motion file.

    Parameters
    ----------
    path : pathlib.Path
        ``*_motion.tsv``.
    root : pathlib.Path
        The data set's folder.

    Returns
    -------
    channels : pandas.DataFrame
        One row per column of the motion file, all text; missing cells are empty.
    file : pathlib.Path
        Source file.

    Raises
    ------
    RecordingError
        If there is none, or it lacks a column that the specification requires.
    """
    files = [
        file
        for file in applicable(path, root, "channels", ".tsv")
        if "tracksys" in entities_of(file.name)
    ]
    if not files:
        stem = path.name.removesuffix("_motion.tsv")
        raise RecordingError(f"{path.with_name(f'{stem}_channels.tsv')}: no such file")
    table = read_tsv(files[-1])
    needed = {"component", "type", "tracked_point", "units"} - set(table)
    if needed:
        raise RecordingError(f"{files[-1]}: no column '{sorted(needed)[0]}'")
    return table, files[-1]


def read_tsv(file: Path) -> pd.DataFrame:
    """Read a table of text.

    Parameters
    ----------
    file : pathlib.Path
        Fields separated by tabs, with a header.

    Returns
    -------
    pandas.DataFrame
        All cells as text.

    Raises
    ------
    RecordingError
        If it is not such a table.
    """
    try:
        table = pd.read_csv(
            regular_file(file), sep="\t", dtype=str, keep_default_na=False, encoding="utf-8-sig"
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        message = str(error).strip().splitlines()[0]
        raise RecordingError(f"{file}: not a table ({message})") from None
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes surplus cells for an index
        raise RecordingError(f"{file}: not a table (a row has more cells than the header)")
    return table


def start_offsets_s(paths: list[Path], root: Path) -> Mapping[Path, float]:
    """Return the start of recordings relative to the first of them.

    Parameters
    ----------
    paths : list of pathlib.Path
        Recordings of one trial.
    root : pathlib.Path
        The data set's folder.

    Returns
    -------
    mapping of pathlib.Path to float
        From ``acq_time`` of the nearest ``*_scans.tsv``, s; empty unless all of them have one.

    Raises
    ------
    RecordingError
        If an acquisition time is not a date and time, or they are centuries apart.
    """
    begun: dict[Path, pd.Timestamp] = {}
    for path in paths:
        for scans in reversed(applicable(path, root, "scans", ".tsv")):
            table = read_tsv(scans)
            if not {"filename", "acq_time"} <= set(table):
                continue
            name = path.relative_to(scans.parent).as_posix()
            listed = table["filename"].str.strip().str.replace("\\", "/").str.removeprefix("./")
            times = table.loc[listed == name, "acq_time"].str.strip()
            if not len(times) or times.iloc[0] in ("", "n/a"):
                continue
            try:
                begun[path] = pd.to_datetime(times.iloc[0], utc=True, format="ISO8601")
            except ValueError:
                raise RecordingError(
                    f"{scans}: acq_time of {name} is '{times.iloc[0][:40]}', expected a date and "
                    "time (ISO 8601)"
                ) from None
            break
    if len(begun) < len(paths):
        return {}
    first = min(begun.values())
    try:
        return {path: (time - first).total_seconds() for path, time in begun.items()}
    except ValueError:  # beyond the range of an interval of pandas
        raise RecordingError(
            f"{paths[0]}: acq_time of this recording and of others of the trial are centuries apart"
        ) from None
