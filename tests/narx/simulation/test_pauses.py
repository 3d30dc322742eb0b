"""Walkers pause, standing or sitting, and walk on; without pauses nothing changes."""

import numpy as np
import pytest

from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.kinematics.joint_angles import joint_angles
from narx.simulation.pauses import Pauses

SHORT = {
    "subjects": ["S1"],
    "conditions": ["normal"],
    "treadmill_duration_s": 30.0,
    "sampling_rate_hz": 100.0,
    "segments": ["thigh_right", "shank_right"],
    "ideal": True,
}


@pytest.fixture(scope="module")
def whole():
    return SimulatedGait(**SHORT).truth("S1", "normal", "1")


@pytest.mark.parametrize("sits", [False, True])
def test_a_pause_interrupts_the_walk_and_nothing_else(whole, sits):
    source = SimulatedGait(pauses_s=[[12.0, 22.0]], sits=sits, **SHORT)
    truth, trial = source.truth("S1", "normal", "1"), source.load("S1", "normal", "1")
    for joint, angles in truth.joint_angles.items():
        walks = (truth.time_s < 12.0) | (truth.time_s > 22.0)
        np.testing.assert_array_equal(angles[walks], whole.joint_angles[joint][walks])
        rests = (truth.time_s > 15.5) & (truth.time_s < 18.5)
        seated = sits and joint != "pelvis"
        flexion_deg = np.degrees(angles[rests, 0])
        np.testing.assert_allclose(flexion_deg, 80.0 if seated else 0.0, atol=1.0)
    assert all(not ((t > 12.0) & (t < 22.0)).any() for t in trial.events.values())
    assert all((t > 22.0).any() for t in trial.events.values())
    # the gyroscope's integral is the true motion: sensor and angles agree throughout
    shank, thigh = trial.reference["shank_right"], trial.reference["thigh_right"]
    knee = joint_angles(thigh.quaternion_wxyz, shank.quaternion_wxyz, "right")
    np.testing.assert_allclose(knee, truth.joint_angles["knee_right"], atol=1e-9)
    rate = np.linalg.norm(trial.imus["thigh_right"].gyroscope_rad_s, axis=1)
    assert rate[rests].max() < np.radians(5.0)
    turned_deg = np.degrees(rate[(truth.time_s > 13.5) & (truth.time_s < 15.5)].sum() / 100.0)
    assert turned_deg > 75.0 if sits else turned_deg < 5.0


def test_the_steps_cease_first_then_the_walker_sits_down():
    """1.5 s to stand, 1.8 s to sit, and the same in reverse; half-way each is half of it."""
    pauses = Pauses([(10.0, 30.0)], True)
    size = pauses.walking(np.array([10.0, 10.75, 11.5, 20.0, 28.5, 29.25, 30.0]))
    np.testing.assert_allclose(size, [1.0, 0.5, 0.0, 0.0, 0.0, 0.5, 1.0], atol=1e-12)
    seat = pauses.seat_rad(np.array([11.5, 12.4, 13.3, 20.0, 26.7, 27.6, 28.5]))
    np.testing.assert_allclose(np.degrees(seat), [0.0, 40.0, 80.0, 80.0, 80.0, 40.0, 0.0])
    assert not Pauses([(10.0, 30.0)]).seat_rad(np.array([20.0])).any()


@pytest.mark.parametrize(
    ("pauses_s", "sits"),
    [
        ([[5.0, 15.0]], False),  # before the first full step
        ([[12.0, 14.0]], False),
        ([[12.0, 17.0]], True),  # long enough for standing alone
        ([[12.0, 18.0], [17.0, 24.0]], False),
        ([[22.0, 31.0]], False),
        ([[float("nan"), 20.0]], False),
    ],
)
def test_pauses_without_room_are_refused(pauses_s, sits):
    with pytest.raises(UserError, match="pauses_s"):
        SimulatedGait(pauses_s=pauses_s, sits=sits, **SHORT)


def test_pauses_are_those_of_a_treadmill():
    with pytest.raises(UserError, match="pauses_s is for protocol=treadmill"):
        SimulatedGait(protocol="stand_walk_stand", pauses_s=[[12.0, 20.0]])
