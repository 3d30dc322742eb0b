"""Many recordings at once: a folder or a pattern, taken up again where it was left."""

import hashlib
import json
import multiprocessing
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd
from omegaconf import DictConfig, OmegaConf
from tqdm import tqdm

from narx.datasets.segment_names import segment_of
from narx.errors import UserError
from narx.experiments.predictions.single import predict_file
from narx.files import atomic_path, remove_temporaries, safe_name, sha256_of
from narx.recordings.trial import side_of

READABLE = (".csv", ".txt", ".tsv", ".parquet", ".pq", ".mat", ".zip")
SUMMARY, JOURNAL = "summary.csv", ".finished.jsonl"
# bytes of a file name, in all common file systems
_LONGEST_NAME = 255
# a temporary file this old belongs to no process that is still at work
_ABANDONED_S = 3600.0
# options that do not change what is in a file
_NOT_IN_KEY = ("input", "output", "jobs", "hydra")


@dataclass(frozen=True)
class Outcome:
    """What became of one file.

    Parameters
    ----------
    file : str
        Input, below the folder that all have in common.
    status : {"done", "refused"}
        Whether there are angles.
    reason : str
        Why not, or the notes.
    n_samples, n_angles : int
        Samples in the output, and those of them with angles.
    key : str
        Hash of the input and the options that it was made with.
    """

    file: str
    status: str
    reason: str
    n_samples: int
    n_angles: int
    key: str


def is_bulk(value: str) -> bool:
    """Tell whether an input names many files.

    Parameters
    ----------
    value : str
        A folder or a pattern with ``*``, ``?`` or ``[``; a phone app's folder is one recording.

    Returns
    -------
    bool
        True for many.
    """
    path = Path(value)
    if path.is_dir():
        return not any(path.glob("Gyroscope*.csv"))
    return any(letter in value for letter in "*?[") and not path.exists()


def predict_all(cfg: DictConfig, folder: Path) -> None:
    """Predict every file, and write a table of what became of each.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    folder : pathlib.Path
        Where the angles go, under the inputs' names, and ``summary.csv``.

    Raises
    ------
    UserError
        If there is no file; at the end, if some were refused.
    """
    root, files = _files(str(cfg.input), folder)
    if folder.exists() and not folder.is_dir():
        raise UserError(f"output: '{folder}' is a file, expected a folder for many recordings")
    folder.mkdir(parents=True, exist_ok=True)
    remove_temporaries(folder, _ABANDONED_S)
    options = _options_hash(cfg)
    keys = {file: _key(file, options) for file in files}
    targets = {file: _target(cfg, folder, root, file) for file in files}
    earlier = _finished(folder)
    outcomes: dict[Path, Outcome] = {}
    for file in files:
        known = earlier.get(_name(root, file))
        if (
            known
            and known.key == keys[file]
            and (known.status == "refused" or targets[file].exists())
        ):
            outcomes[file] = known
    missing = [file for file in files if file not in outcomes]
    if len(missing) < len(files):
        print(
            f"{len(files) - len(missing)} of {len(files)} files finished before, left as they are"
        )
    jobs = [(cfg, root, file, targets[file], keys[file]) for file in missing]
    with open(folder / JOURNAL, "a", encoding="utf-8") as journal:
        progress = tqdm(_run(jobs, _n_workers(cfg, len(jobs))), total=len(jobs), unit="file",
                        disable=None)  # fmt: skip
        for file, outcome in progress:
            outcomes[file] = outcome
            journal.write(json.dumps(asdict(outcome)) + "\n")
            journal.flush()
    table = pd.DataFrame([asdict(outcomes[file]) for file in files])
    with atomic_path(folder / SUMMARY) as temporary:
        table.drop(columns="key").to_csv(temporary, index=False)
    refused = table[table.status == "refused"]
    print(f"{folder / SUMMARY}: {len(table) - len(refused)} of {len(table)} files with angles")
    if len(refused):
        first = refused.iloc[0]
        raise UserError(
            f"{len(refused)} of {len(table)} files refused, all others are done; the first: "
            f"{first.reason} ({folder / SUMMARY})"
        )


def _files(value: str, output: Path) -> tuple[Path, list[Path]]:
    """Folder in common and the recordings in it; what an earlier run wrote is none."""
    path = Path(value)
    if path.is_dir():
        root, found = path, path.rglob("*")
    else:
        parts = path.parts
        fixed = next(k for k, part in enumerate(parts) if any(c in part for c in "*?["))
        if ".." in parts[fixed:]:
            # a result is written under its input's name below the output folder
            raise UserError(f"input: '{value}' has '..' behind a wildcard, expected it before")
        root = Path(*parts[:fixed]) if fixed else Path()
        found = root.glob(str(Path(*parts[fixed:])))
    files = sorted(
        file
        for file in found
        if file.suffix.lower() in READABLE
        and not file.is_dir()
        and not file.name.startswith(".")
        and output.resolve() not in file.resolve().parents
    )
    if not files:
        raise UserError(f"input: no file in '{value}' that ends in {', '.join(READABLE)}")
    return root, files


def _name(root: Path, file: Path) -> str:
    return file.relative_to(root).as_posix()


def _target(cfg: DictConfig, folder: Path, root: Path, file: Path) -> Path:
    # the input's suffix stays in the name: walk.csv and walk.mat are two recordings
    relative = file.relative_to(root)
    name, ending = relative.name.replace(".", "_"), f"_angles.{cfg.format}"
    if len(os.fsencode(name + ending)) > _LONGEST_NAME:
        name = safe_name(name, _LONGEST_NAME)
    return folder / relative.with_name(name + ending)


def _options_hash(cfg: DictConfig) -> str:
    options = OmegaConf.to_container(cfg)
    assert isinstance(options, dict)
    kept = {str(k): v for k, v in options.items() if k not in _NOT_IN_KEY}
    for name in ("checkpoint", "device"):
        if kept.get(name) is not None and Path(str(kept[name])).is_file():
            kept[name] = sha256_of(str(kept[name]))
    return json.dumps(kept, sort_keys=True, default=str)


def _key(file: Path, options: str) -> str:
    try:
        status = file.stat()
        state = f"{status.st_size}-{status.st_mtime_ns}"
    except OSError:
        state = "unreadable"
    return hashlib.sha256(f"{state}{options}".encode()).hexdigest()[:24]


def _finished(folder: Path) -> dict[str, Outcome]:
    """Read the journal; a line that a kill cut off is left out."""
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


def _n_workers(cfg: DictConfig, n_jobs: int) -> int:
    # a worker's start takes as long as a dozen files
    wanted = cfg.jobs or (os.cpu_count() or 1 if n_jobs >= 50 else 1)
    return max(1, min(int(wanted), n_jobs))


Job = tuple[DictConfig, Path, Path, Path, str]


def _run(jobs: Iterable[Job], n_workers: int) -> Iterator[tuple[Path, Outcome]]:
    if n_workers == 1:
        for job in jobs:
            yield _one(job)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(n_workers, mp_context=context, initializer=_alone) as pool:
        for finished in as_completed([pool.submit(_one, job) for job in jobs]):
            yield finished.result()


def _alone() -> None:
    """Let a worker use one core: there are as many workers as cores."""
    import torch

    torch.set_num_threads(1)


def _one(job: Job) -> tuple[Path, Outcome]:
    cfg, root, file, target, key = job
    name = _name(root, file)
    side = side_of(segment_of(file.stem)) or cfg.side
    try:
        prediction, n_angles = predict_file(cfg, file, target, side)
    except UserError as error:
        return file, Outcome(name, "refused", str(error), 0, 0, key)
    notes = "; ".join(prediction.notes)
    return file, Outcome(name, "done", notes, len(prediction.time_s), n_angles, key)
