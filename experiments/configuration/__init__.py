"""Validation of a command's configuration, before anything is read or computed."""

from narx.experiments.configuration.check import checked_configuration
from narx.experiments.configuration.composed import composed_configuration
from narx.experiments.configuration.composition import composition_mistake

__all__ = ["checked_configuration", "composed_configuration", "composition_mistake"]
