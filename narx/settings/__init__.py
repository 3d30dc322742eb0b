"""Validation of values from users: types with ranges, checked in one way everywhere."""

from narx.settings.checked import check_fields, checked
from narx.settings.values import (
    Count,
    FilePath,
    Fraction,
    Name,
    Names,
    Positive,
    PositiveSeconds,
    SamplingRate,
    Seconds,
    Seed,
)

__all__ = [
    "Count",
    "FilePath",
    "Fraction",
    "Name",
    "Names",
    "Positive",
    "PositiveSeconds",
    "SamplingRate",
    "Seconds",
    "Seed",
    "check_fields",
    "checked",
]
