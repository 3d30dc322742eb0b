"""A number that a method cannot use is refused in one line that names it."""

import importlib.util
import inspect
import math

import pytest

from narx import baselines
from narx.baselines.parameters import positive
from narx.errors import UserError

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}
NUMBERS = [
    (name, parameter.name)
    for name, method in METHODS.items()
    for parameter in inspect.signature(method).parameters.values()
    if isinstance(parameter.default, float)
]


@pytest.mark.parametrize("value", [-1e9, math.nan])
@pytest.mark.parametrize(("name", "parameter"), NUMBERS)
def test_a_number_that_cannot_be_is_named(name, parameter, value):
    if name == "vqf" and importlib.util.find_spec("vqf") is None:
        pytest.skip("vqf is not installed")
    with pytest.raises(UserError, match=rf"\b{parameter} is {value}, expected") as refusal:
        METHODS[name](**{parameter: value})
    assert "\n" not in str(refusal.value)


def test_a_positive_number_is_not_zero():
    with pytest.raises(UserError, match=r"leak is 0\.0, expected a positive number"):
        positive("narx", "leak", 0.0)
    assert positive("narx", "leak", 1e-300) == 1e-300
