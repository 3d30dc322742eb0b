"""Commands of the project."""

from narx.experiments import starting

starting.begin()
