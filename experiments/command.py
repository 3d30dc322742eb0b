"""What every command shares: its errors, its seed, and the record of its environment."""

import contextlib
import functools
import json
import os
import platform
import random
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib import metadata
from pathlib import Path

import hydra
import numpy as np
import torch
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from narx.errors import UserError
from narx.files import atomic_path

CONFIG_PATH = "pkg://narx.configs"
USER_ERROR_STATUS = 2

_PACKAGES = (
    "narx-orientation", "torch", "numpy", "scipy", "pandas", "numba", "hydra-core",
    "tensorboard", "matplotlib", "vqf", "ahrs",
)  # fmt: skip


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _one_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    # Hydra and OmegaConf list the location or the options on lines of their own
    return re.sub(r"\s+", " ", "; ".join(lines))


@contextlib.contextmanager
def _mistakes_end_with_one_line() -> Iterator[None]:
    try:
        yield
    except Exception as error:
        for cause in _causes(error):
            if isinstance(cause, UserError):
                sys.exit(_report(str(cause)))
        if isinstance(error, HydraException | OmegaConfBaseException):
            sys.exit(_report(_one_line(error)))
        raise


def command(config_name: str) -> Callable[[Callable[[DictConfig], object]], Callable[[], None]]:
    """Make a function of a configuration into a command with Hydra overrides.

    Parameters
    ----------
    config_name : str
        Primary configuration below `configs/`.

    Returns
    -------
    callable
        Decorator. The command ends with status 2 and one line on standard error if the user is
        to mend something (`UserError`, or a configuration that cannot be composed), and with a
        traceback only for a fault of the program.
    """

    def decorate(function: Callable[[DictConfig], object]) -> Callable[[], None]:
        @functools.wraps(function)
        def job(cfg: DictConfig) -> object:
            # within the job, since Hydra adds a line of its own to what leaves it as an exception
            with _mistakes_end_with_one_line():
                return function(cfg)

        task = hydra.main(version_base="1.3", config_path=CONFIG_PATH, config_name=config_name)(job)

        def main() -> None:
            """Run the command with the overrides on the command line."""
            # lets Hydra raise instead of printing and exiting with 1 itself
            os.environ["HYDRA_FULL_ERROR"] = "1"
            with _mistakes_end_with_one_line():
                task()

        main.__module__ = function.__module__
        return main

    return decorate


def _report(message: str) -> int:
    print(f"error: {message}", file=sys.stderr)
    return USER_ERROR_STATUS


def run_directory() -> Path:
    """Return the directory that Hydra made for this run.

    Returns
    -------
    pathlib.Path
        Where everything that the run leaves is written.
    """
    return Path(HydraConfig.get().runtime.output_dir)


def seed_everything(seed: int) -> None:
    """Let one seed govern Python, numpy and torch.

    Parameters
    ----------
    seed : int
        Any non-negative integer.
    """
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 - libraries that still use the legacy generator
    torch.manual_seed(seed)


def environment(seed: int, sources: Mapping[str, str]) -> dict[str, object]:
    """Describe what a result depends on besides its configuration.

    Parameters
    ----------
    seed : int
        The run's seed.
    sources : mapping of str to str
        Data file names to SHA-256.

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
    """Write a JSON file in one piece.

    Parameters
    ----------
    content : object
        What `json.dumps` can write.
    path : pathlib.Path
        Where to.
    """
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2, allow_nan=True) + "\n")
