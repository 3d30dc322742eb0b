"""Content of a `study.yaml`: subject, trial, segment and sensor of every file."""

from pathlib import Path
from typing import Any, Literal

import yaml
from pydantic import BaseModel

from narx.errors import UserError
from narx.recordings.input_file import regular_file
from narx.recordings.session_clock import Alignment
from narx.settings.checked import CONFIG, validated
from narx.settings.values import Interval, Name, Names, SamplingRate

FILE_NAME = "study.yaml"
StartPose = Literal["auto", "known", "unknown"]


class _Section(BaseModel):
    model_config = CONFIG


class ReferenceFiles(_Section):
    """Orientations from an optical system, as quaternions over time.

    ``files`` are patterns with ``{segment}``; ``quaternion`` are the names of the columns w, x, y,
    z; ``time`` names the column of time in a study's own way. ``frame`` is that of the markers: on
    the sensor, or on the segment (x forward, y left, z up). ``rotates`` tells from which frame to
    which the quaternion rotates a vector.
    """

    files: Names
    frame: Literal["sensor", "anatomical"] = "sensor"
    time: Any = "time_{unit}"
    quaternion: tuple[Name, Name, Name, Name] = (
        "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z",
    )  # fmt: skip
    rotates: Literal["to_global", "from_global"] = "to_global"


class TrialSettings(_Section):
    """Settings of selected trials; omitted names match every trial."""

    subject: Name | None = None
    condition: Name | None = None
    trial: Name | None = None
    files: dict[Name, Name] | None = None
    left_out: bool = False
    still_s: Interval | tuple[Interval, ...] | None = None
    walking_s: Interval | None = None
    straight: bool | None = None
    start_pose: StartPose | None = None


class StudyFile(_Section):
    """As ``study.yaml`` (docs/own_recordings.md)."""

    files: Names | None = None
    subject: Name = "1"
    condition: Name = "walk"
    trial: Name = "1"
    segments: dict[Name, Name] = {}
    columns: dict[Name, Any] | None = None
    device: Name | None = None
    sampling_rate_hz: SamplingRate | None = None
    align: Alignment = "auto"
    calibration: dict[Name, Interval | Name] = {}
    reference: ReferenceFiles | None = None
    still_s: Interval | tuple[Interval, ...] | None = None
    walking_s: Interval | None = None
    straight: bool = False
    start_pose: StartPose = "auto"
    trials: tuple[TrialSettings, ...] = ()


def read_study_file(folder: Path) -> StudyFile:
    """Read the description of a study.

    Parameters
    ----------
    folder : pathlib.Path
        Folder with ``study.yaml``.

    Returns
    -------
    StudyFile
        Its content, checked.

    Raises
    ------
    UserError
        If the file is missing or no YAML, or a key or value is wrong; the message is one line with
        the key, what was found and what is expected.
    """
    path = folder / FILE_NAME
    try:
        content = yaml.safe_load(regular_file(path).read_text(encoding="utf-8-sig"))
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:160]
        raise UserError(f"{path}: not YAML ({reason})") from None
    if not isinstance(content, dict):
        raise UserError(f"{path}: holds no mapping, expected keys such as files and segments")
    values = {str(key): value for key, value in content.items()}
    try:
        study = validated(StudyFile, values, f"{path}: ")
    except RecursionError:
        raise UserError(f"{path}: an alias (*name) contains itself") from None
    assert isinstance(study, StudyFile)
    if study.files is None and not any(one.files for one in study.trials):
        raise UserError(f"{path}: no files, expected a pattern such as {{subject}}/{{segment}}.csv")
    if study.columns is not None and study.device is not None:
        raise UserError(f"{path}: columns and device are both given, expected one of them")
    return study
