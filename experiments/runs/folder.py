"""A run's folder: locked by one process, marked as finished last, then never written to again."""

import json
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, OmegaConf

from narx.errors import UserError
from narx.experiments.runs.identity import code_digest, flat_settings, run_identity
from narx.experiments.runs.record import write_json
from narx.files import atomic_path, remove_temporaries

RECORD = "run.json"
_LOCK = ".lock"
_TRACEBACK = "traceback.txt"
_PATIENCE_S = 600.0


@dataclass
class Run:
    """A run in its folder.

    Parameters
    ----------
    folder : pathlib.Path
        Folder for all output of the run.
    record : dict
        Content of ``run.json``: ``state`` (``started``, ``failed``, ``interrupted``,
        ``finished``), ``identity``, ``code``, ``data_sha256``, and ``value`` once finished.
    """

    folder: Path
    record: dict[str, Any]

    @property
    def finished(self) -> bool:
        """Whether the run is complete."""
        return self.record["state"] == "finished"

    def end(self, state: str, **further: object) -> None:
        """Record how the run has ended; after ``finished`` nothing more is written.

        Parameters
        ----------
        state : {"finished", "failed", "interrupted"}
            Final state.
        **further : object
            Further entries of the record.
        """
        self.record |= {"state": state, **further}
        write_json(self.record, self.folder / RECORD)


def read_record(folder: Path) -> dict[str, Any] | None:
    """Read the record of a run.

    Parameters
    ----------
    folder : pathlib.Path
        The run's folder.

    Returns
    -------
    dict or None
        Content of ``run.json``; None if there is none.

    Raises
    ------
    UserError
        If the file is not such a record.
    """
    path = folder / RECORD
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(record["identity"], str) or not isinstance(record["state"], str):
            raise TypeError("identity and state must be text")
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: not the record of a run ({error})") from error
    return dict(record)


def is_abandoned(folder: Path) -> bool:
    """Tell whether a run was started and no process is working on it.

    Parameters
    ----------
    folder : pathlib.Path
        The run's folder.

    Returns
    -------
    bool
        False if the run has ended, or a process holds the folder's lock.

    Raises
    ------
    UserError
        If ``run.json`` is not the record of a run.
    """
    record = read_record(folder)
    if record is None or record["state"] != "started":
        return False
    lock = FileLock(folder / _LOCK)
    try:
        with lock.acquire(timeout=0):
            return True
    except Timeout:
        return False


@contextmanager
def claimed(folder: Path, cfg: DictConfig, data_sha256: Mapping[str, str]) -> Iterator[Run]:
    """Lock a folder for a run, and record how the run ends.

    Parameters
    ----------
    folder : pathlib.Path
        The run's folder.
    cfg : omegaconf.DictConfig
        Configuration of the run.
    data_sha256 : mapping of str to str
        Digest of the recordings and networks it reads, by source or key.

    Yields
    ------
    Run
        An already finished run, or a run to carry out; the caller of the latter ends with
        ``run.end("finished")``.

    Raises
    ------
    UserError
        If the folder contains a finished run of another configuration, code or data, or another
        process is using it.
    """
    wanted = {
        "state": "started",
        "identity": run_identity(cfg),
        "code": code_digest(),
        "data_sha256": dict(data_sha256),
    }
    found = _same_run(folder, wanted, cfg)
    if found is not None and found["state"] == "finished":
        yield Run(folder, found)
        return
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / _LOCK)
    _wait_for(lock, folder)
    try:
        found = _same_run(folder, wanted, cfg)  # may have finished while waiting
        if found is not None and found["state"] == "finished":
            yield Run(folder, found)
            return
        remove_temporaries(folder)
        run = Run(folder, wanted)
        _write_configuration(folder, cfg)
        write_json(run.record, folder / RECORD)
        (folder / _TRACEBACK).unlink(missing_ok=True)
        with _end_recorded(run):
            yield run
    finally:
        (folder / _LOCK).unlink(missing_ok=True)
        lock.release()


def _wait_for(lock: FileLock, folder: Path) -> None:
    try:
        lock.acquire(timeout=0)
    except Timeout:
        print(f"{folder}: another process is using this folder, waiting for it", flush=True)
        try:  # for example, a worker whose sweep was killed finishes its job
            lock.acquire(timeout=_PATIENCE_S)
        except Timeout:
            raise UserError(f"{folder}: another process is using this folder") from None


@contextmanager
def _end_recorded(run: Run) -> Iterator[None]:
    try:
        yield
    except UserError as error:
        run.end("failed", reason=str(error))
        raise
    except Exception as error:
        with atomic_path(run.folder / _TRACEBACK) as temporary:
            temporary.write_text(traceback.format_exc(), encoding="utf-8")
        run.end("failed", reason=f"{type(error).__name__}: {error}")
        raise
    except BaseException:
        run.end("interrupted")
        raise


def _same_run(folder: Path, wanted: Mapping[str, Any], cfg: DictConfig) -> dict[str, Any] | None:
    found = read_record(folder)
    if found is None or all(found.get(k) == wanted[k] for k in ("identity", "data_sha256")):
        return found
    if found["state"] != "finished":
        return None  # an unfinished run may be overwritten
    if found.get("code") != wanted["code"]:
        difference = "made by another version of the code"
    elif found["identity"] != wanted["identity"]:
        difference = f"of another configuration ({_first_difference(folder, cfg)})"
    else:
        difference = "on other data"
    raise UserError(f"{folder}: holds a finished run {difference}, expected another folder")


def _first_difference(folder: Path, cfg: DictConfig) -> str:
    found = OmegaConf.load(folder / ".hydra" / "config.yaml")
    assert isinstance(found, DictConfig)
    there, here = flat_settings(found), flat_settings(cfg)
    for key in dict.fromkeys([*here, *there]):
        if here.get(key) != there.get(key):
            return f"{key} was {there.get(key)}, now {here.get(key)}"
    return "settings differ"


def _write_configuration(folder: Path, cfg: DictConfig) -> None:
    # not by Hydra itself, which would overwrite the files of a finished run before it is recognised
    hydra = HydraConfig.get()
    for name, content in (
        ("config", cfg),
        ("hydra", OmegaConf.create({"hydra": hydra})),
        ("overrides", hydra.overrides.task),
    ):
        with atomic_path(folder / ".hydra" / f"{name}.yaml") as temporary:
            OmegaConf.save(content, temporary)
