from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.evaluation.agreement import agreement
from narx.evaluation.comparison import Evaluated, knee, lag_s, rows
from narx.evaluation.results import COLUMNS
from narx.kinematics.joint_angles import grood_suntay, orientation_from_joint_angles
from narx.kinematics.segment_angles import angles_from_orientation, orientation_from_angles

N = 600


def walk(segment, offset=0.0, methods=("narx", "complementary_filter"), seed=0):
    generator = np.random.default_rng(seed)
    time_s = np.arange(N) / 100.0
    phase = 2 * np.pi * time_s[:, None] + offset
    reference = np.sin(phase + np.arange(3.0)) * [0.4, 0.1, 0.1]
    estimates = {m: reference + generator.normal(0, 0.02, (N, 3)) for m in methods}
    if "complementary_filter" in estimates:
        estimates["complementary_filter"][:, 2] = np.nan
    return Evaluated(
        dataset="simulated_gait",
        subject="S1",
        condition="normal",
        trial="1",
        segment=segment,
        sampling_rate_hz=100.0,
        time_s=time_s,
        reference_rad=reference,
        estimates_rad=estimates,
        scored=time_s >= 2.0,
        std_rad={"narx": np.full((N, 3), 0.02)},
    )


def test_rows_have_the_columns_of_results_and_only_scored_samples():
    trial = walk("thigh_right")
    table = rows(trial)
    assert len(table) == 6
    assert all(tuple(row) == COLUMNS for row in table)
    sagittal = next(r for r in table if (r["axis"], r["method"]) == ("sagittal", "narx"))
    expected = agreement(trial.reference_rad[200:, 0], trial.estimates_rad["narx"][200:, 0])
    assert {name: sagittal[name] for name in vars(expected)} == vars(expected)
    unseen = next(
        r for r in table if (r["axis"], r["method"]) == ("transverse", "complementary_filter")
    )
    assert unseen["n_samples"] == 0
    assert np.isnan(unseen["rmse_deg"])


def test_knee_of_perfect_estimates_is_the_reference_knee():
    thigh, shank = walk("thigh_left"), walk("shank_left", 0.5)
    thigh.estimates_rad["narx"][:] = thigh.reference_rad
    shank.estimates_rad["narx"][:] = shank.reference_rad
    joint = knee(thigh, shank)
    assert joint.segment == "knee_left"
    np.testing.assert_allclose(joint.estimates_rad["narx"], joint.reference_rad, atol=1e-12)
    expected = grood_suntay(
        orientation_from_angles(thigh.reference_rad), orientation_from_angles(shank.reference_rad)
    )
    np.testing.assert_allclose(joint.reference_rad, expected)


def test_knee_recovers_joint_angles_that_were_put_in():
    generator = np.random.default_rng(1)
    thigh, shank = walk("thigh_right"), walk("shank_right")
    angles = generator.uniform(-0.6, 0.6, (N, 3))
    thigh_wxyz = orientation_from_angles(thigh.reference_rad)
    shank.reference_rad[:] = angles_from_orientation(
        orientation_from_joint_angles(angles, thigh_wxyz)
    )
    np.testing.assert_allclose(knee(thigh, shank).reference_rad, angles, atol=1e-12)


def test_knee_of_a_method_without_heading_has_no_transverse_angle():
    thigh, shank = walk("thigh_right"), walk("shank_right", 0.5)
    joint = knee(thigh, shank).estimates_rad["complementary_filter"]
    assert np.isnan(joint[:, 2]).all()
    flat = [
        np.column_stack([e.estimates_rad["complementary_filter"][:, :2], np.zeros(N)])
        for e in (thigh, shank)
    ]
    expected = grood_suntay(*(orientation_from_angles(a) for a in flat))
    np.testing.assert_allclose(joint[:, :2], expected[:, :2])


def test_knee_reference_from_orientations_where_the_walk_turns():
    thigh, shank = walk("thigh_right"), walk("shank_right", 0.5)
    expected = knee(thigh, shank).reference_rad
    turn = Rotation.from_euler("z", np.linspace(0, 9, N)[:, None])
    wxyz = tuple(
        (turn * Rotation.from_quat(orientation_from_angles(e.reference_rad), scalar_first=True))
        .as_quat(scalar_first=True)
        for e in (thigh, shank)
    )  # fmt: skip
    for segment in (thigh, shank):
        segment.reference_rad[:, 2] = np.nan
    assert np.isnan(knee(thigh, shank).reference_rad).all()
    np.testing.assert_allclose(knee(thigh, shank, wxyz).reference_rad, expected, atol=1e-12)


def test_a_missing_sample_of_one_segment_is_missing_in_the_knee():
    thigh, shank = walk("thigh_right"), walk("shank_right")
    thigh.reference_rad[10] = np.nan
    shank.estimates_rad["narx"][20] = np.nan
    shank.scored[300] = False
    joint = knee(thigh, shank)
    assert np.isnan(joint.reference_rad[10]).all()
    assert np.flatnonzero(np.isnan(joint.estimates_rad["narx"]).any(axis=1)).tolist() == [20]
    assert not joint.scored[300]
    np.testing.assert_allclose(joint.std_rad["narx"], 0.02 * np.sqrt(2))


def test_knee_has_the_methods_that_both_segments_have():
    thigh = walk("thigh_right", methods=("narx", "vqf"))
    assert list(knee(thigh, walk("shank_right")).estimates_rad) == ["narx"]


def test_legs_are_not_mixed():
    with pytest.raises(ValueError, match="do not meet in a knee"):
        knee(walk("thigh_right"), walk("shank_left"))


def test_decimated_picks_samples_and_lets_go_of_the_rest():
    trial = walk("thigh_right")
    few = trial.decimated(20.0)
    assert few.sampling_rate_hz == 20.0
    np.testing.assert_array_equal(few.time_s, trial.time_s[::5])
    np.testing.assert_array_equal(few.estimates_rad["narx"], trial.estimates_rad["narx"][::5])
    assert few.reference_rad.base is None
    assert few.decimated(50.0).sampling_rate_hz == 20.0


def test_a_piece_of_time():
    piece = walk("thigh_right").between(2.0, 3.0)
    assert (piece.time_s[0], piece.time_s[-1]) == (2.0, 2.99)


def test_error_counts_where_scored():
    error = walk("thigh_right").error_deg("narx")
    assert np.isnan(error[:200]).all()
    assert np.isfinite(error[200:]).all()


def test_wrong_shapes_are_refused():
    trial = walk("thigh_right")
    with pytest.raises(ValueError, match=r"narx has shape \(599, 3\)"):
        Evaluated(**{**vars(trial), "estimates_rad": {"narx": np.zeros((N - 1, 3))}})
    with pytest.raises(ValueError, match="scored has shape"):
        Evaluated(**{**vars(trial), "scored": np.ones(3, bool)})


def test_whole_turns_are_not_errors():
    trial = walk("thigh_right")
    turned = {name: angles + 2 * np.pi for name, angles in trial.estimates_rad.items()}
    wound_up = replace(trial, estimates_rad=turned)
    for method in trial.estimates_rad:
        np.testing.assert_allclose(wound_up.error_deg(method), trial.error_deg(method), atol=1e-9)
    for turned_row, row in zip(rows(wound_up), rows(trial), strict=True):
        assert turned_row["rmse_deg"] == pytest.approx(row["rmse_deg"], nan_ok=True)


def test_an_error_is_the_short_way_round():
    trial = walk("thigh_right", methods=("narx",))
    ahead = {"narx": trial.reference_rad + np.radians([170.0, 190.0, 270.0])}
    error = replace(trial, estimates_rad=ahead).error_deg("narx")
    np.testing.assert_allclose(error[200:], np.tile([-170.0, 170.0, 90.0], (N - 200, 1)))


def test_a_late_angle_has_its_lag_in_milliseconds():
    """Exact for a shift small against the movement; a bias and another scale do not count."""
    late = 0.004
    time_s = np.arange(2000) / 100.0
    shape = np.array([0.4, 0.1, 0.1])
    angles = np.sin(2 * np.pi * time_s[:, None] + np.arange(3.0)) * shape
    shifted = np.sin(2 * np.pi * (time_s[:, None] - late) + np.arange(3.0)) * shape + 0.3
    shifted[300:320] = np.nan
    walked = replace(
        walk("thigh_right"),
        time_s=time_s,
        reference_rad=angles,
        estimates_rad={"narx": shifted, "vqf": angles},
        scored=time_s >= 2.0,
        std_rad={},
    )
    table = rows(walked)
    np.testing.assert_allclose([row["lag_ms"] for row in table[:3]], 1e3 * late, rtol=2e-3)
    np.testing.assert_allclose([row["lag_ms"] for row in table[3:]], 0.0, atol=1e-9)


def test_a_reference_that_does_not_move_shows_no_lag():
    still = replace(walk("thigh_right"), reference_rad=np.zeros((N, 3)))
    assert all(np.isnan(row["lag_ms"]) for row in rows(still))


def test_a_constant_error_is_no_lag():
    """Regression with an intercept, by hand: error = 0.5 + 0.1 slope."""
    slope = np.array([1.0, 3.0, 2.0, np.nan])
    assert lag_s(0.5 + 0.1 * slope, slope) == pytest.approx(0.1)


@pytest.mark.parametrize(("wanted_hz", "kept_hz"), [(60.0, 50.0), (70.0, 100.0), (30.0, 100 / 3)])
def test_decimation_takes_the_nearest_step(wanted_hz, kept_hz):
    assert walk("thigh_right").decimated(wanted_hz).sampling_rate_hz == pytest.approx(kept_hz)
