"""Predict many recordings: files of a folder, or trials of a source; interruptions are resumed."""

import contextlib
import json
from dataclasses import asdict
from pathlib import Path

import pandas as pd
from omegaconf import DictConfig
from tqdm import tqdm

from narx.datasets.apdm_file import SUFFIXES as APDM_SUFFIXES
from narx.errors import UserError
from narx.experiments.predictions.jobs import Job, Outcome, file_jobs
from narx.experiments.predictions.motion_bids_files import write_description
from narx.experiments.predictions.provenance import hashes_of, write_provenance
from narx.experiments.predictions.workers import outcomes
from narx.experiments.sources import data_sha256
from narx.files import atomic_path, remove_temporaries
from narx.inference.pretrained import load_or_pretrained
from narx.recordings.input_file import is_bundle

READABLE = (".csv", ".txt", ".tsv", ".parquet", ".pq", ".mat", ".zip", ".gz", *APDM_SUFFIXES)
SUMMARY, RECORD, JOURNAL = "summary.csv", "record.json", ".finished.jsonl"
# a temporary file older than this belongs to no running process
_ABANDONED_S = 3600.0


def is_bulk(value: str) -> bool:
    """Return whether an input denotes many files.

    Parameters
    ----------
    value : str
        A folder or a pattern with ``*``, ``?`` or ``[``; a phone app's folder is one recording.

    Returns
    -------
    bool
        True for many files.
    """
    path = Path(value)
    if path.is_dir():
        return not is_bundle(path)
    return any(letter in value for letter in "*?[") and not path.exists()


def jobs_of_files(cfg: DictConfig, folder: Path) -> list[Job]:
    """Create a job for every recording in a folder or matching a pattern.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``, with ``input``.
    folder : pathlib.Path
        Folder of the output; files written there by an earlier run are not recordings.

    Returns
    -------
    list of Job
        Jobs in the order of the names.

    Raises
    ------
    UserError
        If there is no file, or the output is the folder of the input or above it.
    """
    value = str(cfg.input)
    path = Path(value)
    if path.is_dir():
        root, found = path, path.rglob("*")
    else:
        parts = path.parts
        fixed = next(k for k, part in enumerate(parts) if any(c in part for c in "*?["))
        if ".." in parts[fixed:]:
            # a result is written under its input's name below the output folder
            raise UserError(f"input: '{value}' has '..' after a wildcard, expected only before")
        root = Path(*parts[:fixed]) if fixed else Path()
        found = root.glob(str(Path(*parts[fixed:])))
    written = folder.resolve()
    if written in (root.resolve(), *root.resolve().parents):
        raise UserError(f"output: '{folder}' is also the input, or above it; expected another name")
    files = sorted(
        file
        for file in found
        if file.suffix.lower() in READABLE
        and not file.name.startswith(".")
        and not file.is_dir()
        and written not in file.resolve().parents
    )
    if not files:
        raise UserError(f"input: no file in '{value}' that ends in {', '.join(READABLE)}")
    return file_jobs(cfg, folder, root, files)


def run_all(jobs: list[Job], folder: Path, cfg: DictConfig) -> None:
    """Predict every recording, and write a table with the outcome of each.

    Parameters
    ----------
    jobs : list of Job
        Jobs to run.
    folder : pathlib.Path
        Folder for the angles, for ``summary.csv`` and for ``record.json``.
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``: ``jobs`` and ``scheduler``.

    Raises
    ------
    UserError
        If the folder is a file; or, after all others are done, if some recordings were refused or
        lack a sensor.
    """
    if folder.exists() and not folder.is_dir():
        raise UserError(f"output: '{folder}' is a file, expected a folder for many recordings")
    for name in (SUMMARY, RECORD, JOURNAL):
        if (folder / name).is_dir():
            raise UserError(f"output: '{folder / name}' is a folder, expected another output")
    folder.mkdir(parents=True, exist_ok=True)
    remove_temporaries(folder, _ABANDONED_S)
    load_or_pretrained(cfg.checkpoint)  # refuses a bad network at once, not with every recording
    if cfg.format == "motion_bids":
        write_description(folder)
    earlier = _finished(folder)
    done: dict[str, Outcome] = {}
    for job in jobs:
        known = earlier.get(job.name)
        if known and known.key == job.key and (known.status == "refused" or job.target.exists()):
            done[job.name] = known
    missing = [job for job in jobs if job.name not in done]
    if len(missing) < len(jobs):
        print(f"{len(jobs) - len(missing)} of {len(jobs)} files finished before, left as they are")
    # closed at once after Ctrl-C, which ends its processes
    with contextlib.closing(outcomes(missing, cfg.jobs, cfg.scheduler)) as running:
        for outcome in tqdm(running, total=len(missing), unit="file", disable=None):
            done[outcome.file] = outcome
            with open(folder / JOURNAL, "a", encoding="utf-8") as journal:
                journal.write(json.dumps(asdict(outcome)) + "\n")
    # what was refused may be too large to read, or endless
    read = [file for job in jobs if done[job.name].status != "refused" for file in job.recordings]
    write_provenance(cfg, folder / RECORD, hashes_of(dict.fromkeys(read)) | data_sha256(cfg))
    table = pd.DataFrame([asdict(done[job.name]) for job in jobs])
    with atomic_path(folder / SUMMARY) as temporary:
        table.drop(columns="key").to_csv(temporary, index=False)
    refused, incomplete = (table[table.status == name] for name in ("refused", "incomplete"))
    print(f"{folder / SUMMARY}: {len(table) - len(refused)} of {len(table)} files with angles")
    problems = []
    if len(refused):
        problems.append(
            f"{len(refused)} of {len(table)} files refused, all others are done; the first: "
            f"{refused.reason.iloc[0]}"
        )
    if len(incomplete):
        problems.append(
            f"{len(incomplete)} of {len(table)} recordings incomplete; the first: "
            f"{incomplete.file.iloc[0]}: {incomplete.reason.iloc[0].split('; ')[0]}"
        )
    if problems:
        raise UserError(f"{'; '.join(problems)} ({folder / SUMMARY})")


def _finished(folder: Path) -> dict[str, Outcome]:
    """Read the journal; a line truncated by a kill is ignored."""
    path = folder / JOURNAL
    found: dict[str, Outcome] = {}
    if path.is_file():
        for line in path.read_text("utf-8", errors="replace").splitlines():
            try:
                outcome = Outcome(**json.loads(line))
            except (ValueError, TypeError):
                continue
            found[outcome.file] = outcome
    return found
