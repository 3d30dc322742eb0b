"""What makes two runs the same: configuration, code, and data.

A run's folder in a sweep is named by the overrides that vary and by this identity, so that the
same command finds its finished runs again and never meets those of another configuration.
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

# where recordings lie, what is kept of them and of a training do not change a result
_WITHOUT_EFFECT = frozenset({"hydra", "data_root", "prepared", "resume"})
_NUMERICS = ("torch", "numpy", "scipy", "numba", "pandas")
# of a folder's name; file systems allow 255 bytes
_LONGEST_NAME = 120


@functools.cache
def code_digest() -> str:
    """Digest of the package's sources and of the versions of what it computes with.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    # baselines and experiments are linked into the package where it is installed editable
    return code_sha256([Path(__file__).parents[2]], _NUMERICS)


def settings_of(cfg: DictConfig) -> dict[str, Any]:
    """Resolve the part of a configuration that a result depends on.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        A command's configuration, with or without Hydra's own part.

    Returns
    -------
    dict
        Plain values, without the place of the data.
    """
    own = OmegaConf.masked_copy(cfg, [str(key) for key in cfg if key not in _WITHOUT_EFFECT])
    settings = OmegaConf.to_container(own, resolve=True)
    assert isinstance(settings, dict)
    return {str(key): value for key, value in settings.items()}


def flat_settings(cfg: DictConfig) -> dict[str, Any]:
    """Resolve a configuration into one value for each dotted key.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        As for `settings_of`.

    Returns
    -------
    dict of str to object
        ``{"model.hidden": 3, ...}``; lists stay whole.
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
    """Make a name that any file system and shell takes as it is.

    Parameters
    ----------
    text : str
        Anything.

    Returns
    -------
    str
        Letters, digits and ``= , . _ + -``, not longer than a file name may be.
    """
    return re.sub(r"[^\w=,.+-]+", "_", text).strip("_.")[:_LONGEST_NAME]


def _run_folder(*, _root_: DictConfig) -> str:
    name = safe_name(_root_.hydra.job.override_dirname)
    return f"{name or 'run'}-{run_identity(_root_)[:8]}"


def _sweep_folder() -> str:
    # how jobs are launched does not change what they find
    arguments = [a for a in sys.argv[1:] if not a.startswith(("-m", "--multirun", "hydra"))]
    digest = hashlib.sha256("\0".join(arguments).encode()).hexdigest()
    return f"{safe_name('+'.join(arguments)) or 'sweep'}-{digest[:8]}"


def register_resolvers() -> None:
    """Make ``${run_folder:}`` and ``${sweep_folder:}`` known to configurations.

    The sweep's folder is that of its command, so the same command finds it again. Hydra copies
    what was resolved once to every job, wherever that runs.
    """
    OmegaConf.register_new_resolver("run_folder", _run_folder, replace=True)
    OmegaConf.register_new_resolver("sweep_folder", _sweep_folder, use_cache=True, replace=True)
