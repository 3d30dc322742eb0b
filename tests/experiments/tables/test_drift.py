from dataclasses import replace

import numpy as np
import pytest

from narx.evaluation.comparison import Evaluated
from narx.evaluation.drift import drift_test
from narx.evaluation.significance import bootstrap_mean
from narx.experiments.tables.drift import drift_table

RATE_HZ = 2.0
GROWTH_DEG = {"A": 1.0, "B": 2.0, "C": 3.0, "D": 1.5, "E": 2.5, "F": 2.0}


def long_walk(subject, segment, minutes=30.0, seed=0):
    """Errors of one degree; the pseudo-integrator's sagittal one grows, NARX's shrinks."""
    generator = np.random.default_rng([seed, ord(subject), len(segment)])
    n = round(minutes * 60 * RATE_HZ)
    time_s = np.arange(n) / RATE_HZ
    reference = 0.3 * np.sin(time_s)[:, None] * np.ones(3)
    grown = np.deg2rad(2.0 + GROWTH_DEG[subject] * time_s / time_s[-1])
    errors = {name: np.deg2rad(generator.normal(size=(n, 3))) for name in ("narx", "other")}
    errors["pseudo_integrator"] = errors["narx"].copy()
    errors["pseudo_integrator"][:, 0] += grown
    errors["narx"][:, 0] += grown[::-1]
    errors["narx"][:, 2] = np.nan
    return Evaluated(
        "simulated_gait",
        subject,
        "normal",
        "1",
        segment,
        RATE_HZ,
        time_s,
        reference,
        {name: reference - error for name, error in errors.items()},
        time_s >= 5.0,
    )


@pytest.fixture(scope="module")
def walks():
    return [long_walk(s, segment) for s in "ABC" for segment in ("knee_right", "knee_left")]


METHODS = ("pseudo_integrator", "narx")


def test_growth_over_people(walks):
    table = drift_table(walks, METHODS, seed=3)
    frame = table.frame
    assert frame.index.tolist() == [
        ("knee", "sagittal", "PI"),
        ("knee", "sagittal", "NARX"),
        ("knee", "frontal", "PI"),
        ("knee", "frontal", "NARX"),
        ("knee", "transverse", "PI"),
    ]
    grown = frame.loc[("knee", "sagittal", "PI")]
    changes = []
    for subject in "ABC":
        tests = [
            drift_test(
                one.time_s[one.scored],
                np.deg2rad(one.error_deg("pseudo_integrator"))[one.scored, 0],
            )
            for one in walks
            if one.subject == subject
        ]
        changes.append(np.mean([test.change_deg for test in tests]))
    # five of thirty minutes lie on either side of the ramp's ends
    np.testing.assert_allclose(changes, [25 / 30 * g for g in (1.0, 2.0, 3.0)], rtol=0.2)
    interval = bootstrap_mean(changes, seed=3)
    np.testing.assert_allclose(
        grown[["subjects", "change", "low", "high"]].astype(float),
        [3, interval.mean, interval.low, interval.high],
    )
    assert (grown["grows"], grown["shrinks"]) == ("6 of 6", "0 of 6")
    shrunk = frame.loc[("knee", "sagittal", "NARX")]
    assert (shrunk["grows"], shrunk["shrinks"]) == ("0 of 6", "6 of 6")
    np.testing.assert_allclose(
        [shrunk["first"], shrunk["last"]], [grown["last"], grown["first"]], rtol=0.02
    )
    steady = frame.loc[("knee", "frontal", "PI")]
    assert int(steady["shrinks"].split()[0]) <= 2
    assert "Drift: RMSE (°) in the first and the last 5 minutes" in table.to_markdown()


def test_only_long_trials_count(walks):
    short = [long_walk("A", "knee_right", minutes=19.9)]
    assert drift_table(short, METHODS) is None
    assert drift_table([], METHODS) is None
    both = drift_table([*walks, *short], METHODS).frame
    assert both.loc[("knee", "sagittal", "PI"), "grows"] == "6 of 6"
    enough = drift_table([long_walk("A", "knee_right", minutes=20.0)], METHODS).frame
    assert enough.loc[("knee", "sagittal", "PI"), "subjects"] == 1
    assert np.isnan(enough.loc[("knee", "sagittal", "PI"), "low"])


def test_two_data_sets_may_have_the_same_names(walks):
    twice = [*walks, *(replace(one, dataset="other") for one in walks)]
    assert (drift_table(twice, METHODS).frame["subjects"] == 6).all()


def test_the_interval_of_six_people_is_about_their_mean():
    walks = [long_walk(subject, "knee_right", minutes=21.0) for subject in "ABCDEF"]
    grown = drift_table(walks, ["pseudo_integrator"]).frame.loc[("knee", "sagittal", "PI")]
    assert grown["low"] < grown["change"] < grown["high"]
