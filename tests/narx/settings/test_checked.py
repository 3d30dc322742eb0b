"""Invalid arguments give a one-line error with name, value and limits; valid ones convert."""

from typing import Annotated, Literal

import pytest
from pydantic import Field

from narx.errors import UserError
from narx.settings import Names, Positive, Seed, checked
from narx.settings.wording import expected, shown


class Walk:
    name = "walk"

    @checked
    def __init__(
        self,
        *,
        who: Names = ("S1",),
        speed: Positive = 1.0,
        steps: tuple[int, int] = (3, 5),
        surface: Literal["floor", "treadmill"] = "floor",
        ideal: bool = False,
        seed: Seed = 0,
        scales: dict[str, Positive] | None = None,
    ) -> None:
        self.given = (who, speed, steps, surface, ideal, seed, scales)


@pytest.mark.parametrize(
    ("arguments", "position", "value"),
    [
        ({"who": 7}, 0, ("7",)),
        ({"who": "S2"}, 0, ("S2",)),
        ({"who": ["S2", "S2", 3]}, 0, ("S2", "3")),
        ({"speed": 2}, 1, 2.0),
        ({"speed": "1e-3"}, 1, 0.001),
        ({"steps": [1, 2.0]}, 2, (1, 2)),
        *(({"ideal": word}, 4, False) for word in ("no", "off", "Off", "NO", "false", 0)),
        *(({"ideal": word}, 4, True) for word in ("yes", "on", "true", "YES", 1)),
    ],
)
def test_intended_values_are_converted(arguments, position, value):
    taken = Walk(**arguments).given[position]
    assert taken == value
    assert type(taken) is type(value)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ({"speed": 0}, "walk: speed is 0, expected a number above 0 and of at most 1e+09"),
        ({"speed": float("nan")}, "walk: speed is nan, expected a number"),
        ({"speed": float("inf")}, "walk: speed is inf, expected a number"),
        ({"speed": True}, "walk: speed is true, expected a number"),
        ({"speed": 10**400}, "walk: speed is 1000000000"),
        ({"speed": "fast"}, "walk: speed is 'fast', expected a number"),
        (
            {"seed": -1},
            "walk: seed is -1, expected a whole number of at least 0 and below 42949",
        ),
        ({"seed": 1.5}, "walk: seed is 1.5, expected a whole number"),
        ({"steps": 3}, "walk: steps is 3, expected a list of 2, each a whole number"),
        ({"steps": [1, True]}, "walk: steps.1 is true, expected a whole number"),
        ({"steps": [1, 2, 3]}, "walk: steps is [1, 2, 3], expected a list of 2"),
        ({"surface": "ice"}, "walk: surface is 'ice', expected one of floor, treadmill"),
        ({"ideal": "maybe"}, "walk: ideal is 'maybe', expected true or false"),
        ({"ideal": None}, "walk: ideal is null, expected true or false"),
        ({"who": []}, "walk: who is [], expected a name or a list of names"),
        ({"who": [{}]}, "walk: who.0 is {}, expected a name"),
        ({"scales": {"a": 0}}, "walk: scales.a is 0, expected a number above 0"),
        ({"scales": 3}, "walk: scales is 3, expected a section of names"),
    ],
)
def test_disallowed_values_are_named(arguments, line):
    with pytest.raises(UserError) as refusal:
        Walk(**arguments)
    assert str(refusal.value).startswith(line)
    assert "\n" not in str(refusal.value)


def test_found_values_fit_into_one_line():
    assert shown("a\nb\x1b[31m") == r"'a\nb\x1b[31m'"
    assert len(shown("x" * 10_000)) < 80
    assert shown(10**5000) == "a number of thousands of digits"
    assert [shown(value) for value in (None, True, "x")] == ["null", "true", "'x'"]


def test_expected_values_are_described_in_words():
    assert expected(Annotated[float, Field(ge=0, lt=1)]) == "a number of at least 0 and below 1"
    assert expected(Annotated[int, Field(ge=1)] | None) == "a whole number of at least 1 or null"
    assert expected(int | Literal["auto"]) == "a whole number or auto"
    assert expected(tuple[str, ...]) == "a list, each a name"
    assert expected(tuple[str, ...] | None) == "a list, each a name, or null"
