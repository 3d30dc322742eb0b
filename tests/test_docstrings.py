"""Public docstrings are checked against the signatures they describe."""

import enum
import importlib
import inspect
import warnings
from pathlib import Path

import pytest
from numpydoc.validate import validate
from pydantic import BaseModel

ROOT = Path(__file__).resolve().parents[1]
# no docstring; no sentence as summary; parameters missing, unknown, in another order; nothing
# said about what is returned or yielded
CHECKS = {"GL08", "SS03", "PR01", "PR02", "PR03", "RT01", "YD01"}
MODULES = sorted(
    ".".join((*prefix, *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")
    for package, prefix in (("narx", ()), ("baselines", ("narx",)), ("experiments", ("narx",)))
    for path in (ROOT / package).rglob("*.py")
    # what begins with an underscore is nobody else's; kernels are called by arrays' layout alone
    if not path.stem.removeprefix("__init__").startswith("_") and path.parent.name != "kernels"
)


def public_objects(module_name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module = importlib.import_module(module_name)
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module_name:
            continue
        if inspect.isclass(thing):
            yield f"{module_name}.{name}", thing
            for method_name, method in vars(thing).items():
                function = getattr(method, "__func__", method)
                if inspect.isfunction(function) and not method_name.startswith("_"):
                    yield f"{module_name}.{name}.{method_name}", function
        elif inspect.isfunction(thing):
            yield f"{module_name}.{name}", thing


def faults_of(name, thing=None):
    # a protocol and an enumeration have a signature that is not theirs; the keys of a
    # configuration's schema are described in its yaml file
    foreign = inspect.isclass(thing) and (
        getattr(thing, "_is_protocol", False) or issubclass(thing, enum.Enum | BaseModel)
    )
    checks = CHECKS - {"PR01"} if foreign else CHECKS
    return [f"{name}: {code} {text}" for code, text in validate(name)["errors"] if code in checks]


@pytest.mark.parametrize("module_name", MODULES)
def test_docstrings_fit_the_signatures(module_name):
    faults = [
        fault for name, thing in public_objects(module_name) for fault in faults_of(name, thing)
    ]
    assert not faults, "\n".join(faults)
