"""Provenance of a result besides its configuration: seed, versions, commit, data."""

import json
import math
import os
import platform
import random
import subprocess
import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

import numpy as np
import torch

from narx.files import atomic_path

_PACKAGES = (
    "narx-orientation", "torch", "numpy", "scipy", "pandas", "numba", "hydra-core",
    "tensorboard", "matplotlib", "vqf", "ahrs",
)  # fmt: skip


def seed_everything(seed: int) -> None:
    """Seed Python, numpy and torch.

    Parameters
    ----------
    seed : int
        Any non-negative integer.
    """
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - libraries that still use the legacy generator
    torch.manual_seed(seed)


def environment(seed: int | None, sources: Mapping[str, str]) -> dict[str, object]:
    """Describe the provenance of a result besides its configuration.

    Parameters
    ----------
    seed : int, optional
        The run's seed; None where nothing is drawn.
    sources : mapping of str to str
        SHA-256 of each data file.

    Returns
    -------
    dict
        Versions, processor, git commit (None outside a repository), seed, data hashes.
    """
    versions: dict[str, str | None] = {}
    for package in _PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = None
    return {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "processor_count": os.cpu_count(),
        "versions": versions,
        "git_commit": _git("rev-parse", "HEAD"),
        "git_dirty": bool(_git("status", "--porcelain", "--untracked-files=no")),
        "seed": seed,
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "data_sha256": dict(sorted(sources.items())),
    }


def _git(*arguments: str) -> str | None:
    here = Path(__file__).resolve().parent
    try:
        answer = subprocess.run(
            ["git", *arguments], cwd=here, capture_output=True, text=True, check=True, timeout=10
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()


def write_json(content: object, path: Path) -> None:
    """Write a JSON file atomically.

    Parameters
    ----------
    content : object
        Mappings, sequences, strings and numbers. Numbers that are not finite become null: JSON has
        no NaN, and other readers refuse a file that contains one.
    path : pathlib.Path
        Destination.
    """
    with atomic_path(path) as temporary:
        text = json.dumps(_finite_or_none(content), indent=2, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def _finite_or_none(content: object) -> object:
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, Mapping):
        return {key: _finite_or_none(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite_or_none(value) for value in content]
    return content
