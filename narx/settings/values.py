"""Types of settings with their ranges, for annotations of constructors and configurations.

Upper limits only exclude values that are certainly mistyped (a walk of 30 years), not values that
are merely unusual.
"""

from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, InstanceOf


def _one_is_a_list(value: object) -> object:
    return [value] if isinstance(value, str | int | float) else value


def _each_once(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _can_be_a_path(path: str | Path) -> str | Path:
    try:
        Path(path).expanduser().exists()
    except (OSError, RuntimeError, ValueError) as error:
        raise ValueError(f"{str(path)[:60]!a} cannot be a path ({error})") from None
    return path


FilePath = Annotated[
    Annotated[str, Field(min_length=1)] | InstanceOf[Path],
    AfterValidator(_can_be_a_path),
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
