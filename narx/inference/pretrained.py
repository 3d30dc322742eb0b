"""The network included in the package, for use without training."""

import os
from importlib import resources

from narx.inference.checkpoint import Checkpoint, load


def pretrained() -> Checkpoint:
    """Load the network shipped with the package.

    Returns
    -------
    Checkpoint
        The default network; ``docs/model_card.md`` describes its training data and accuracy.
    """
    with resources.as_file(resources.files("narx.inference") / "shipped.pt") as path:
        return load(path)


def load_or_pretrained(path: str | os.PathLike[str] | None) -> Checkpoint:
    """Load a checkpoint, or the network shipped with the package.

    Parameters
    ----------
    path : path-like, optional
        File written by `narx.inference.checkpoint.save`; None for the shipped network.

    Returns
    -------
    Checkpoint
        The network and its settings.

    Raises
    ------
    UserError
        If the file does not exist or is not a checkpoint.
    """
    return pretrained() if path is None else load(path)
