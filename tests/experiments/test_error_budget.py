"""The error budget: the floor without errors is exact, and the tables add up."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from narx.baselines import GyroIntegration
from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.experiments.error_budget import (
    budget_tables,
    exact_frame,
    exactly_tracked,
    knee_errors,
)
from narx.kinematics.joint_angles import grood_suntay
from narx.kinematics.segment_angles import (
    AXES,
    angles_from_orientation,
    mirror_quaternion,
    orientation_from_angles,
)

_SHORT = {
    "subjects": ["S2"],
    "conditions": ["fast"],
    "treadmill_duration_s": 15.0,
    "sampling_rate_hz": 100.0,
}


def test_exact_orientation_and_frame_give_no_error_without_error_sources():
    source = SimulatedGait(ideal=True, **_SHORT)
    method = GyroIntegration(coupled=True)
    rows = pd.DataFrame(knee_errors(source, "exact", method, 5.0))
    assert len(rows) == 2 * 2
    floor = rows[rows["estimate"] == "floor"]
    # sway in the first sample, at which methods begin with zero
    assert floor[list(AXES)].to_numpy().max() < 0.5
    integrated = rows[rows["estimate"] == "narx"]
    assert np.abs(integrated[list(AXES)].to_numpy() - floor[list(AXES)].to_numpy()).max() < 0.1


def test_the_exact_frame_is_the_bone_seen_from_the_sensor():
    source = SimulatedGait(ideal=True, **_SHORT)
    truth = source.truth("S2", "fast", "1")
    for segment in ("thigh_left", "shank_right"):
        bone, sensor = (
            Rotation.from_quat(of[segment], scalar_first=True)
            for of in (truth.segment_wxyz, truth.sensor_wxyz)
        )
        between = sensor * exact_frame(truth, segment).inv() * bone.inv()
        assert np.degrees(between.magnitude()).max() < 1e-6


def test_the_error_is_the_root_mean_square_of_the_scored_samples():
    """By hand, of a method that drifts: its mean error counts, that of the start does not."""
    source = SimulatedGait(**_SHORT)
    method = GyroIntegration(coupled=True)
    found = pd.DataFrame(knee_errors(source, "functional", method, 5.0))
    (trial,) = source
    calibrated = calibrate(trial, "functional")
    thigh, shank = calibrated["thigh_right"], calibrated["shank_right"]
    said = [orientation_from_angles(method.estimate(one.signals)) for one in (thigh, shank)]
    error = grood_suntay(thigh.reference_wxyz, shank.reference_wxyz) - grood_suntay(*said)
    late = np.degrees(error)[trial.time_s - trial.time_s[0] >= 5.0]
    row = found[(found["estimate"] == "narx") & (found["side"] == "right")].iloc[0]
    expected = np.sqrt(np.nanmean(late**2, axis=0))
    np.testing.assert_allclose(row[list(AXES)].astype(float), expected, rtol=1e-6)


@pytest.mark.parametrize("side", ["left", "right"])
def test_tracked_orientation_starts_at_zero_and_turns_in_the_frame_it_is_given(side):
    flexion = np.radians(np.linspace(0.0, 40.0, 50))
    bone = Rotation.from_euler("Y", -flexion[:, None])
    mounting = Rotation.random(random_state=3)
    start = Rotation.from_euler("Z", 50.0, degrees=True)
    sensor = (start * bone * mounting).as_quat(scalar_first=True)
    wxyz = exactly_tracked(sensor, mounting, f"thigh_{side}")
    np.testing.assert_allclose(
        np.degrees(angles_from_orientation(wxyz)),
        np.column_stack([np.degrees(flexion), 0 * flexion, 0 * flexion]),
        atol=1e-6,
    )
    # a frame off by 10 degrees about z shows a part of flexion as abduction
    off = Rotation.from_euler("Z", 10.0, degrees=True)
    turned = exactly_tracked(sensor, off * mounting, f"thigh_{side}")
    expected = (off * bone * off.inv()).as_quat(scalar_first=True)
    if side == "left":
        expected = mirror_quaternion(expected)
    np.testing.assert_allclose(turned * np.sign(turned[:, :1]), expected, atol=1e-9)


def test_tables_average_over_people_and_name_the_knees():
    rows = [
        {
            "variant": variant, "seed": 0, "subject": subject, "condition": "slow", "side": side,
            "estimate": estimate, "sagittal": 1.0, "frontal": size, "transverse": 3.0,
        }
        for variant, more in (("all", 1.0), ("without", 0.0))
        for subject, own in (("S1", 2.0), ("S2", 4.0))
        for side in ("right", "left")
        for estimate, size in (("floor", own + more), ("narx", own + more + 1.0))
    ]  # fmt: skip
    means, knees = budget_tables(pd.DataFrame(rows))
    assert means.frame["floor frontal"].to_dict() == {"all": 4.0, "without": 3.0}
    assert means.frame["narx frontal"].to_dict() == {"all": 5.0, "without": 4.0}
    assert knees.frame.loc["S2, seed 0", "narx left"] == 6.0


def test_the_command_leaves_a_row_a_variant_and_refuses_an_unknown_source(run_command):
    small = (
        "subjects=[S1]",
        "duration_s=12",
        "~variants",
        "+variants={all: {}, exact: {without: [landmarks], calibration: exact}}",
    )
    status, out, err, directory = run_command("error_budget", *small)
    assert status == 0, err
    errors = pd.read_csv(directory / "error_budget.csv")
    assert errors.groupby("variant").size().to_dict() == {"all": 12, "exact": 12}
    assert "floor frontal" in out
    assert "| all " in (directory / "error_budget.md").read_text()
    wrong = (*small[:3], "+variants={bad: {without: [magic]}}")
    status, _, err, _ = run_command("error_budget", *wrong)
    assert status == 2
    assert "variants.bad.without.0 is 'magic', expected one of sensor_tissue" in err
