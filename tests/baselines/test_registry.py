import inspect
import re
from pathlib import Path

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from narx import baselines
from narx.method import OrientationMethod

CONFIGS = Path(__file__).parents[2] / "configs" / "method"
METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}


@pytest.mark.parametrize("name", METHODS)
def test_every_name_is_a_method(name):
    assert issubclass(METHODS[name], OrientationMethod)


@pytest.mark.parametrize("name", METHODS)
def test_every_method_has_a_configuration_with_all_its_defaults(name):
    config = OmegaConf.load(CONFIGS / f"{name}.yaml").method
    assert list(config) == [name]
    settings = OmegaConf.to_container(config[name])
    assert settings.pop("_target_") == f"{METHODS[name].__module__}.{METHODS[name].__name__}"
    pytest.importorskip({"vqf": "vqf"}.get(name, "numpy"))
    parameters = inspect.signature(METHODS[name]).parameters
    assert set(settings) == set(parameters)
    for key, parameter in parameters.items():
        default = parameter.default
        expected = list(default) if isinstance(default, tuple) else default
        assert settings[key] == (pytest.approx(expected) if expected is not None else None), key
    assert instantiate(config[name]).name == name


@pytest.mark.parametrize("name", METHODS)
def test_every_parameter_stands_on_the_methods_page(name):
    page = (CONFIGS.parents[1] / "docs" / "methods" / f"{name}.md").read_text()
    for key in inspect.signature(METHODS[name]).parameters:
        assert re.search(rf"`{key}`", page), key


@pytest.mark.parametrize("name", METHODS)
def test_grids_contain_parameters_of_the_method_and_their_defaults(name):
    config = OmegaConf.load(CONFIGS / f"{name}.yaml")
    grid = OmegaConf.to_container(config.get("grid", OmegaConf.create({name: {}}))[name])
    parameters = inspect.signature(METHODS[name]).parameters
    for key, values in grid.items():
        assert parameters[key].default in [pytest.approx(value) for value in values], key
        for value in values:
            assert instantiate(config.method[name], **{key: value}).name == name
