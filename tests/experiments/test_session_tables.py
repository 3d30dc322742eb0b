"""Tables of a session whose angles are straight lines in time, so that every cell is known."""

import numpy as np
import pytest

from narx.experiments.predictions.session import _summary
from narx.experiments.predictions.session_tables import angle_table, cycle_table, stride_table
from narx.inference.session import SessionPrediction

TIME_S = np.arange(0.0, 5.0001, 0.01)
# strides of 1, 0.8 and 1.2 s; those of the other leg are of 0.6 s
CONTACTS_S = {"right": np.array([1.0, 2.0, 2.8, 4.0]), "left": np.array([0.5, 1.1, 1.7])}


def _session(lost_s=()):
    """Right: rises by 5 deg/s from 10, falls by 2 deg/s, is 7; left: twice as much."""
    lines = np.radians(np.column_stack([10.0 + 5.0 * TIME_S, -2.0 * TIME_S, 7.0 + 0.0 * TIME_S]))
    for moment in lost_s:
        lines[round(100 * moment)] = np.nan
    angles = {"thigh_right": lines, "knee_right": lines, "knee_left": 2.0 * lines, "pelvis": lines}
    std = {"knee_right": np.radians([[1.0, 2.0, 3.0]]) + 0.0 * lines}
    quality = {"thigh_right": np.zeros(len(TIME_S), np.int8)}
    return SessionPrediction(TIME_S, 100.0, angles, std, quality, CONTACTS_S, ())


def test_angles_and_their_deviations_are_in_degrees():
    table = angle_table(_session())
    np.testing.assert_allclose(table["knee_left_sagittal_deg"], 20.0 + 10.0 * TIME_S, atol=1e-6)
    np.testing.assert_allclose(table["pelvis_frontal_deg"], -2.0 * TIME_S, atol=1e-6)
    for axis, deviation in (("sagittal", 1.0), ("frontal", 2.0), ("transverse", 3.0)):
        np.testing.assert_allclose(table[f"knee_right_{axis}_std_deg"], deviation)
    # six digits, and no more
    angles = table.filter(like="_deg")
    assert (angles.round(6) == angles).all(axis=None)
    assert table["knee_right_frontal_deg"].iloc[333] == pytest.approx(-6.66)


def test_strides_have_their_own_leg_and_numbers():
    table = stride_table(_session()).set_index(["name", "axis"])
    knee = table.loc[("knee_right", "sagittal")]
    assert knee["begin_s"].tolist() == [1.0, 2.0, 2.8]
    assert knee["duration_s"].tolist() == [1.0, 0.8, 1.2]
    # two steps a stride
    assert knee["cadence_steps_per_min"].tolist() == [120.0, 150.0, 100.0]
    np.testing.assert_allclose(knee["range_deg"], [5.0, 4.0, 6.0], atol=1e-3)
    np.testing.assert_allclose(knee["maximum_deg"], [20.0, 24.0, 30.0], atol=1e-3)
    np.testing.assert_allclose(knee["minimum_deg"], [15.0, 20.0, 24.0], atol=1e-3)
    falling = table.loc[("thigh_right", "frontal")]
    np.testing.assert_allclose(falling["maximum_deg"], [-2.0, -4.0, -5.6], atol=1e-3)
    np.testing.assert_allclose(falling["minimum_deg"], [-4.0, -5.6, -8.0], atol=1e-3)
    left = table.loc[("knee_left", "sagittal")]
    assert left["begin_s"].tolist() == [0.5, 1.1]
    np.testing.assert_allclose(left["range_deg"], 6.0, atol=1e-3)
    # the pelvis has no side
    assert "pelvis" not in table.index.get_level_values("name")


def test_a_stride_with_a_lost_sample_is_left_out_and_the_others_keep_their_numbers():
    session = _session(lost_s=[2.5])
    knee = stride_table(session).set_index(["name", "axis"]).loc[("knee_right", "frontal")]
    assert knee["stride"].tolist() == [1, 3]
    assert knee["begin_s"].tolist() == [1.0, 2.8]
    cycle = cycle_table(session).set_index(["name", "axis"]).loc[("knee_right", "sagittal")]
    assert (cycle["n_strides"] == 2).all()
    # strides of 1 s from 15 degrees and of 1.2 s from 24
    share = np.arange(101) / 100.0
    np.testing.assert_allclose(cycle["percent"], np.arange(101.0))
    one, other = 15.0 + 5.0 * share, 24.0 + 6.0 * share
    np.testing.assert_allclose(cycle["mean_deg"], 0.5 * (one + other), atol=1e-3)
    # of the strides that are there: half of the distance of two
    np.testing.assert_allclose(cycle["sd_deg"], 0.5 * (other - one), atol=1e-3)


def test_the_summary_counts_strides_and_steps_a_minute():
    """By the median stride: 1 s and 0.6 s."""
    assert _summary(_session()) == (
        "right 3 strides, 120 steps a minute; left 2 strides, 200 steps a minute"
    )
