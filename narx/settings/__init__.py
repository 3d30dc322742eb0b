"""Validation of values from users: types with ranges, checked in one way everywhere."""

from narx.settings.checked import check_fields, checked
from narx.settings.values import (
    Count,
    FilePath,
    Flag,
    Fraction,
    Name,
    Names,
    Positive,
    PositiveSeconds,
    Samples,
    SamplesLike,
    SamplingRate,
    Seconds,
    Seed,
    Span,
    real_numbers,
)

__all__ = [
    "Count",
    "FilePath",
    "Flag",
    "Fraction",
    "Name",
    "Names",
    "Positive",
    "PositiveSeconds",
    "Samples",
    "SamplesLike",
    "SamplingRate",
    "Seconds",
    "Seed",
    "Span",
    "check_fields",
    "checked",
    "real_numbers",
]
