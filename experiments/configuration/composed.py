"""Configurations that a command composes for runs of another command."""

from collections.abc import Sequence

from hydra import compose
from hydra.errors import HydraException
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from narx.errors import UserError
from narx.experiments.configuration.check import checked_configuration
from narx.experiments.configuration.composition import composition_mistake
from narx.experiments.overrides import readable


def composed_configuration(command: str, overrides: Sequence[str], key: str) -> DictConfig:
    """Compose and check the configuration of another command.

    Parameters
    ----------
    command : str
        Name of its primary configuration.
    overrides : sequence of str
        As on its command line.
    key : str
        Where the overrides come from, for messages.

    Returns
    -------
    omegaconf.DictConfig
        Checked.

    Raises
    ------
    UserError
        If the overrides cannot be composed or a value is wrong.
    """
    written = readable(list(overrides))
    try:
        composed = compose(command, overrides=written)
    # Hydra raises a ValueError for a group whose value is a number
    except (HydraException, OmegaConfBaseException, ValueError, RecursionError) as error:
        raise UserError(f"{key}: {composition_mistake(error, command, written)}") from error
    try:
        return checked_configuration(composed, command)
    except UserError as error:
        raise UserError(f"{key}: {error}") from error
