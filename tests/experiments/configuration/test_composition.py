"""Overrides that Hydra cannot compose give an error that suggests valid ones."""

import pytest
from hydra import compose, initialize_config_module

from narx.experiments.configuration import composition_mistake


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ("optimizer=nonsense", "optimizer is 'nonsense', expected one of adam, lbfgs, levenberg_m"),
        ("optimzer=adam", "optimzer: unknown key, the closest is optimizer"),
        ("modle.hidden=3", "modle.hidden: unknown key, the closest is model.hidden"),
        ("~training.skip", "training.skip: unknown key, the closest is training.skip_s"),
        ("model=3", "model is 3, expected the name of a file of configs"),
        ("data=null", "data is null, expected the name of a file of configs"),
        ("data=[a]", "data is 'a', expected one of"),
        ("data_root=a=b", "data_root=a=b: cannot be read"),
        ("seed=[1", "seed=[1: cannot be read"),
        ("seed", "seed: cannot be read"),
        ("seed=" + "9" * 5000, "seed=9999"),
        ("seed=0,1", "Ambiguous value"),
        ("a" * 300 + "=1", ""),
        ("candidates=" + "[" * 300 + "]" * 300, "candidates=[[["),
    ],
)
def test_one_line_states_what_is_expected(override, line):
    with (
        initialize_config_module("narx.configs", version_base="1.3"),
        pytest.raises(Exception) as refusal,  # noqa: PT011 - Hydra raises what its parts raise
    ):
        compose("train", overrides=[override])
    said = composition_mistake(refusal.value, "train", [override])
    assert said.startswith(line)
    assert "\n" not in said
    assert said.isprintable()
    assert len(said) < 1000


def test_an_assertion_of_hydra_names_its_settings():
    said = composition_mistake(AssertionError(), "train", ["seed=1", "hydra.verbose=7"])
    assert said == "Hydra refuses one of its settings: hydra.verbose=7"
    said = composition_mistake(AssertionError(), "train", [])
    assert said == "Hydra refuses one of its settings: AssertionError"
