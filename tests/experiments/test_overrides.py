"""Overrides reach the configuration with the intended values."""

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser

from narx.experiments.overrides import readable


def _value(argument):
    (override,) = OverridesParser.create().parse_overrides(readable([argument]))
    return override.value()


@pytest.mark.parametrize(
    "name",
    ["läufer.csv", "Ganganalyse 3.csv", "a,b.csv", "walk (1).csv", "歩行.csv", "it's.csv",
     "x=y.csv", "r\u0301un.csv", "C:\\data\\walk.csv", "back\\",
     "#1.csv", "50%.csv", "a&b.csv", "~/walk.csv",
     "walk;1.csv", "walk [left].csv"],
)  # fmt: skip
def test_file_names_arrive(name):
    assert _value(f"input={name}") == name


def test_names_stay_names():
    assert _value("select.condition=off") == "off"
    assert _value("input=on") == "on"


def test_elements_are_quoted_where_they_must_be():
    assert _value("input={thigh_right: läufer 1.csv, shank_right: b.csv}") == {
        "thigh_right": "läufer 1.csv",
        "shank_right": "b.csv",
    }
    assert _value("input=[läufer.csv,b.csv]") == ["läufer.csv", "b.csv"]


@pytest.mark.parametrize(
    "argument",
    ["seed=0,1", "methods=[narx,vqf]", "still_s=[0,1]", "+experiment=han", "~data", "-m",
     "model.hidden=range(1,4)", "data_root=${oc.env:HOME}", "output='a b.csv'",
     "--config-dir=läufer"],
)  # fmt: skip
def test_values_valid_in_hydra_are_unchanged(argument):
    assert readable([argument]) == [argument]
