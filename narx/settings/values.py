"""Types of settings with their ranges, for annotations of constructors and configurations.

Upper limits only exclude values that are certainly mistyped (a walk of 30 years), not values that
are merely unusual.
"""

import os
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, BeforeValidator, Field, InstanceOf, PlainValidator
from pydantic_core import PydanticCustomError

from narx.types import FloatArray

# kinds of numpy that become floats silently: dates, durations, and complex numbers without their
# imaginary part
_NOT_REAL = "Mmc"


def _one_is_a_list(value: object) -> object:
    return [value] if isinstance(value, str | int | float) else value


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _expanded(path: str | Path) -> str | Path:
    """Replace ``~``, which a shell leaves within ``key=~/folder``."""
    try:
        Path(path).expanduser().exists()
    except (OSError, RuntimeError, ValueError) as error:
        raise ValueError(f"{str(path)[:60]!a} cannot be a path ({error})") from None
    return path.expanduser() if isinstance(path, Path) else os.path.expanduser(path)


FilePath = Annotated[
    Annotated[str, Field(min_length=1)] | InstanceOf[Path],
    AfterValidator(_expanded),
    Field(description="a path"),
]
Name = Annotated[str, Field(min_length=1, max_length=300)]
# a single name is a list of one
Names = Annotated[
    tuple[Name, ...],
    BeforeValidator(_one_is_a_list),
    AfterValidator(_each_once),
    Field(min_length=1, description="a name or a list of names"),
]

Count = Annotated[int, Field(ge=1)]
# seeds accepted by numpy's generators
Seed = Annotated[int, Field(ge=0, lt=2**32)]
Fraction = Annotated[float, Field(ge=0, lt=1)]
Positive = Annotated[float, Field(gt=0, le=1e9)]

# eleven days
LONGEST_S = 1e6
Seconds = Annotated[float, Field(ge=0, le=LONGEST_S)]
PositiveSeconds = Annotated[float, Field(gt=0, le=LONGEST_S)]


def _begins_before_it_ends(interval_s: tuple[float, float]) -> tuple[float, float]:
    if not interval_s[0] < interval_s[1]:
        raise ValueError(f"[{interval_s[0]:g}, {interval_s[1]:g}] does not start before it ends")
    return interval_s


Interval = Annotated[
    tuple[float, float],
    AfterValidator(_begins_before_it_ends),
    Field(description="[begin, end] in s"),
]
# below the minimum, gait events cannot be resolved; no IMU samples faster than the maximum
SamplingRate = Annotated[float, Field(ge=10, le=10_000)]


def real_numbers(values: ArrayLike) -> FloatArray:
    """Copy numbers into an array; what is masked is missing.

    Parameters
    ----------
    values : array_like
        Numbers, as a list, array, masked array or table.

    Returns
    -------
    ndarray
        Floats in the order of C, NaN where masked. A copy: the caller may change its own.

    Raises
    ------
    ValueError
        If they are not real numbers: text, dates, durations, complex numbers.
    """
    try:
        given = np.asarray(values)
        if given.dtype.kind in _NOT_REAL:
            raise ValueError("dates, durations or complex numbers")
        copied = given.astype(np.float64, order="C")
    except (TypeError, OverflowError, RuntimeError) as error:  # the last of a tensor with gradients
        raise ValueError(str(error)) from error
    if np.ma.is_masked(values):
        copied[np.ma.getmaskarray(np.ma.asarray(values))] = np.nan
    return copied


def _as_numbers(values: Any) -> FloatArray:
    try:
        return real_numbers(values)
    except ValueError as error:
        raise PydanticCustomError("real_numbers", "expected real numbers") from error


def _as_flag(value: object) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise PydanticCustomError("flag", "expected true or false")


def _listed(value: object) -> object:
    return value.tolist() if isinstance(value, np.ndarray) else value


_NUMBERS = PlainValidator(_as_numbers), Field(description="real numbers")
# of a field, and of an argument
Samples = Annotated[FloatArray, *_NUMBERS]
SamplesLike = Annotated[ArrayLike, *_NUMBERS]
# of functions; a configuration also has words such as yes and no
Flag = Annotated[bool, PlainValidator(_as_flag), Field(description="True or False")]
# checked where it is used
Span = Annotated[tuple[float, float], BeforeValidator(_listed)]
