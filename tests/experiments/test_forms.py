import pytest
from omegaconf import OmegaConf

from narx.errors import UserError
from narx.experiments.forms import forms_of, grid_of

START_UP = {"duration_s": 6.0}


def configuration(**forms):
    target = "narx.baselines.{}"
    return OmegaConf.create(
        {
            "method": {
                "leaky_integrator": {
                    "_target_": target.format("leaky_integrator.LeakyIntegrator"),
                    "leak_rad_s": 0.3,
                    "coupled": False,
                },
                "madgwick": {"_target_": target.format("madgwick.Madgwick"), "gain": 0.02},
                "zero": {"_target_": target.format("zero.Zero")},
            },
            "grid": {"madgwick": {"gain": [0.01, 0.02]}},
            "forms": forms
            or {
                "printed": {},
                "heading_zero": {"heading": "zero", "only": ["madgwick"]},
                "same": {"coupled": True, "start_up": START_UP, "heading": "leak"},
            },
        }
    )


def test_a_form_changes_only_parameters_of_the_method():
    cfg = configuration()
    rows = forms_of(cfg, "leaky_integrator")
    assert list(rows) == ["leaky_integrator", "leaky_integrator_same"]
    printed, same = rows.values()
    assert printed == OmegaConf.to_container(cfg.method.leaky_integrator)
    assert same == printed | {"coupled": True, "start_up": START_UP}
    rows = forms_of(cfg, "madgwick")
    assert list(rows) == ["madgwick", "madgwick_heading_zero", "madgwick_same"]
    assert rows["madgwick_heading_zero"]["heading"] == "zero"
    assert rows["madgwick_same"] == rows["madgwick"] | {"start_up": START_UP, "heading": "leak"}


def test_a_form_that_changes_nothing_is_no_row():
    assert list(forms_of(configuration(), "zero")) == ["zero"]
    as_printed = configuration(printed=None, other={"gain": 0.02})
    assert forms_of(as_printed, "madgwick") == {}
    alike = configuration(printed={}, one={"gain": 0.1}, other={"gain": 0.1})
    assert list(forms_of(alike, "madgwick")) == ["madgwick", "madgwick_one"]


def test_a_form_can_be_switched_off_and_must_be_a_mapping():
    cfg = configuration(printed={}, same=None)
    assert list(forms_of(cfg, "madgwick")) == ["madgwick"]
    with pytest.raises(UserError, match=r"forms\.same is 3, expected parameters"):
        forms_of(configuration(same=3), "madgwick")


def test_a_grid_is_looked_up_by_method():
    assert grid_of(configuration(), "madgwick") == {"gain": [0.01, 0.02]}
    assert grid_of(configuration(), "zero") == {}
