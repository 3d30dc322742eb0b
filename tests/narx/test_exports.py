"""What the packages offer by name is there."""

import importlib
import pkgutil

import pytest

import narx

PACKAGES = [
    name for _, name, is_package in pkgutil.iter_modules(narx.__path__, "narx.") if is_package
]


@pytest.mark.parametrize("package", ["narx", *PACKAGES])
def test_every_name_that_a_package_lists_exists(package):
    module = importlib.import_module(package)
    names = getattr(module, "__all__", [])
    assert len(set(names)) == len(names)
    for name in names:
        assert getattr(module, name) is not None
