"""The defaults of configs/ are those of the constructors: Python and commands do the same."""

import inspect
from pathlib import Path

import pytest
from hydra.utils import get_object, instantiate
from omegaconf import DictConfig, ListConfig, OmegaConf

from narx.experiments.configuration.schemas import SCHEMAS, Section
from narx.settings.checked import arguments_model
from narx.training.trial_reader import TrialReader

CONFIGS = Path(__file__).parents[3] / "configs"
# chosen against the defaults: as printed in a paper, or another of several uses of a class
CHOSEN = {
    "model/tham_literal.yaml": "as printed",
    "split/automatic_training.yaml": "testing: false",
    "split/leave_one_": "the column",
    "split/one_window.yaml": "condition: normal",
    "teacher/vqf.yaml": "offline",
}


def sections():
    """Every section with a `_target_` of every file of configs/, but for the experiments."""
    for path in sorted(CONFIGS.rglob("*.yaml")):
        name = path.relative_to(CONFIGS).as_posix()
        if path.relative_to(CONFIGS).parts[0] in ("experiment", "hydra", "debug"):
            continue
        model = {"start_up": None, "washout_s": None}
        values = {"seed": 0, "data": {"seed": 0}, "model": model, "file": OmegaConf.load(path)}
        yield from _targets(OmegaConf.create(values)["file"], name)


def _targets(cfg, name):
    if isinstance(cfg, DictConfig):
        if "_target_" in cfg:
            yield name, cfg
        for key in cfg:
            if key != "hydra" and not OmegaConf.is_missing(cfg, key):
                yield from _targets(cfg[key], f"{name}:{key}")


SECTIONS = list(sections())


def plain(value):
    if isinstance(value, ListConfig | list | tuple):
        return [plain(one) for one in value]
    return value


@pytest.mark.parametrize(("name", "section"), SECTIONS, ids=[name for name, _ in SECTIONS])
def test_a_section_has_the_constructors_defaults(name, section):
    target = get_object(section["_target_"])
    taken = arguments_model(target).model_fields
    for key, value in section.items():
        if str(key).startswith("_"):
            continue
        assert key in taken, f"{name}: {key} is no argument of {target}"
        if any(name.startswith(start) for start in CHOSEN) or isinstance(value, DictConfig):
            continue
        if inspect.Parameter.empty is not taken[key].default:
            assert plain(value) == plain(taken[key].default), f"{name}: {key}"


@pytest.mark.parametrize("command", SCHEMAS)
def test_a_command_has_the_schemas_defaults_and_keys(compose_checked, command):
    required = {"export": ["output=a.pt"], "predict": ["output=b.csv"], "draft_study": ["input=a"]}
    cfg = compose_checked(command, *required.get(command, []))
    _compare(SCHEMAS[command], cfg, command)


def _compare(schema, cfg, path):
    for name, field in schema.model_fields.items():
        outside = ("data_root", "folder", "grid", "forms")
        if field.is_required() or field.exclude or name in outside:
            continue  # from the environment, or from the files of the methods
        value, default = cfg[name], field.default
        if isinstance(default, Section):
            _compare(type(default), value, f"{path}.{name}")
        else:
            assert plain(value) == plain(default), f"{path}.{name}"


def test_every_primary_configuration_has_a_schema():
    primary = {
        path.stem
        for path in CONFIGS.glob("*.yaml")
        if "# @package" not in path.read_text() and path.stem != "common"
    }
    assert primary == set(SCHEMAS)


def test_trials_are_read_with_the_configured_teacher():
    configured = instantiate(OmegaConf.load(CONFIGS / "teacher" / "automatic.yaml"))
    default = TrialReader().teacher
    assert type(default) is type(configured)
    assert default.method.crossover_hz == configured.method.crossover_hz
