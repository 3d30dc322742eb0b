import inspect
import re
from pathlib import Path

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from narx.baselines import METHODS, make_method, method_class
from narx.errors import UserError
from narx.method import OrientationMethod

CONFIGS = Path(__file__).parents[2] / "configs" / "method"


def test_an_unknown_name_says_which_there_are():
    with pytest.raises(UserError, match="no method is named 'kalman', expected one of gyro_inte"):
        make_method("kalman")


@pytest.mark.parametrize("name", METHODS)
def test_every_name_is_a_method(name):
    assert issubclass(method_class(name), OrientationMethod)
    assert method_class(name).name == name


@pytest.mark.parametrize("name", METHODS)
def test_every_method_has_a_configuration_with_all_its_defaults(name):
    config = OmegaConf.load(CONFIGS / f"{name}.yaml")
    assert list(config) == [name]
    settings = OmegaConf.to_container(config[name])
    assert settings.pop("_target_") == METHODS[name]
    pytest.importorskip({"vqf": "vqf", "madgwick": "ahrs", "mahony": "ahrs"}.get(name, "numpy"))
    parameters = inspect.signature(method_class(name)).parameters
    assert set(settings) == set(parameters)
    for key, parameter in parameters.items():
        default = parameter.default
        expected = list(default) if isinstance(default, tuple) else default
        assert settings[key] == (pytest.approx(expected) if expected is not None else None), key
    assert instantiate(config[name]).name == name


@pytest.mark.parametrize("name", METHODS)
def test_every_parameter_stands_on_the_methods_page(name):
    page = (CONFIGS.parents[1] / "docs" / "methods" / f"{name}.md").read_text()
    for key in inspect.signature(method_class(name)).parameters:
        assert re.search(rf"`{key}`", page), key
