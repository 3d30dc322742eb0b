"""The gait curves: evaluation, timing and published values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.simulation import gait_curves
from narx.simulation.gait_curves import (
    TABLE_TOE_OFF,
    evaluate,
    fourier_series,
    joint_curves,
    swing_outwards,
    table_phase,
)

PHASE = np.arange(1000) / 1000


def test_series_pass_through_the_tables():
    for name in ("_HIP_FLEXION", "_KNEE_FLEXION", "_HIP_ADDUCTION", "_PELVIS_ROTATION"):
        table = getattr(gait_curves, name)
        curve = np.degrees(evaluate(fourier_series(table)[None], np.arange(20) / 20.0)[:, 0])
        np.testing.assert_allclose(curve, table, atol=0.8)


def test_seven_harmonics_hold_the_knee_to_a_tenth_of_a_degree():
    """Six of them miss its table by 0.23 degrees."""
    curve = np.degrees(evaluate(joint_curves(1.3)["knee"], np.arange(20) / 20.0)[:, 0])
    np.testing.assert_allclose(curve, gait_curves._KNEE_FLEXION, atol=0.15)


@pytest.mark.parametrize(
    ("joint", "channel", "percent", "expected_deg"),
    [
        # the pelvis tips forwards at heel strike, its right side leads, and drops after toe-off
        ("pelvis", 0, [0, 20], [0.6, -1.0]),
        ("pelvis", 1, [15, 60], [-4.2, 3.7]),
        ("pelvis", 2, [0, 50], [4.2, -4.2]),
        # the hip turns inwards in stance and outwards in swing
        ("hip", 2, [30, 70], [3.5, -4.2]),
        # Lafortune et al. (1992): the knee abducts by 5 degrees in swing, and turns inwards by 4
        # in loading, outwards by 5 in swing
        ("knee", 1, [40, 75], [0.0, 5.2]),
        ("knee", 2, [20, 80], [4.2, -5.0]),
    ],
)
def test_small_angles_have_their_published_signs(joint, channel, percent, expected_deg):
    found = evaluate(joint_curves(1.3)[joint], np.array(percent) / 100.0)[:, channel]
    np.testing.assert_allclose(np.degrees(found), expected_deg, atol=0.15)


def test_evaluate_is_the_sum_of_the_series():
    coefficients = joint_curves(1.0)["hip"]
    order = np.arange(coefficients.shape[1])
    expected = (coefficients[:, None] * np.exp(2j * np.pi * order * PHASE[:, None])).real.sum(-1)
    np.testing.assert_allclose(evaluate(coefficients, PHASE), expected.T, atol=1e-12)


def test_knee_flexion_is_as_published():
    # Kadaba et al. (1990), Winter (1991): about 60 deg in swing, 15-20 deg in loading
    knee = np.degrees(evaluate(joint_curves(1.3)["knee"], PHASE)[:, 0])
    assert 57.0 < knee.max() < 64.0
    assert 0.70 < PHASE[np.argmax(knee)] < 0.77
    loading = knee[PHASE < 0.3]
    assert 15.0 < loading.max() < 21.0
    assert 0.10 < PHASE[np.argmax(loading)] < 0.19
    assert 2.0 < knee[(PHASE > 0.3) & (PHASE < 0.5)].min() < 8.0


def test_hip_and_pelvis_ranges_are_as_published():
    hip = np.degrees(np.ptp(evaluate(joint_curves(1.3)["hip"], PHASE), axis=0))
    pelvis = np.degrees(np.ptp(evaluate(joint_curves(1.3)["pelvis"], PHASE), axis=0))
    assert 35.0 < hip[0] < 45.0
    assert 8.0 < hip[1] < 15.0
    assert 5.0 < hip[2] < 15.0
    assert np.all((pelvis > [1.0, 6.0, 6.0]) & (pelvis < [4.0, 11.0, 12.0]))


def test_in_single_stance_the_hip_is_adducted_and_the_other_side_of_the_pelvis_drops():
    """At 15 % of the right stride, as published: signs of abduction and of the right side down."""
    curves = joint_curves(1.3)
    hip, pelvis = (evaluate(curves[name], np.array([0.15]))[0] for name in ("hip", "pelvis"))
    assert np.degrees(hip[1]) == pytest.approx(-5.7, abs=0.3)
    assert np.degrees(pelvis[1]) == pytest.approx(-4.2, abs=0.3)


def test_frontal_and_transverse_movements_grow_with_the_root_of_the_speed():
    slow, fast = joint_curves(0.65), joint_curves(1.3)
    np.testing.assert_allclose(slow["pelvis"], np.sqrt(0.5) * fast["pelvis"])
    np.testing.assert_allclose(slow["hip"][1:], np.sqrt(0.5) * fast["hip"][1:])
    np.testing.assert_allclose(slow["hip"][0], fast["hip"][0])


def test_swinging_outwards_turns_the_hip_outwards_and_bends_the_knee_less():
    curves = joint_curves(1.0)
    swung = swing_outwards(curves)
    np.testing.assert_allclose(
        swung["hip"][2] - curves["hip"][2], (curves["hip"][1] - swung["hip"][1]) / 3.0
    )
    np.testing.assert_allclose(swung["knee"][0, 1:], 0.75 * curves["knee"][0, 1:])
    np.testing.assert_allclose(swung["knee"][0, 0], curves["knee"][0, 0])


def test_faster_walking_bends_the_knee_more():
    slow, fast = (evaluate(joint_curves(v)["knee"], PHASE)[:, 0] for v in (0.7, 1.2))
    loading, swing = (PHASE > 0.05) & (PHASE < 0.3), (PHASE > 0.65) & (PHASE < 0.85)
    assert np.degrees(fast[loading].max() - slow[loading].max()) > 2.0
    assert np.degrees(fast[swing].max() - slow[swing].max()) > 1.0


def test_the_outward_swing_is_largest_in_its_middle_and_half_as_large_a_quarter_from_its_ends():
    """A squared sine from 8 % of the stride before toe-off to heel strike."""
    curves = joint_curves(1.0)
    moments = np.array([0.55, 0.6625, 0.775, 0.8875])
    added = evaluate(swing_outwards(curves)["hip"] - curves["hip"], moments)[:, 1]
    np.testing.assert_allclose(np.degrees(added), [0.0, 7.0, 14.0, 7.0], atol=0.05)


def test_swinging_outwards_abducts_only_in_swing():
    curves = joint_curves(1.0)
    hip = np.degrees(evaluate(swing_outwards(curves)["hip"] - curves["hip"], PHASE))
    assert 12.0 < hip[:, 1].max() < 15.0
    assert TABLE_TOE_OFF < PHASE[np.argmax(hip[:, 1])] < 0.95
    assert np.abs(hip[(PHASE > 0.15) & (PHASE < 0.5), 1]).max() < 1.0
    assert np.abs(hip[:, 0]).max() < 1e-9


@settings(max_examples=30, deadline=None)
@given(toe_off=st.floats(0.57, 0.7))
def test_the_warp_keeps_order_heel_strike_and_toe_off(toe_off):
    phase = np.linspace(0.0, 2.0, 2001)
    warped = table_phase(phase, toe_off)
    assert np.all(np.diff(warped) > 0)
    assert table_phase(np.array([3.0]), toe_off)[0] == pytest.approx(3.0)
    assert table_phase(np.array([toe_off]), toe_off)[0] == pytest.approx(TABLE_TOE_OFF)
