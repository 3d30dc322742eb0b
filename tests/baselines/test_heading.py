import numpy as np
import pytest
from scipy.signal import lfilter

from narx import baselines
from narx.baselines.heading import Heading
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2

METHODS = {getattr(baselines, name).name: getattr(baselines, name) for name in baselines.__all__}
WITH_HEADING = ("complementary_filter", "giof", "madgwick", "mahony", "vqf")


def made(name, **options):
    if name == "vqf":
        pytest.importorskip("vqf")
    both = {"mode": "real_time"} if name == "giof" else {}
    return METHODS[name](**both, **options)


@pytest.mark.parametrize("name", WITH_HEADING)
def test_tilt_is_independent_of_the_heading_treatment(motion, name):
    turn = motion("half_turn", duration_s=30.0).signals
    own = made(name).estimate(turn)
    for treatment in ("zero", "leak"):
        treated = made(name, heading=treatment).estimate(turn)
        np.testing.assert_array_equal(treated[:, :2], own[:, :2])
    assert not made(name, heading="zero").estimate(turn)[:, 2].any()


def test_a_leak_is_a_high_pass_of_the_methods_own_heading(motion):
    turn = motion("half_turn", duration_s=30.0).signals
    own = made("madgwick").estimate(turn)[:, 2]
    kept = 1.0 / (1.0 + 0.01 * 0.3)
    expected = lfilter([kept, -kept], [1.0, -kept], own - own[0])
    leaked = made("madgwick", heading="leak", heading_leak_rad_s=0.3).estimate(turn)[:, 2]
    np.testing.assert_allclose(leaked, expected, atol=1e-12)


def test_without_a_heading_the_gyroscope_gives_it(motion):
    """The half turn appears, and decays with the leak's time constant."""
    turn, name = motion("half_turn", duration_s=60.0), "complementary_filter"
    assert np.isnan(made(name).estimate(turn.signals)[:, 2]).all()
    slow = made(name, coupled=True, heading="leak", heading_leak_rad_s=1e-6)
    np.testing.assert_allclose(
        slow.estimate(turn.signals)[:, 2], turn.angles_rad[:, 2], atol=np.deg2rad(5.0)
    )
    fast = made(name, coupled=True, heading="leak", heading_leak_rad_s=1.0)
    assert np.abs(fast.estimate(turn.signals)[-500:, 2]).max() < np.deg2rad(10.0)


@pytest.mark.parametrize("name", WITH_HEADING)
def test_a_leak_begins_at_the_known_heading(name):
    """A heading that is known at the first sample decays from there: no step, no other start."""
    still = SegmentSignals(
        "thigh_right", 100.0, np.zeros((300, 3)), np.tile([0.0, 0.0, GRAVITY_M_S2], (300, 1)),
        np.array([0.0, 0.0, 0.4]),
    )  # fmt: skip
    leaked = made(name, heading="leak", heading_leak_rad_s=2.0).estimate(still)[:, 2]
    # backward Euler of heading' = -leak heading, of which the first sample is a step already
    np.testing.assert_allclose(leaked, 0.4 / 1.02 ** np.arange(1, 301), atol=1e-12)


def test_the_heading_is_integrated_by_the_trapezoidal_rule():
    rates = np.zeros((3, 3))
    rates[:, 2] = [0.0, 1.0, 3.0]
    force = np.tile([0.0, 0.0, GRAVITY_M_S2], (3, 1))
    signals = SegmentSignals("thigh_right", 10.0, rates, force)
    method = made("complementary_filter", coupled=True, heading="leak", heading_leak_rad_s=1e-9)
    np.testing.assert_allclose(method.estimate(signals)[:, 2], [0.0, 0.05, 0.25], atol=1e-8)


def test_a_start_up_gives_the_posture_of_the_heading(motion):
    walk = motion("walking", duration_s=60.0)
    turned_in = np.array([0.0, 0.0, 0.4])
    signals = walk.changed(initial_angles_rad=turned_in).signals
    leaked = made("madgwick", heading="leak", start_up=True).estimate(signals)[3000:, 2]
    assert leaked.mean() == pytest.approx(0.4, abs=0.03)
    without = made("madgwick", heading="leak").estimate(signals)[3000:, 2]
    assert abs(without.mean()) < 0.05


def test_after_the_start_up_the_later_changes_leak():
    """By hand: the deviation at the hand-over decays, and each later change is added to it."""
    rng = np.random.default_rng(0)
    angles, rates = rng.normal(size=(2, 400, 3))
    start_up, turned_in = StartUp(duration_s=1.0, averaging_s=0.5), np.array([0.0, 0.0, 0.4])
    found = Heading("leak", 0.7).of(angles, rates, 0.01, turned_in, start_up)[:, 2]
    state = start_up.begin(turned_in)
    first = start_up.run(rates, 0.01, state)[:, 2]
    posture, deviation, *_ = StartUp.hand_over(state, 0.01)
    assert 100 <= len(first) < 150
    expected, level = [*first], deviation[2]
    for k in range(len(first), 400):
        level = (level + angles[k, 2] - angles[k - 1, 2]) / (1.0 + 0.01 * 0.7)
        expected.append(posture[2] + level)
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("name", WITH_HEADING)
def test_a_treated_heading_does_not_stream(name):
    with pytest.raises(MethodNotApplicableError, match="heading=zero is for whole recordings"):
        made(name, heading="zero").recursion(100.0, 1, None)


def test_wrong_treatments_are_one_clear_line():
    with pytest.raises(UserError, match="heading is 'north', expected one of own, zero, leak"):
        Heading("north")
    with pytest.raises(UserError, match=r"heading_leak_rad_s is 0.0, expected a positive number"):
        Heading("leak", 0.0)
