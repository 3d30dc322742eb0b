"""The individual walkers: speed, cadence, ranges."""

import itertools

import numpy as np
import pytest

from narx.errors import UserError
from narx.simulation.body import TABLE_1, body_of
from narx.simulation.skeleton import forward_velocity
from narx.simulation.walker import (
    pelvis_velocity,
    stride_frequency_hz,
    walking_pattern,
)

PHASE = np.arange(400) / 400


@pytest.mark.parametrize("subject", list(TABLE_1))
@pytest.mark.parametrize("speed_m_s", [0.72, 0.92, 1.19])
def test_feet_carry_the_walker_at_the_speed(subject, speed_m_s):
    body = TABLE_1[subject]
    pattern = walking_pattern(subject, body, speed_m_s, 0)
    phase = np.arange(3 * 128) / 128
    velocity = forward_velocity(
        pattern.joint_angles(phase), phase, pattern.toe_off, pattern.left_lag, body,
        128 / pattern.stride_s,
    )  # fmt: skip
    assert velocity[128:256, 0].mean() == pytest.approx(speed_m_s, abs=0.005)


def test_strides_are_about_as_many_as_the_paper_counted():
    # Tham et al. (2020), section III: cycles of five subjects, five minutes each
    for speed_km_h, counted in ((2.6, 1109), (3.3, 1272), (4.3, 1413)):
        strides = sum(
            300.0 * stride_frequency_hz(speed_km_h / 3.6, body.height_m)
            for body in TABLE_1.values()
        )
        assert strides == pytest.approx(counted, rel=0.06)


def test_joint_ranges_are_human():
    for subject, body in TABLE_1.items():
        for speed_m_s in (0.72, 1.19):
            angles = walking_pattern(subject, body, speed_m_s, 0).joint_angles(PHASE)
            for side in ("right", "left"):
                knee = np.degrees(angles[f"knee_{side}"])
                hip = np.degrees(angles[f"hip_{side}"])
                assert 38.0 < np.ptp(knee[:, 0]) < 72.0
                assert knee[:, 0].min() > -8.0
                assert np.ptp(knee[:, 1]) < 9.0
                assert 25.0 < np.ptp(hip[:, 0]) < 50.0
                assert hip[:, 0].max() > 10.0 > -2.0 > hip[:, 0].min()


def test_a_person_is_the_same_at_every_speed_and_unlike_another():
    def knee(subject, speed):
        pattern = walking_pattern(subject, TABLE_1["S1"], speed, 0)
        return np.degrees(pattern.joint_angles(PHASE)["knee_right"][:, 0])

    def distance(a, b):
        return np.sqrt(np.mean((a - b) ** 2))

    assert distance(knee("S1", 0.9), knee("S1", 0.92)) < 0.5
    assert distance(knee("S1", 0.9), knee("S2", 0.9)) > 1.5


def test_legs_of_one_person_differ_less_than_two_persons():
    persons = [f"V{k}" for k in range(1, 25)]
    curves = [
        {
            side: walking_pattern(p, TABLE_1["S1"], 0.9, 0).curves[f"knee_{side}"][0]
            for side in ("right", "left")
        }
        for p in persons
    ]
    within = np.mean([np.abs(c["right"] - c["left"]) ** 2 for c in curves])
    between = np.mean([np.abs(a["right"] - b["right"]) ** 2 for a, b in itertools.pairwise(curves)])
    assert within < 0.5 * between


def test_usual_pelvis_velocity():
    velocity = pelvis_velocity(PHASE, 0.7, 1.4)
    assert velocity[:, 0].mean() == pytest.approx(0.7)
    path = np.cumsum(velocity[:, 1]) * 1.4 / len(PHASE)
    assert np.ptp(path) == pytest.approx(0.07, abs=0.001)


def test_bodies():
    assert body_of("S2", 0).height_m == 1.84
    assert body_of("V7", 0) == body_of("V7", 0) != body_of("V7", 1)
    heights = [body_of(f"V{k}", 0).height_m for k in range(1, 300)]
    assert np.mean(heights) == pytest.approx(1.69, abs=0.02)
    with pytest.raises(UserError, match="subject 'S9', expected S1"):
        body_of("S9", 0)
