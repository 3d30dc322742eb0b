"""Configurations composed in this process, as a command's overrides compose them."""

import pytest
from hydra import compose, initialize_config_module

from narx.experiments.configuration import checked_configuration


@pytest.fixture
def compose_checked():
    """Compose and check: ``compose_checked(command, *overrides)``."""

    def run(command, *overrides):
        with initialize_config_module("narx.configs", version_base="1.3"):
            return checked_configuration(compose(command, overrides=list(overrides)), command)

    return run
