"""Shares of errors within predicted bands, by condition, and the range of single trials."""

import numpy as np
import pytest

from narx.evaluation.comparison import Evaluated
from narx.experiments.tables.quality import coverage_table

N = 1000


def trial(condition, name, error_sd):
    reference = np.zeros((N, 3))
    # evenly spaced over +-3 error_sd, so the share within 0.99 and 1.96 follows by proportion
    estimate = np.tile(np.linspace(-3.0, 3.0, N)[:, None] * 0.01 * error_sd, 3)
    std = np.full((N, 3), 0.01)
    return Evaluated(
        "source", "person", condition, name, "thigh_right", 100.0, np.arange(N) / 100.0,
        reference, {"narx": estimate}, np.ones(N, bool), {"narx": std},
    )  # fmt: skip


def test_conditions_are_rows_and_trials_a_range():
    trials = [trial("walk", "a", 1.0), trial("walk", "b", 0.5), trial("hand", "c", 4.0)]
    frame = coverage_table(trials).frame.reset_index().set_index(["Axis", "Condition"])
    walk, hand = frame.loc[("sagittal", "walk")], frame.loc[("sagittal", "hand")]
    assert (walk["trials"], hand["trials"]) == (2, 1)
    # 1.96 / 3, and everything within 1.5
    assert walk["within 95 % band"] == pytest.approx(100 * (1.96 / 3 + 1.0) / 2, abs=0.2)
    assert walk["trials, 95 %"] == "65 to 100"
    assert hand["within 68 % band"] == pytest.approx(100 * 0.9945 / 12, abs=0.2)
    assert len(frame) == 6
    # root mean squares of a uniform distribution within +-3, +-1.5 and +-12
    assert walk["factor needed"] == pytest.approx(np.sqrt((9 + 1.5**2) / 2 / 3), rel=0.01)
    assert hand["factor needed"] == pytest.approx(12 / np.sqrt(3), rel=0.01)
    assert walk["predicted SD (°)"] == pytest.approx(np.degrees(0.01))


def test_each_axis_is_judged_by_its_own_deviation():
    one = trial("walk", "a", 1.0)
    one.std_rad["narx"][:] = [0.01, 0.02, 0.04]
    frame = coverage_table([one]).frame.reset_index().set_index("Axis")
    # errors within +-3, +-1.5 and +-0.75 deviations
    expected = [100 * 0.9945 / 3, 100 * 0.9945 / 1.5, 100.0]
    np.testing.assert_allclose(frame["within 68 % band"].astype(float), expected, atol=0.2)
    np.testing.assert_allclose(
        frame["predicted SD (°)"].astype(float), np.degrees([0.01, 0.02, 0.04])
    )


def test_without_a_prediction_there_is_no_table():
    assert coverage_table([]) is None
