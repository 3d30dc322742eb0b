"""The record beside angles: with which options, network, code and data they were made."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from omegaconf import DictConfig

from narx.experiments.runs.identity import settings_of
from narx.experiments.runs.record import environment, write_json
from narx.files import sha256_of
from narx.inference.pretrained import load_or_pretrained

# how the work was shared out; the angles are the same
_WITHOUT_EFFECT = ("jobs", "scheduler")


def write_provenance(
    cfg: DictConfig, path: Path, files: Sequence[Path] = (), notes: Sequence[str] = ()
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
    files : sequence of pathlib.Path
        Recordings that were read. The files of a folder are listed one by one.
    notes : sequence of str
        What was done to the recordings.

    Raises
    ------
    UserError
        If the network cannot be loaded.
    """
    found = [sorted(file.rglob("*")) if file.is_dir() else [file] for file in files]
    sources = {str(one): sha256_of(one) for several in found for one in several if one.is_file()}
    settings = settings_of(cfg)
    write_json(
        {
            "configuration": {k: v for k, v in settings.items() if k not in _WITHOUT_EFFECT},
            "network_sha256": load_or_pretrained(cfg.checkpoint).sha256,
            "notes": list(notes),
            "environment": _without_command(environment(None, sources)),
        },
        path,
    )


def _without_command(about: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in about.items() if key not in ("command", "seed")}
