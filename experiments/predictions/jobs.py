"""One of many recordings: its input, its output file, and its outcome."""

import hashlib
import json
import os
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import pandas as pd
from omegaconf import DictConfig, OmegaConf

from narx.datasets.base import TrialSource
from narx.datasets.segment_names import segment_of
from narx.errors import UserError
from narx.experiments.predictions.motion_bids_files import file_of_trial
from narx.experiments.predictions.session import predict_trial
from narx.experiments.predictions.single import predict_file
from narx.experiments.sources import combined_index, data_sha256, open_sources
from narx.files import safe_name, sha256_of
from narx.recordings.trial import side_of

# maximum length of a file name in bytes, in all common file systems
_LONGEST_NAME = 255
# options that do not change the content of an output file
_NOT_IN_KEY = ("input", "output", "jobs", "scheduler", "hydra")


@dataclass(frozen=True)
class Outcome:
    """Outcome of one recording.

    Parameters
    ----------
    file : str
        Input, relative to the common folder of all inputs; or source, subject, condition and trial.
    status : {"done", "incomplete", "refused"}
        Whether angles were computed; incomplete: without those of a missing sensor.
    reason : str
        Reason for the refusal, or what is missing; empty if done.
    n_samples, n_angles : int
        Number of samples in the output, and of those with angles.
    key : str
        Hash of the input and the options used.
    notes : str
        Notes on a recording that was read, separated by semicolons.
    """

    file: str
    status: str
    reason: str
    n_samples: int
    n_angles: int
    key: str
    notes: str = ""


@dataclass(frozen=True)
class Job:
    """A recording to predict; small, because it is sent to other processes.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    name : str
        As `Outcome.file`.
    target : pathlib.Path
        File for the angles.
    key : str
        Hash of the input and the options.
    """

    cfg: DictConfig
    name: str
    target: Path
    key: str

    def run(self) -> Outcome:
        """Predict the recording, and write the angles.

        Returns
        -------
        Outcome
            Outcome with status refused if the recording is invalid.
        """
        try:
            notes, n_samples, n_angles = self._predicted()
        except UserError as error:
            return Outcome(self.name, "refused", str(error), 0, 0, self.key)
        lacking = self._lacking()
        status = "incomplete" if lacking else "done"
        reason, remarks = "; ".join(lacking), "; ".join(notes)
        return Outcome(self.name, status, reason, n_samples, n_angles, self.key, remarks)

    @property
    def recordings(self) -> tuple[Path, ...]:
        """Files that it reads, as far as they are its own."""
        return ()

    def _lacking(self) -> list[str]:
        """What the recording lacks, for which some angles are missing."""
        return []

    def _predicted(self) -> tuple[tuple[str, ...], int, int]:
        raise NotImplementedError


@dataclass(frozen=True)
class FileJob(Job):
    """A file with one sensor.

    Parameters
    ----------
    cfg, name, target, key
        As of `Job`.
    file : pathlib.Path
        The recording; its name may contain the side.
    """

    file: Path

    @property
    def recordings(self) -> tuple[Path, ...]:
        """The recording."""
        return (self.file,)

    def _predicted(self) -> tuple[tuple[str, ...], int, int]:
        side = side_of(segment_of(self.file.stem)) or self.cfg.side
        prediction, n_angles = predict_file(self.cfg, self.file, self.target, side)
        return prediction.notes, len(prediction.time_s), n_angles


@dataclass(frozen=True)
class TrialJob(Job):
    """A trial of a source (``data=``), with all its sensors.

    Parameters
    ----------
    cfg, name, target, key
        As of `Job`.
    trial : tuple of str
        Source, subject, condition, trial.
    lacking : tuple of str
        Segments without a sensor in this trial, but with one in most trials of the source.
    """

    trial: tuple[str, str, str, str]
    lacking: tuple[str, ...] = ()

    def _lacking(self) -> list[str]:
        return [f"no sensor '{segment}', which most trials have" for segment in self.lacking]

    def _predicted(self) -> tuple[tuple[str, ...], int, int]:
        source, *names = self.trial
        trial = _sources(OmegaConf.to_yaml(self.cfg))[source].load(*names)
        session, n_angles = predict_trial(self.cfg, trial, self.target)
        return session.notes, len(session.time_s), n_angles


@lru_cache(maxsize=1)
def _sources(configuration: str) -> dict[str, TrialSource]:
    """Open the sources once per process."""
    cfg = OmegaConf.create(configuration)
    assert isinstance(cfg, DictConfig)
    return open_sources(cfg)


def file_jobs(cfg: DictConfig, folder: Path, root: Path, files: list[Path]) -> list[Job]:
    """Create a job for every file.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    folder, root : pathlib.Path
        Folder of the output, and common folder of the files.
    files : list of pathlib.Path
        The recordings.

    Returns
    -------
    list of Job
        Jobs in the order of the files.
    """
    options = _options(cfg)
    jobs: list[Job] = []
    for file in files:
        relative = file.relative_to(root)
        target = folder / relative.with_name(_name_of_angles(relative.name, cfg.format))
        jobs.append(FileJob(cfg, relative.as_posix(), target, _key(_state(file), options), file))
    return jobs


def _name_of_angles(file: str, ending: str) -> str:
    # the input's suffix stays in the name, since walk.csv and walk.mat are different recordings
    name, ending = file.replace(".", "_"), f"_angles.{ending}"
    if len(os.fsencode(name + ending)) > _LONGEST_NAME:
        name = safe_name(name, _LONGEST_NAME)
    return name + ending


def trial_jobs(cfg: DictConfig, folder: Path) -> list[Job]:
    """Create a job for every trial of the sources.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``, with ``data``.
    folder : pathlib.Path
        Folder of the output.

    Returns
    -------
    list of Job
        Jobs in the order of the index.

    Raises
    ------
    UserError
        If the recordings are not found, or two trials have the same name in the output.
    """
    sources = _sources(OmegaConf.to_yaml(cfg))
    digests = data_sha256(cfg)
    options = _options(cfg)
    jobs: list[Job] = []
    index = combined_index(sources)
    lacking = _lacking_segments(index)
    targets: set[Path] = set()
    for position, row in enumerate(index.itertuples(index=False)):
        names = str(row.source), str(row.subject), str(row.condition), str(row.trial)
        target = folder / _file_of_trial(names, cfg.format)
        if target in targets:
            raise UserError(f"data: two trials would be written as '{target}'; select one of them")
        targets.add(target)
        key = _key(f"{digests.get(names[0])}{names}{lacking[position]}", options)
        jobs.append(TrialJob(cfg, "/".join(names), target, key, names, lacking[position]))
    return jobs


def _file_of_trial(names: tuple[str, str, str, str], ending: str) -> Path:
    if ending == "motion_bids":
        return file_of_trial(*names[1:])
    return Path(
        *(safe_name(part) for part in names[:-1]), f"{safe_name(names[-1])}_angles.{ending}"
    )


def _lacking_segments(index: pd.DataFrame) -> list[tuple[str, ...]]:
    """Segments that each trial lacks and more than half of the trials of its source have."""
    if "segments" not in index:
        return [()] * len(index)
    own = [set(str(segments).split(", ")) for segments in index.segments.fillna("")]
    usual: dict[str, list[str]] = {}
    for source, group in index.groupby("source"):
        count = Counter(segment for k in group.index for segment in own[k] if segment)
        usual[str(source)] = sorted(s for s, times in count.items() if 2 * times > len(group))
    return [
        tuple(s for s in usual[str(source)] if s not in segments)
        for source, segments in zip(index.source, own, strict=True)
    ]


def key_of(state: str, cfg: DictConfig) -> str:
    """Hash an input and the options.

    Parameters
    ----------
    state : str
        Changes when the input does.
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.

    Returns
    -------
    str
        24 hexadecimal digits.
    """
    return _key(state, _options(cfg))


def _key(state: str, options: str) -> str:
    return hashlib.sha256(f"{state}{options}".encode()).hexdigest()[:24]


def _options(cfg: DictConfig) -> str:
    options = OmegaConf.to_container(cfg)
    assert isinstance(options, dict)
    kept = {str(k): v for k, v in options.items() if k not in _NOT_IN_KEY}
    for name in ("checkpoint", "device"):
        if kept.get(name) is not None and Path(str(kept[name])).is_file():
            kept[name] = sha256_of(str(kept[name]))
    return json.dumps(kept, sort_keys=True, default=str)


def _state(file: Path) -> str:
    try:
        status = file.stat()
    except OSError:
        return "unreadable"
    return f"{status.st_size}-{status.st_mtime_ns}"
