"""The record beside angles: with which options, network, code and data they were made."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from omegaconf import DictConfig

from narx.experiments.runs.identity import settings_of
from narx.experiments.runs.record import environment, write_json
from narx.files import sha256_of
from narx.inference.pretrained import load_or_pretrained

# how the work was shared out; the angles are the same
_WITHOUT_EFFECT = ("jobs", "scheduler")


def hashes_of(files: Iterable[Path]) -> dict[str, str]:
    """Hash recordings.

    Parameters
    ----------
    files : iterable of pathlib.Path
        Files, or folders, whose files are hashed one by one.

    Returns
    -------
    dict of str to str
        SHA-256 by path.
    """
    found = [sorted(file.rglob("*")) if file.is_dir() else [file] for file in files]
    return {str(one): sha256_of(one) for several in found for one in several if one.is_file()}


def write_provenance(
    cfg: DictConfig, path: Path, data_sha256: Mapping[str, str], notes: Sequence[str] = ()
) -> None:
    """Write the provenance of predicted angles as JSON.

    The content depends on options, code, machine and data alone: a repeated prediction gives the
    same bytes.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As ``configs/predict.yaml``.
    path : pathlib.Path
        Destination.
    data_sha256 : mapping of str to str
        Hash of each recording or source.
    notes : sequence of str
        What was done to the recordings.

    Raises
    ------
    UserError
        If the network cannot be loaded.
    """
    settings = settings_of(cfg)
    write_json(
        {
            "configuration": {k: v for k, v in settings.items() if k not in _WITHOUT_EFFECT},
            "network_sha256": load_or_pretrained(cfg.checkpoint).sha256,
            "notes": list(notes),
            "environment": _without_command(environment(None, data_sha256)),
        },
        path,
    )


def _without_command(about: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in about.items() if key not in ("command", "seed")}
