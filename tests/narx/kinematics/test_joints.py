"""Joints between segments whose angles are known."""

import numpy as np
import pytest

from narx.kinematics.joints import JOINTS, joint_between

ZERO = np.zeros((1, 3))


def _degrees(sagittal=0.0, frontal=0.0, transverse=0.0):
    return np.radians([[sagittal, frontal, transverse]])


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize(
    ("joint", "proximal", "distal", "expected"),
    [
        ("knee", _degrees(20), _degrees(-40), (60, 0, 0)),  # the shank hangs back: flexion
        ("hip", ZERO, _degrees(30), (30, 0, 0)),  # the thigh swings forward: flexion
        ("hip", _degrees(10), _degrees(30), (20, 0, 0)),
        ("ankle", _degrees(-10), _degrees(5), (15, 0, 0)),  # toes up against the shank
        ("knee", ZERO, _degrees(frontal=6), (0, 6, 0)),
        ("hip", ZERO, _degrees(transverse=8), (0, 0, 8)),
    ],
)
def test_signs(joint, side, proximal, distal, expected):
    angles = joint_between(f"{joint}_{side}", proximal, distal)
    assert np.degrees(angles[0]) == pytest.approx(expected, abs=1e-9)


def test_a_pelvis_leaning_to_one_side_abducts_one_hip_and_adducts_the_other():
    pelvis = _degrees(frontal=5)
    right, left = (
        np.degrees(joint_between(f"hip_{side}", pelvis, ZERO))[0] for side in ("right", "left")
    )
    assert right == pytest.approx([0, -5, 0], abs=1e-9)
    assert left == pytest.approx([0, 5, 0], abs=1e-9)


def test_every_joint_lies_between_segments_of_its_own_leg():
    assert set(JOINTS) == {f"{j}_{s}" for j in ("hip", "knee", "ankle") for s in ("right", "left")}
    for side in ("right", "left"):
        pairs = [(JOINTS[f"{j}_{side}"].proximal, JOINTS[f"{j}_{side}"].distal)
                 for j in ("hip", "knee", "ankle")]  # fmt: skip
        assert pairs == [
            ("pelvis", f"thigh_{side}"),
            (f"thigh_{side}", f"shank_{side}"),
            (f"shank_{side}", f"foot_{side}"),
        ]


def test_what_is_missing_stays_missing():
    missing = np.array([[np.nan, 0.0, 0.0]])
    assert np.isnan(joint_between("knee_right", missing, ZERO)).all()


def test_a_pelvis_that_turns_rotates_one_hip_outwards_and_the_other_inwards():
    pelvis = _degrees(transverse=7)
    right, left = (
        np.degrees(joint_between(f"hip_{side}", pelvis, ZERO))[0] for side in ("right", "left")
    )
    assert right == pytest.approx([0, 0, -7], abs=1e-9)
    assert left == pytest.approx([0, 0, 7], abs=1e-9)
