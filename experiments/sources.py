"""Open the trial sources of the configuration's `data`: recordings on disk, or the simulator."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import pooch
from hydra.utils import get_class, instantiate
from omegaconf import DictConfig, OmegaConf

from narx.datasets.base import TrialSource
from narx.datasets.prepared import PreparedSource, TrialStore
from narx.errors import UserError
from narx.files import files_sha256, sha256_of


def open_sources(cfg: DictConfig) -> dict[str, TrialSource]:
    """Open every source named in the configuration.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `data` (constructor of each source by name) and `data_root` (folder with one subfolder
        per source, or null for the download cache); `select` filters by subject, condition, trial.

    Returns
    -------
    dict of str to TrialSource
        By source name.

    Raises
    ------
    UserError
        If the data root does not exist or a selection contains an unknown name.
    """
    root = None if cfg.data_root is None else Path(cfg.data_root).expanduser()
    if root is not None and not root.is_dir():
        raise UserError(f"data_root: no folder '{root}'; expected one with a subfolder per source")
    sources: dict[str, TrialSource] = {}
    for name, constructor in _constructors(cfg).items():
        overrides = {}
        if root is not None and "root" in constructor and constructor.root is None:
            overrides["root"] = str(_folder(root, name))
        made = instantiate(constructor, _convert_="all", **overrides)
        source = _prepared(cfg, name, constructor, made)
        selection = OmegaConf.to_container(cfg.select) if cfg.get("select") else {}
        assert isinstance(selection, Mapping)
        wanted = {str(key): value for key, value in selection.items() if value is not None}
        if wanted:
            source = source.select(**wanted)
        sources[str(name)] = source
    return sources


def _prepared(
    cfg: DictConfig, name: str, constructor: DictConfig, source: TrialSource
) -> TrialSource:
    if "prepared" not in cfg or cfg.prepared.limit_gb <= 0:
        return source
    store = TrialStore(_store_folder(cfg.prepared.folder), cfg.prepared.limit_gb * 1e9)
    settings = OmegaConf.to_yaml(constructor, resolve=True, sort_keys=True)
    recordings = _recordings_sha256(cfg, name, constructor)
    return PreparedSource(source, f"{settings}\0{recordings}", store)


def _store_folder(given: str | Path | None) -> Path:
    folder = Path(pooch.os_cache("narx")) / "prepared" if given is None else Path(given)
    folder = folder.expanduser()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):  # permissions alone do not tell
            pass
    except OSError as error:
        raise UserError(
            f"prepared.folder: '{folder}' cannot be written ({error.strerror}); expected a "
            "writable folder (also in NARX_PREPARED), or prepared.limit_gb=0"
        ) from error
    return folder


def _constructors(cfg: DictConfig) -> dict[str, DictConfig]:
    """Sections of the sources in `data`, without its seed."""
    return {str(k): v for k, v in cfg.get("data", {}).items() if isinstance(v, DictConfig)}


def data_sha256(cfg: DictConfig) -> dict[str, str]:
    """Compute a digest of the recordings and networks that a run may read.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As for `open_sources`; a command without `data` has none.

    Returns
    -------
    dict of str to str
        SHA-256 over the names and contents of all files of each source, by its name; sources that
        are simulated or not yet downloaded are left out. That of a trained network that is used
        or started from, by its key.
    """
    recordings = {
        name: digest
        for name, constructor in _constructors(cfg).items()
        if (digest := _recordings_sha256(cfg, name, constructor)) is not None
    }
    networks = {
        key: sha256_of(path)
        for key in ("checkpoint", "training.start")
        if (path := OmegaConf.select(cfg, key)) is not None and Path(path).is_file()
    }
    return recordings | networks


def _recordings_sha256(cfg: DictConfig, name: str, constructor: DictConfig) -> str | None:
    if "root" not in constructor:
        return None
    root = constructor.root
    if root is None:
        parent = pooch.os_cache("narx") if cfg.data_root is None else cfg.data_root
        root = _folder(Path(parent).expanduser(), name)
    folder = Path(root).expanduser()
    if not folder.is_dir():
        return None
    source: type[TrialSource] = get_class(constructor["_target_"])
    return files_sha256(folder, source.files(folder))


def _folder(root: Path, name: str) -> Path:
    """Folder of a source: below the data root, or that itself if it holds the description."""
    return root if (root / f"{name}.yaml").is_file() else root / name


def combined_index(sources: Mapping[str, TrialSource]) -> pd.DataFrame:
    """List the trials of all sources, with `source` as the first column.

    Parameters
    ----------
    sources : mapping of str to TrialSource
        By source name.

    Returns
    -------
    pandas.DataFrame
        Columns source, subject, condition, trial, and further columns of the sources.
    """
    frames = []
    for name, source in sources.items():
        frame = source.index()
        frame.insert(0, "source", name)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)
