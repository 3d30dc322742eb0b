"""Identity of a run: configuration, code, and data.

A run's folder in a sweep is named by the overrides that vary and by this identity. The same
command therefore finds its finished runs again, and never those of another configuration.
"""

import functools
import hashlib
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf

from narx.files import code_sha256

# location and caching of recordings, and the stored progress of trainings, do not change a result
_WITHOUT_EFFECT = frozenset({"hydra", "data_root", "prepared", "resume"})
_NUMERICS = ("torch", "numpy", "scipy", "numba", "pandas")
# length of a folder's name; file systems allow 255 bytes
_LONGEST_NAME = 120


@functools.cache
def code_digest() -> str:
    """Digest of the package's sources and of the versions of its numerical libraries.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    # in an editable installation, baselines and experiments are links in the package
    return code_sha256([Path(__file__).parents[2]], _NUMERICS)


def settings_of(cfg: DictConfig) -> dict[str, Any]:
    """Resolve the part of a configuration on which a result depends.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        A command's configuration, with or without Hydra's own part.

    Returns
    -------
    dict
        Plain values, without the location of the data.
    """
    own = OmegaConf.masked_copy(cfg, [str(key) for key in cfg if key not in _WITHOUT_EFFECT])
    settings = OmegaConf.to_container(own, resolve=True)
    assert isinstance(settings, dict)
    return {str(key): value for key, value in settings.items()}


def flat_settings(cfg: DictConfig) -> dict[str, Any]:
    """Flatten a configuration to one value for each dotted key.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As for `settings_of`.

    Returns
    -------
    dict of str to object
        ``{"model.hidden": 3, ...}``; lists are kept as values.
    """
    return _flat(settings_of(cfg), "")


def _flat(settings: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def run_identity(cfg: DictConfig) -> str:
    """Digest of a resolved configuration and of the code.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        A command's configuration, with or without Hydra's own part.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    text = json.dumps(settings_of(cfg), sort_keys=True, default=str)
    return hashlib.sha256(f"{text}\0{code_digest()}".encode()).hexdigest()


def safe_name(text: str) -> str:
    """Convert a text to a name that is safe in any file system and shell.

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str
        Letters, digits and ``= , . _ + -``, not longer than a file name is allowed to be.
    """
    return re.sub(r"[^\w=,.+-]+", "_", text).strip("_.")[:_LONGEST_NAME]


def _run_folder(*, _root_: DictConfig) -> str:
    name = safe_name(_root_.hydra.job.override_dirname)
    return f"{name or 'run'}-{run_identity(_root_)[:8]}"


def _sweep_folder() -> str:
    # the launcher does not change the results of the jobs
    arguments = [a for a in sys.argv[1:] if not a.startswith(("-m", "--multirun", "hydra"))]
    digest = hashlib.sha256("\0".join(arguments).encode()).hexdigest()
    return f"{safe_name('+'.join(arguments)) or 'sweep'}-{digest[:8]}"


def register_resolvers() -> None:
    """Register ``${run_folder:}`` and ``${sweep_folder:}`` for configurations.

    The sweep's folder is derived from its command, so the same command finds it again. Hydra
    copies the resolved value to every job, wherever that job runs.
    """
    OmegaConf.register_new_resolver("run_folder", _run_folder, replace=True)
    OmegaConf.register_new_resolver("sweep_folder", _sweep_folder, use_cache=True, replace=True)
