"""Draft a `study.yaml` from the file names in a folder, and list the guesses."""

import re
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

import yaml

from narx.datasets.csv_recording import open_table, read_recording
from narx.datasets.segment_names import SEGMENT_PATTERN, segment_of
from narx.datasets.study_file import FILE_NAME, ReferenceFiles
from narx.datasets.study_patterns import files_below
from narx.errors import RecordingError, UserError

_SUFFIXES = (".csv", ".txt", ".tsv", ".parquet", ".pq", ".mat", ".zip", "")
_SEGMENT = re.compile(SEGMENT_PATTERN, re.IGNORECASE)
_SIDE = r"(_(?P<side>right|left|r|l)(?![a-z]))?"
_PARTS = {
    "still": re.compile(r"(?<![a-z])(still|bias|on_?table)(?![a-z])", re.IGNORECASE),
    "standing": re.compile(r"(?<![a-z])(standing|static|n_?pose)(?![a-z])", re.IGNORECASE),
    "hip_abduction": re.compile(rf"(hip_?)?abduction{_SIDE}", re.IGNORECASE),
    "knee_flexion": re.compile(rf"(knee_?)?flexion{_SIDE}", re.IGNORECASE),
}
_REFERENCE = re.compile(r"(reference|markers?|optical|mocap|vicon|qualisys)", re.IGNORECASE)
_PAGE = "docs/own_recordings.md"
_SIDES = {"r": "right", "l": "left"}


@dataclass
class Draft:
    """Text of a ``study.yaml``, and the guesses behind it.

    Parameters
    ----------
    text : str
        YAML.
    guesses : list of str
        One line for each pattern with its interpretation, and for each file that was not used.
    """

    text: str
    guesses: list[str] = field(default_factory=list)


@dataclass
class _Group:
    """Files of one pattern."""

    pattern: str
    part: str | None
    files: list[str] = field(default_factory=list)
    segments: set[str] = field(default_factory=set)


def draft_study(folder: Path) -> Draft:
    """Draft a ``study.yaml`` for a folder.

    Parameters
    ----------
    folder : pathlib.Path
        Folder with recordings, possibly in subfolders.

    Returns
    -------
    Draft
        The first folder is interpreted as the subject, the second as the condition, the rest of
        the name as the trial. One file of each pattern is read to determine its content.

    Raises
    ------
    UserError
        If there is no folder, or no file with a gyroscope in it.
    """
    if not folder.is_dir():
        raise UserError(f"input: no folder '{folder}'")
    groups: dict[tuple[str, str | None], _Group] = {}
    unread = []
    for path in files_below(folder, (FILE_NAME,)):
        if PurePosixPath(path).suffix.lower() not in _SUFFIXES:
            unread.append(path)
            continue
        pattern, part, segment = _pattern_of(path)
        group = groups.setdefault((pattern, part), _Group(pattern, part))
        group.files.append(path)
        if segment is not None:
            group.segments.add(segment)
    content: dict[str, object] = {}
    guesses: list[str] = []
    sensors: list[_Group] = []
    for group in groups.values():
        first = folder / group.files[0]
        what = _content_of(first)
        if what == "reference":
            content["reference"] = {"files": group.pattern, "frame": "sensor"}
            guesses.append(_line(group, "orientation of markers on the sensor (frame: sensor)"))
        elif what != "sensor":
            guesses.append(f"not used: {_counted(group)} as {group.pattern} ({what})")
        elif group.part is not None:
            parts = content.setdefault("calibration", {})
            assert isinstance(parts, dict)
            parts[group.part] = group.pattern
            guesses.append(_line(group, f"calibration part {group.part}"))
        else:
            sensors.append(group)
            guesses.append(_line(group, _segments_of(group)))
    if not sensors:
        raise UserError(
            f"input: no file with a gyroscope in '{folder}'"
            + (f"; {guesses[0]}" if guesses else "")
        )
    guesses += [f"not used: {path} (kind of file)" for path in unread]
    patterns = [group.pattern for group in sensors]
    files: dict[str, object] = {"files": patterns[0] if len(patterns) == 1 else patterns}
    text = yaml.safe_dump(files | content, sort_keys=False, allow_unicode=True, width=100)
    return Draft(f"# drafted from the names of the files; what each key means: {_PAGE}\n{text}",
                 guesses)  # fmt: skip


def _pattern_of(path: str) -> tuple[str, str | None, str | None]:
    """Pattern of a path, the calibration part that its name tells, and its segment."""
    pure = PurePosixPath(path)
    folders, suffix, stem = list(pure.parts[:-1]), pure.suffix, pure.stem
    segment = None
    matches = list(_SEGMENT.finditer(stem))
    if matches:
        segment = segment_of(matches[-1][0])
        before, after = stem[: matches[-1].start()], stem[matches[-1].end() :]
    else:
        for k, name in reversed(list(enumerate(folders))):
            if _SEGMENT.fullmatch(name):
                segment, folders[k] = segment_of(name), "{segment}"
                break
        before, after = stem, ""
    names = iter(("{subject}", "{condition}"))
    folders = [one if one == "{segment}" else next(names, "{any}") for one in folders]
    in_folder = "{subject}" in folders
    part = next((p for p, e in _PARTS.items() if e.search(before) or e.search(after)), None)
    if part is not None:
        found = _PARTS[part].search(before) or _PARTS[part].search(after)
        side = (found.groupdict().get("side") or "").lower() if found else ""
        part = f"{part}_{_SIDES.get(side, side)}" if side else part
    middle = "{segment}" if matches else ""
    # one name of a subject or trial, not one in front of the segment and another one behind
    lead = _fields(before, in_folder, part)
    trail = _fields(after, True, part)
    if "{trial}" in lead:
        trail = trail.replace("{trial}", "{any}")
    return "/".join([*folders, f"{lead}{middle}{trail}{suffix}"]), part, segment


def _fields(text: str, has_subject: bool, part: str | None) -> str:
    """Convert the rest of a name to fields, keeping the text that marks a part or a reference."""
    kept = _REFERENCE.search(text)
    if part is not None:
        kept = _PARTS[part.removesuffix("_right").removesuffix("_left")].search(text) or kept
    if kept is not None:
        before = _fields(text[: kept.start()], has_subject, None)
        after = _fields(text[kept.end() :], True, None)
        if "{trial}" in before:
            after = after.replace("{trial}", "{any}")
        return f"{before}{kept[0]}{after}"
    match = re.fullmatch(r"([_\W]*)(.*?)([_\W]*)", text)
    assert match is not None
    lead, name, trail = match.groups()
    if not name:
        return text
    words = re.split(r"([_\-. ])", name, maxsplit=1)
    if has_subject or len(words) == 1:
        return f"{lead}{{trial}}{trail}"
    return f"{lead}{{subject}}{words[1]}{{trial}}{trail}"


def _content_of(path: Path) -> str:
    """Return `sensor`, `reference`, or the reason why it is neither."""
    try:
        read_recording(path)
        return "sensor"
    except RecordingError as error:
        reason = str(error)
    try:
        names = {name.strip().lower() for name in open_table(path).names}
    except RecordingError:
        return reason
    columns = ReferenceFiles.model_fields["quaternion"].default
    return "reference" if set(columns) <= names else reason


def _segments_of(group: _Group) -> str:
    if group.segments:
        return f"sensors on {', '.join(sorted(group.segments))}"
    return (
        "a sensor, no body part in the names: put what tells the sensors apart into "
        "{segment}, and its meaning into segments: {NAME: thigh_right}"
    )


def _line(group: _Group, what: str) -> str:
    return f"{_counted(group)} as {group.pattern}: {what}"


def _counted(group: _Group) -> str:
    return f"{len(group.files)} file{'' if len(group.files) == 1 else 's'}"
