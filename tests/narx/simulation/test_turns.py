"""Walkers turn, lean into the turn, and are pulled to its centre."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.datasets.simulated_gait import SimulatedGait
from narx.errors import UserError
from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.skeleton import SkeletonMotion
from narx.simulation.turns import Turns

SHORT = {
    "subjects": ["S1"],
    "conditions": ["normal"],
    "treadmill_duration_s": 16.0,
    "segments": ["thigh_right"],
    "ideal": True,
}


def test_rates_integrate_to_the_true_orientation_and_the_path_follows(integrated):
    source = SimulatedGait(turns_s=[[10.0, 12.0], [13.0, 14.5]], turn_deg=120.0, **SHORT)
    trial, truth = source.load("S1", "normal", "1"), source.truth("S1", "normal", "1")
    true = Rotation.from_quat(truth.sensor_wxyz["thigh_right"], scalar_first=True)
    begin = round(9.5 * trial.sampling_rate_hz)
    rate = trial.imus["thigh_right"].gyroscope_rad_s[begin:]
    found = integrated(rate, trial.sampling_rate_hz, true[begin + 1])
    assert (found.inv() * true[begin + 1 : -1]).magnitude().max() < 1e-6
    assert not trial.straight
    heading = Turns([(10.0, 12.0), (13.0, 14.5)], 120.0).heading_rad(np.array([0.0, 11, 12.5, 15]))
    np.testing.assert_allclose(np.degrees(heading), [0.0, 60.0, 120.0, 0.0], atol=1e-9)
    place = truth.sensor_position_m["thigh_right"]
    begin, end = (round(t * trial.sampling_rate_hz) for t in (12.0, 13.0))
    course = np.degrees(np.arctan2(*(place[end] - place[begin])[1::-1]))
    assert course == pytest.approx(120.0, abs=8.0)


def test_a_walker_leans_about_its_own_forward_axis_and_limbs_go_along():
    """Heading first, then the lean: a thigh beside the pelvis turns and tips with it."""
    rate_hz, speed_m_s = 500.0, 1.5
    time_s = np.arange(2000) / rate_hz
    still = Rotation.identity(len(time_s))
    beside = np.tile([0.0, 0.1, -0.4], (len(time_s), 1))
    straight = SkeletonMotion(
        time_s,
        rate_hz,
        {},
        {"thigh_left": still},
        {"thigh_left": beside},
        np.column_stack([speed_m_s * time_s, 0.0 * time_s, np.full(len(time_s), 0.9)]),
    )
    turned = Turns([(0.0, 4.0)], 120.0).turned(straight, speed_m_s)
    middle = 1000
    lean = -np.arctan(speed_m_s * (35.0 / 16.0 * np.radians(120.0) / 4.0) / GRAVITY_M_S2)
    heading = Rotation.from_rotvec([0.0, 0.0, np.radians(60.0)])
    expected = heading * Rotation.from_rotvec([lean, 0.0, 0.0])
    found = turned.orientations["thigh_left"][middle]
    assert (expected.inv() * found).magnitude() < 1e-6
    place = turned.centres_m["thigh_left"][middle]
    np.testing.assert_allclose(place, expected.apply(beside[0]), atol=1e-6)
    # the hips tip about the ground below them
    assert turned.pelvis_m[middle, 2] == pytest.approx(0.9 * np.cos(lean), abs=1e-6)


def test_a_steady_turn_is_that_of_a_body_on_a_circle():
    """Uniform motion on a circle: radius v / w, centripetal force v w, lean atan(v w / g)."""
    rate_hz, speed_m_s, duration_s = 500.0, 1.5, 20.0
    time_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    straight = SkeletonMotion(
        time_s,
        rate_hz,
        {},
        {"pelvis": Rotation.identity(len(time_s))},
        {"pelvis": np.zeros((len(time_s), 3))},
        np.column_stack([speed_m_s * time_s, 0.0 * time_s, np.full(len(time_s), 0.9)]),
    )
    turns = Turns([(0.0, duration_s)], 180.0)
    turned = turns.turned(straight, speed_m_s)
    middle = len(time_s) // 2
    # the peak rate of the smooth step is 35 / 16 of its mean
    rate = 35.0 / 16.0 * np.pi / duration_s
    acceleration = turned.acceleration("pelvis", np.zeros(3))[middle]
    heading = turns.heading_rad(time_s)[middle]
    left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    # the lean moves the hips by 2 mm/s^2 more or less
    assert acceleration @ left == pytest.approx(speed_m_s * rate, rel=0.02)
    force = acceleration + np.array([0.0, 0.0, GRAVITY_M_S2])
    in_body = turned.orientations["pelvis"][middle].inv().apply(force)
    assert abs(in_body[1]) < 0.01
    up = turned.orientations["pelvis"][middle].apply([0.0, 0.0, 1.0])
    assert np.arctan2(up @ left, up[2]) == pytest.approx(np.arctan(speed_m_s * rate / 9.80665))


@pytest.mark.parametrize(
    "turns_s", [[[5.0, 9.0]], [[10.0, 10.3]], [[10.0, 12.0], [11.0, 13.0]], [[14.0, 17.0]]]
)
def test_turns_without_room_are_refused(turns_s):
    with pytest.raises(UserError, match="turns_s has"):
        SimulatedGait(turns_s=turns_s, **SHORT)


def test_turns_are_those_of_a_treadmill():
    with pytest.raises(UserError, match="turns_s is for protocol=treadmill"):
        SimulatedGait(protocol="stand_walk_stand", turns_s=[[12.0, 14.0]])
