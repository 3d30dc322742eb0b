import numpy as np
import pandas as pd
import pytest

from narx.experiments.phase_timing import event_errors, phase_shares
from narx.experiments.tables.abhayasinghe import phase_tables
from narx.gait.phases import GaitPhases


@pytest.fixture
def phases():
    starts = np.array([1.0, 2.0, 3.0])
    offsets = {"a": -0.1, "b": 0.0, "c": 0.1, "d": 0.3, "e": 0.5, "f": 0.6, "g": 1.0}
    times = {point: starts + offset for point, offset in offsets.items()}
    times["f"][1] = np.nan
    return GaitPhases(times)


def test_shares_of_a_stride(phases):
    shares = phase_shares(phases)
    assert shares["phase"].unique().tolist() == ["b–c", "c–d", "d–e", "e–f", "f–g"]
    means = shares.groupby("phase")["share"].mean()
    np.testing.assert_allclose(means, [0.1, 0.2, 0.2, 0.1, 0.4])
    assert shares["share"].isna().sum() == 2


def test_points_are_compared_with_the_events_of_the_right_foot(phases):
    events = {
        "heel_strike_right": [1.02, 2.02, 9.0],
        "heel_strike_left": [1.49, 2.49, 3.49],
        "toe_off_right": [1.65, 3.65],
    }
    errors = event_errors(phases, events, "right")
    by_point = {point: part["error_s"].to_numpy() for point, part in errors.groupby("point")}
    np.testing.assert_allclose(by_point["b"], [-0.02, -0.02, np.nan])
    np.testing.assert_allclose(by_point["e"], [0.01, 0.01, 0.01])
    np.testing.assert_allclose(by_point["f"], [-0.05, -0.05])
    assert np.isnan(by_point["c"]).all()
    mirrored = {
        name.replace("right", "x").replace("left", "right").replace("x", "left"): times
        for name, times in events.items()
    }
    pd.testing.assert_frame_equal(event_errors(phases, mirrored, "left"), errors)


def test_an_event_0_3_s_away_is_another_one(phases):
    events = {"heel_strike_right": [1.29, 1.69, 3.31]}
    errors = event_errors(phases, events, "right")
    found = errors.loc[errors["point"] == "b", "error_s"]
    np.testing.assert_allclose(found, [-0.29, np.nan, np.nan])


def test_the_clock_of_the_events_may_start_elsewhere(phases):
    errors = event_errors(phases, {"heel_strike_right": [101.0, 102.0, 103.0]}, "right", 100.0)
    np.testing.assert_allclose(errors.loc[errors["point"] == "b", "error_s"], 0.0, atol=1e-12)


def test_measured_values_fill_the_printed_tables(phases):
    errors = event_errors(phases, {"heel_strike_right": [1.02, 2.02, 3.02]}, "right")
    shares, points = (table.frame for table in phase_tables(phase_shares(phases), errors))
    np.testing.assert_allclose(shares.loc["f–g", "share of stride (%)"], 40.0)
    np.testing.assert_allclose(points.loc["b", "mean error (ms)"], -20.0)
    assert points.loc["e", "n"] == 0
