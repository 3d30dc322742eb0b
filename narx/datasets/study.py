"""A user's recordings, described by a `study.yaml` in their folder (docs/own_recordings.md)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from narx.datasets.base import INDEX_COLUMNS, TrialSource
from narx.datasets.csv_recording import read_recording
from narx.datasets.device_layouts import layout_from, read_layout
from narx.datasets.layout import Layout
from narx.datasets.study_file import FILE_NAME, StudyFile, TrialSettings, read_study_file
from narx.datasets.study_patterns import FilePattern, files_below
from narx.datasets.study_reference import read_orientation
from narx.datasets.synchronised import synchronised
from narx.errors import RecordingError, UserError
from narx.files import safe_name, sha256_of
from narx.recordings.plausibility import admit
from narx.recordings.rest import first_rest_s
from narx.recordings.session_clock import clock_offsets_s
from narx.recordings.trial import ImuRecording, Trial
from narx.settings import FilePath, SamplingRate, checked

_MIN_REST_S = 0.5
Key = tuple[str, str, str]


@dataclass
class StudyTrial:
    """Files of one trial, by segment.

    Parameters
    ----------
    settings : TrialSettings
        Settings of this trial.
    sensors, references : dict of str to str
        Paths below the study's folder.
    calibration : dict of str to dict of str to str
        By part, then by segment.
    """

    settings: TrialSettings
    sensors: dict[str, str] = field(default_factory=dict)
    references: dict[str, str] = field(default_factory=dict)
    calibration: dict[str, dict[str, str]] = field(default_factory=dict)

    def files(self) -> list[str]:
        """List all paths.

        Returns
        -------
        list of str
            Below the study's folder, sorted.
        """
        parts = [path for part in self.calibration.values() for path in part.values()]
        return sorted({*self.sensors.values(), *self.references.values(), *parts})


class Study(TrialSource):
    """Recordings of a study: subject, condition and trial as in the names of its files.

    Parameters
    ----------
    root : path-like
        Folder with ``study.yaml``.
    sampling_rate_hz : float, optional
        Rate of the uniform clock; None takes that of ``study.yaml``, or the first sensor's.
    """

    name: ClassVar[str] = "study"

    @checked
    def __init__(
        self, *, root: FilePath | None = None, sampling_rate_hz: SamplingRate | None = None
    ) -> None:
        self._root = None if root is None else Path(root).expanduser()
        self._sampling_rate_hz = sampling_rate_hz
        self._opened: tuple[StudyFile, dict[Key, StudyTrial]] | None = None

    @classmethod
    def files(cls, root: Path) -> list[Path]:
        """List the files from which the trials are read.

        Parameters
        ----------
        root : pathlib.Path
            Folder with ``study.yaml``.

        Returns
        -------
        list of pathlib.Path
            ``study.yaml`` and every file that it names.

        Raises
        ------
        UserError
            As `index`.
        """
        study, trials = cls(root=root)._study()
        named = {path for trial in trials.values() for path in trial.files()}
        device = [] if study.device is None else [root / study.device]
        found = [root / FILE_NAME, *device, *(root / path for path in sorted(named))]
        inside = [sorted(p for p in path.rglob("*") if p.is_file()) for path in found
                  if path.is_dir()]  # fmt: skip
        return [*(path for path in found if not path.is_dir()), *(p for one in inside for p in one)]

    def _folder(self) -> Path:
        if self._root is None:
            raise UserError(f"study: no folder given; set data_root=DIR for DIR/{FILE_NAME}")
        if not (self._root / FILE_NAME).exists():
            raise UserError(
                f"study: no '{self._root / FILE_NAME}'; narx-draft-study input={self._root} drafts "
                "one"
            )
        return self._root

    def _study(self) -> tuple[StudyFile, dict[Key, StudyTrial]]:
        if self._opened is None:
            folder = self._folder()
            study = read_study_file(folder)
            self._opened = study, trials_of(study, folder)
        return self._opened

    def _list_trials(self) -> pd.DataFrame:
        trials = self._study()[1]
        return pd.DataFrame(list(trials), columns=list(INDEX_COLUMNS)).assign(
            segments=[", ".join(trial.sensors) for trial in trials.values()],
            has_reference=[bool(trial.references) for trial in trials.values()],
        )

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        study, trials = self._study()
        folder, found = self._folder(), trials[subject, condition, trial]
        layout = _layout(study, folder)
        where = f"{folder}: {subject}/{condition}/{trial}"
        raw = {s: read_recording(folder / p, s, layout) for s, p in found.sensors.items()}
        sensors = {s: admit(one, str(folder / found.sensors[s])) for s, one in raw.items()}
        offsets_s, notes = clock_offsets_s(sensors, study.align, where)
        sensors = {s: replace(one, time_s=one.time_s + offsets_s[s]) for s, one in sensors.items()}
        notes += [f"{s}: {note}" for s, one in sensors.items() for note in one.notes]
        parts: dict[str, dict[str, ImuRecording]] = {}
        for part, files in found.calibration.items():
            parts[part] = {s: read_recording(folder / p, s, layout) for s, p in files.items()}
        for part, value in study.calibration.items():
            if isinstance(value, tuple):
                parts[part] = {s: _cut(one, value, part, where) for s, one in sensors.items()}
            elif part not in parts:
                notes.append(f"no file of the calibration part '{part}'")
        assert study.reference is not None or not found.references
        optical = {
            segment: read_orientation(folder / path, study.reference)
            for segment, path in found.references.items()
            if study.reference is not None
        }
        # the digits beyond six are those of time stamps written in decimals
        own_hz = float(f"{next(iter(sensors.values())).sampling_rate_hz:.6g}")
        rate_hz = self._sampling_rate_hz or study.sampling_rate_hz or own_hz
        aligned = synchronised(
            sensors,
            optical,
            rate_hz,
            where,
            anatomical=study.reference is not None and study.reference.frame == "anatomical",
        )
        settings = found.settings
        stands, starts_still = _stands(aligned.imus, settings)
        if settings.start_pose == "known" and not starts_still:
            raise RecordingError(
                f"{where}: start_pose is known, but the recording does not begin with "
                f"{_MIN_REST_S:g} s of standing still"
            )
        if stands and settings.still_s is None:
            notes.append("the rest at the start is assumed to be the calibration posture")
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=rate_hz,
            imus=aligned.imus,
            reference=aligned.reference,
            calibration=parts,
            still_s=stands,
            straight=bool(settings.straight),
            starts_in_calibration_posture=starts_still and settings.start_pose != "unknown",
            walking_s=settings.walking_s,
            clock_offset_s=aligned.clock_offset_s,
            notes=(*notes, *aligned.notes),
            sources={p: sha256_of(folder / p) for p in found.files() if (folder / p).is_file()},
        )


def trials_of(study: StudyFile, folder: Path) -> dict[Key, StudyTrial]:
    """Find the files of every trial.

    Parameters
    ----------
    study : StudyFile
        Content of ``study.yaml``.
    folder : pathlib.Path
        Its folder.

    Returns
    -------
    dict of (subject, condition, trial) to StudyTrial
        In the order of the names.

    Raises
    ------
    UserError
        If a pattern matches no file, a file is missing, two files are the same sensor of one
        trial, or an entry of ``trials`` matches none.
    """
    where = folder / FILE_NAME
    default = {"subject": study.subject, "condition": study.condition, "trial": study.trial}
    listed = files_below(folder, (FILE_NAME,))
    claimed: set[str] = set()
    parts = {
        part: _matches(study, where, f"calibration.{part}", (pattern,), listed, claimed)
        for part, pattern in study.calibration.items()
        if isinstance(pattern, str)
    }
    references = []
    if study.reference is not None:
        files = study.reference.files
        references = _matches(study, where, "reference.files", files, listed, claimed)
    trials: dict[Key, StudyTrial] = {}
    if study.files is not None:
        for path, fields in _matches(study, where, "files", study.files, listed, claimed):
            values = default | {k: v for k, v in fields.items() if v is not None}
            key = (values["subject"], values["condition"], values["trial"])
            trial = trials.setdefault(key, StudyTrial(TrialSettings()))
            _put(trial.sensors, fields.get("segment", "imu"), path, where)
    for one in study.trials:
        if one.files is not None:
            key = (one.subject or study.subject, one.condition or study.condition,
                   one.trial or study.trial)  # fmt: skip
            trial = trials.setdefault(key, StudyTrial(TrialSettings()))
            trial.sensors = {safe_name(s): _existing(p, folder) for s, p in one.files.items()}
    for number, one in enumerate(study.trials):
        matching = [key for key in trials if _applies(one, key)]
        if not matching:
            known = ", ".join("/".join(key) for key in list(trials)[:5])
            raise UserError(f"{where}: trials.{number} matches none; there are {known}")
        for key in matching if one.left_out else ():
            del trials[key]
    for key, trial in trials.items():
        trial.settings = _settings(study, key)
        for part, found in parts.items():
            chosen = _of_trial(found, key, where)
            if chosen:
                trial.calibration[part] = chosen
        trial.references = _of_trial(references, key, where)
    if not trials:
        raise UserError(f"{where}: all trials are left out")
    return dict(sorted(trials.items()))


Match = tuple[str, Mapping[str, str]]


def _matches(
    study: StudyFile,
    where: Path,
    key: str,
    patterns: tuple[str, ...],
    listed: list[str],
    claimed: set[str],
) -> list[Match]:
    """Files that match a pattern and are not claimed by an earlier key."""
    found: list[Match] = []
    for text in patterns:
        pattern = FilePattern(text, study.segments, f"{where}: {key}")
        fields = {p: f for p in listed if p not in claimed and (f := pattern.fields(p)) is not None}
        if not fields:
            raise UserError(
                f"{where}: {key} is '{text}', which no file matches; there are "
                f"{', '.join(listed[:5]) or 'none'}"
            )
        found += fields.items()
        claimed.update(fields)
    return found


def _put(files: dict[str, str], segment: str, path: str, where: Path) -> None:
    if segment in files:
        raise UserError(
            f"{where}: '{files[segment]}' and '{path}' are both '{segment}' of one trial; expected "
            "a {trial}, {condition} or {segment} in the pattern that tells them apart"
        )
    files[segment] = path


def _existing(path: str, folder: Path) -> str:
    if not (folder / path).exists():
        raise UserError(f"{folder / FILE_NAME}: no file '{path}'")
    return path


def _applies(one: TrialSettings, key: Key) -> bool:
    wanted = (one.subject, one.condition, one.trial)
    return all(name in (None, own) for name, own in zip(wanted, key, strict=True))


def _settings(study: StudyFile, key: Key) -> TrialSettings:
    """The study's values, replaced by those of matching entries; later entries take precedence."""
    names = ("still_s", "walking_s", "straight", "start_pose")
    values = {name: getattr(study, name) for name in names}
    for one in study.trials:
        if _applies(one, key):
            values |= {n: v for n in names if (v := getattr(one, n)) is not None}
    return TrialSettings.model_validate(values)


def _of_trial(found: list[Match], key: Key, where: Path) -> dict[str, str]:
    """Files whose fields are those of a trial; fields that a pattern lacks match all."""
    chosen: dict[str, str] = {}
    for path, fields in found:
        names = zip(INDEX_COLUMNS, key, strict=True)
        if all(fields.get(column, own) == own for column, own in names):
            _put(chosen, fields.get("segment", "imu"), path, where)
    return chosen


def _layout(study: StudyFile, folder: Path) -> Layout | None:
    if study.device is not None:
        return read_layout(folder / study.device)
    where = f"{folder / FILE_NAME}: columns"
    return None if study.columns is None else layout_from(study.columns, where)


def _cut(one: ImuRecording, part_s: tuple[float, float], part: str, where: str) -> ImuRecording:
    inside = (one.time_s >= part_s[0]) & (one.time_s <= part_s[1])
    if inside.sum() < 2:
        raise RecordingError(
            f"{where}: calibration.{part} is {part_s[0]:g} to {part_s[1]:g} s, the recording has "
            f"{one.time_s[0]:g} to {one.time_s[-1]:g} s"
        )
    return ImuRecording(
        one.segment, one.time_s[inside], one.gyroscope_rad_s[inside], one.accelerometer_m_s2[inside]
    )


def _stands(
    imus: Mapping[str, ImuRecording], settings: TrialSettings
) -> tuple[tuple[tuple[float, float], ...], bool]:
    """Parts in which the wearer stands still, and whether the recording begins with one."""
    first = next(iter(imus.values()))
    begin = float(first.time_s[0])
    rest_s = first_rest_s([i.gyroscope_rad_s for i in imus.values()], first.sampling_rate_hz)
    rests = rest_s >= _MIN_REST_S
    if settings.still_s is None:
        return (((begin, begin + rest_s),) if rests else ()), rests
    one_or_more = np.atleast_2d(np.asarray(settings.still_s, dtype=float))
    return tuple((float(a), float(b)) for a, b in one_or_more), rests
