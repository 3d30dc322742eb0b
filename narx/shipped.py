"""The network that comes with the package, for recordings one cannot or need not train on."""

from importlib import resources

from narx.checkpoint import Checkpoint, load


def shipped_checkpoint() -> Checkpoint:
    """Load the network that ships with the package.

    Returns
    -------
    Checkpoint
        The default network; ``docs/model_card.md`` says what it was trained on and how well it
        does.
    """
    with resources.as_file(resources.files("narx") / "shipped.pt") as path:
        return load(path)
