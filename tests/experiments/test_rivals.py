"""Which parameters a rival has: those chosen for the tilt, and a heading's leak chosen after it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from omegaconf import OmegaConf

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.datasets.splits import Fold, TrialPart
from narx.experiments.choosing import TrainingPart, choose_parameters
from narx.experiments.rivals import Rivals

ROW = {
    "_target_": "narx.baselines.complementary_filter.ComplementaryFilter",
    "coupled": True, "heading": "leak",
}  # fmt: skip
GRID = {"crossover_hz": [0.05, 0.5], "heading_leak_rad_s": [0.05, 0.5]}
CFG = OmegaConf.create(
    {
        "choose": True,
        "model": {
            "coupled": True,
            "objective": {
                "_target_": "narx.training.objective.Objective", "axis_weights": [1.0, 1.0, 0.0],
            },
        },
        "training": {"skip_s": 5.0, "seed": 0},
    }
)  # fmt: skip


@pytest.fixture(scope="module")
def prepare(motion):
    """A walk whose gyroscope drifts about the vertical; tilt as of a crossover of 0.5 Hz."""
    walk = motion("walking", duration_s=200.0)
    rates = walk.signals.axis_rates_rad_s.copy()
    rates[:, 2] += np.radians(0.5)
    signals = replace(walk.signals, axis_rates_rad_s=rates)
    truth = ComplementaryFilter(0.5, coupled=True).estimate(signals)
    truth[:, 2] = walk.angles_rad[:, 2]
    segment = SimpleNamespace(signals=signals, reference_angles_rad=truth)
    trial = SimpleNamespace(time_s=walk.time_s, scored=None)
    return lambda part: (trial, {"thigh_right": segment})


FOLD = Fold("f", (TrialPart("s", "p", "walk", "1", 120.0, 200.0),), ())


def _chosen(prepare, settings, grid, cfg=CFG):
    gathered = SimpleNamespace(chosen={}, refusals=[])
    rivals = Rivals(cfg, settings, grid, gathered)
    return rivals.methods_for(FOLD, prepare), gathered.chosen


def test_the_tilt_is_chosen_first_and_the_leak_with_the_offset_that_a_drift_leaves(prepare):
    methods, chosen = _chosen(prepare, {"cf": ROW}, {"cf": GRID})
    assert chosen == {("f", "cf_chosen"): {"crossover_hz": 0.5, "heading_leak_rad_s": 0.5}}
    assert methods["cf"].crossover_hz == 0.1
    assert methods["cf_chosen"].crossover_hz == 0.5
    assert methods["cf_chosen"].heading.leak_rad_s == 0.5
    # without the mean error, the slower leak would be better: the drift leaves it an offset
    training = TrainingPart(FOLD, prepare, 5.0)
    transverse = (0.0, 0.0, 1.0)
    leaks = {"heading_leak_rad_s": GRID["heading_leak_rad_s"]}
    free = choose_parameters(ROW | {"crossover_hz": 0.5}, leaks, training, transverse, True)
    assert free == {"heading_leak_rad_s": 0.05}


def test_another_treatment_of_the_heading_has_the_same_tilt_and_no_leak(prepare):
    rows = {"cf": ROW, "cf_heading_zero": ROW | {"heading": "zero"}}
    _, chosen = _chosen(prepare, rows, dict.fromkeys(rows, GRID))
    assert chosen["f", "cf_heading_zero_chosen"] == {"crossover_hz": 0.5}


def test_nothing_is_chosen_unless_asked_for(prepare):
    fixed = OmegaConf.merge(CFG, {"choose": False})
    methods, chosen = _chosen(prepare, {"cf": ROW}, {"cf": GRID}, fixed)
    assert (list(methods), chosen) == (["cf"], {})
