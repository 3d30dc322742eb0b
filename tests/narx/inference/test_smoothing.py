"""Forward-backward smoothing: linear theory, time-reversal symmetry, and the ends."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.errors import MethodNotApplicableError
from narx.inference import composition
from narx.inference.narx_method import NarxMethod
from narx.inference.smoothing import forward_share, time_reversed
from narx.inference.start_up import StartUp
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights, random_weights

LEAK_RAD_S = 0.2
AT_ONCE = StartUp(duration_s=0.0)
TIME_S = np.arange(30000) / 100.0
MIDDLE = (TIME_S > 100) & (TIME_S < 200)


def method(start_up=AT_ONCE, coupled=False, smoothing=True, seed=None, **options):
    model = Narx(100.0, Normalisation(2.0, 0.25), coupled=coupled)
    weights = leaky_integrator_weights(model, LEAK_RAD_S)
    if seed is not None:
        weights = random_weights(model, np.random.default_rng(seed), slope=0.2)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(weights))
    options = {"washout_s": None} | options
    return NarxMethod(model, start_up, smoothing=smoothing, **options)


def signals(rates, start=None):
    return SegmentSignals("shank", 100.0, rates, np.zeros_like(rates), start)


def on_every_axis(rate):
    return np.tile(np.asarray(rate)[:, None], (1, 3))


@pytest.mark.parametrize("frequency_hz", [0.01, 0.03, 0.1, 0.9])
def test_gain_and_lag_are_those_of_the_smoother(frequency_hz):
    w = 2 * np.pi * frequency_hz
    # the angle is 0.1 sin(w t), small enough for tanh to be linear
    rates = on_every_axis(0.1 * w * np.cos(w * TIME_S))
    angles = 10.0 * method().estimate(signals(rates))[:, 0]
    expected = w**2 / (LEAK_RAD_S**2 + w**2) * np.sin(w * TIME_S)
    np.testing.assert_allclose(angles[MIDDLE], expected[MIDDLE], atol=2e-3)
    # a single pass has a phase lead, and the square root of this gain
    one = 10.0 * method(smoothing=False).estimate(signals(rates))[:, 0]
    lost = np.std((one - np.sin(w * TIME_S))[MIDDLE]) * np.sqrt(2)
    np.testing.assert_allclose(lost, LEAK_RAD_S / np.hypot(LEAK_RAD_S, w), rtol=0.03)


def test_a_constant_error_of_the_rate_leaves_nothing():
    rates = np.full((30000, 3), np.deg2rad(0.5))
    angles, one = (method(smoothing=s).estimate(signals(rates)) for s in (True, False))
    np.testing.assert_allclose(np.rad2deg(one[MIDDLE]), 0.5 / LEAK_RAD_S, rtol=1e-2)
    np.testing.assert_allclose(np.rad2deg(angles[MIDDLE]), 0.0, atol=1e-4)


def test_white_noise_leaves_half_the_variance():
    # integral of w^2 / (l^2 + w^2)^2 is half that of 1 / (l^2 + w^2)
    rates = 0.1 * np.random.default_rng(0).normal(size=(300000, 3))
    variance = [method(smoothing=s).estimate(signals(rates)).var() for s in (True, False)]
    np.testing.assert_allclose(variance[0] / variance[1], 0.5, rtol=0.1)


@pytest.mark.parametrize("coupled", [True, False])
def test_time_may_run_either_way(motion, coupled):
    """A movement between two rests of 40 s: reversed in time it gives the reversed angles."""
    still = np.zeros((4000, 3))
    rates = np.concatenate([still, motion("walking", duration_s=30.0).signals.axis_rates_rad_s])
    rates = np.concatenate([rates, still])
    m = method(coupled=coupled, seed=4)
    forth, back = (m.estimate(signals(r)) for r in (rates, -rates[::-1]))
    assert np.rad2deg(np.abs(forth).max()) > 10.0
    np.testing.assert_allclose(back[::-1], forth, atol=np.deg2rad(0.05))
    one = method(coupled=coupled, seed=4, smoothing=False)
    forth, back = (one.estimate(signals(r)) for r in (rates, -rates[::-1]))
    assert np.rad2deg(np.abs(back[::-1] - forth).max()) > 1.0


def test_a_washout_acts_in_both_directions(motion):
    still = np.zeros((4000, 3))
    rates = np.concatenate([still, motion("walking", duration_s=30.0).signals.axis_rates_rad_s])
    rates = np.concatenate([rates, still]) + np.radians([0.0, 0.3, -0.2])
    m = method(washout_s=8.0)
    forth, back = (m.estimate(signals(r)) for r in (rates, -rates[::-1]))
    np.testing.assert_allclose(back[::-1][100:-100], forth[100:-100], atol=np.deg2rad(0.1))
    assert np.rad2deg(np.abs(forth - method().estimate(signals(rates)))).max() > 0.3
    one = method(washout_s=8.0, smoothing=False).estimate(signals(rates))
    np.testing.assert_allclose(forth[-1], one[-1], rtol=1e-12)


def test_a_washout_leaves_the_posture_in_both_directions(motion):
    walk = motion("walking", duration_s=60.0).signals
    leaning = replace(walk, initial_angles_rad=np.array([0.4, 0.0, 0.0]))
    kept, washed = (
        method(START_UP, washout_s=washout_s).estimate(leaning)[3000:5000].mean(axis=0)
        for washout_s in (None, 8.0)
    )
    assert kept[0] > 0.3
    np.testing.assert_allclose(washed, kept, atol=0.03)


def test_a_network_without_a_start_up_does_not_know_its_start(motion):
    rates = motion("walking", duration_s=10.0).signals.axis_rates_rad_s
    given, unknown = (method().estimate(signals(rates, s)) for s in (np.full(3, 0.3), None))
    np.testing.assert_array_equal(given, unknown)


def test_tilted_turns_come_out_better_than_from_one_pass(motion):
    turn = motion("half_turn", duration_s=60.0)
    start_up, inside = StartUp(4.0, 3.0), slice(500, None)
    errors = [
        (method(start_up, True, s).estimate(turn.signals) - turn.angles_rad)[inside, :2]
        for s in (True, False)
    ]
    assert np.rad2deg(errors[0].std()) < 0.7 * np.rad2deg(errors[1].std())


START_UP = StartUp(4.0, 3.0)


def test_only_the_forward_pass_is_used_until_the_hand_over_of_a_known_start(motion):
    walk = motion("walking", duration_s=40.0)
    smoothed, one = (method(START_UP, True, s).estimate(walk.signals) for s in (True, False))
    taken = len(START_UP.run(walk.signals.axis_rates_rad_s, 0.01, START_UP.begin(np.zeros(3))))
    assert 400 <= taken < 600
    np.testing.assert_array_equal(smoothed[:taken], one[:taken])
    np.testing.assert_allclose(smoothed[-1], one[-1], rtol=1e-12)
    assert np.abs(smoothed - one)[taken + 400 :].max() > 1e-4
    # the angles are continuous where the weights change
    jumps = np.abs(np.diff(smoothed - walk.angles_rad, axis=0))
    assert np.rad2deg(jumps.max()) < 0.1


def test_a_known_start_settles_for_as_long_as_its_start_up_lasts(motion, monkeypatch):
    shares = []

    def watched(*arguments):
        shares.append(arguments)
        return forward_share(*arguments)

    monkeypatch.setattr(composition, "forward_share", watched)
    walk = motion("walking", duration_s=12.0)
    method(START_UP, True).estimate(walk.signals)
    taken = len(START_UP.run(walk.signals.axis_rates_rad_s, 0.01, START_UP.begin(np.zeros(3))))
    assert shares == [(walk.signals.n_samples, taken, 400, True)]


def test_an_unknown_start_is_corrected_by_later_samples(motion):
    """A leg that is flexed by 30 degrees at first and then swings about zero."""
    walk = motion("walking", duration_s=40.0)
    first = np.deg2rad(30.0) * np.exp(-TIME_S[:4001] / 1.0)
    rates = walk.signals.axis_rates_rad_s.copy()
    rates[:, 0] += np.gradient(first, 0.01)
    truth = walk.angles_rad[:, 0] + first - walk.angles_rad[2000:, 0].mean()
    smoothed, one = (
        method(START_UP, smoothing=s).estimate(signals(rates))[:, 0] for s in (True, False)
    )
    error = [np.rad2deg(np.abs(a - truth)[:100].mean()) for a in (smoothed, one)]
    assert error[1] > 10.0
    assert error[0] < 0.3 * error[1]


def test_shares():
    unknown = forward_share(10, 4, 5, known=False)[:, 0]
    np.testing.assert_allclose(unknown, [0, 0.125, 0.25, 0.375, *[0.5] * 6])
    known = forward_share(10, 2, 4, known=True)[:, 0]
    np.testing.assert_allclose(known, [1, 1, 1, 0.875, 0.75, 0.625, *[0.5] * 4])
    assert forward_share(3, 5, 4, known=True).tolist() == [[1.0]] * 3
    np.testing.assert_array_equal(forward_share(3, 0, 0, known=False)[1:], 0.5)


def test_time_reversed_state_continues_the_movement(motion):
    """The later deviation computed from the reversed state equals the true one."""
    walk = motion("half_turn", duration_s=20.0)
    posture = np.array([0.2, -0.1, 0.3])
    for k in (300, 900, 1500):
        here, later, rates = time_reversed(
            True, walk.signals.axis_rates_rad_s[k], walk.angles_rad[k], posture, 0.01
        )
        np.testing.assert_allclose(here + posture, walk.angles_rad[k], atol=1e-12)
        np.testing.assert_allclose(later + posture, walk.angles_rad[k + 1], atol=1e-3)
        change = (walk.angles_rad[k + 1] - walk.angles_rad[k - 1]) / 0.02
        np.testing.assert_allclose(-rates, change, atol=2e-2)


@pytest.mark.parametrize("n_samples", [0, 1, 2, 3])
def test_next_to_nothing(n_samples):
    angles = method().estimate(signals(np.ones((n_samples, 3))))
    assert angles.shape == (n_samples, 3)
    assert np.isfinite(angles).all()


def test_a_recording_that_ends_before_the_hand_over_is_left_as_it_is(motion):
    walk = motion("walking", duration_s=3.0).signals
    smoothed, one = (method(START_UP, smoothing=s).estimate(walk) for s in (True, False))
    np.testing.assert_array_equal(smoothed, one)


def test_gaps_other_rates_and_own_scales(motion):
    walk = motion("walking", 200.0, 30.0)
    rates = walk.signals.axis_rates_rad_s.copy()
    rates[3000:3010] = np.nan
    for options in ({}, {"axis_scaling": "own"}, {"washout_s": 100.0}):
        angles = method(START_UP, True, **options).estimate(
            replace(walk.signals, axis_rates_rad_s=rates)
        )
        assert np.isnan(angles[3000:3010]).all()
        there = np.isfinite(angles).all(axis=1)
        assert there.sum() == len(rates) - 10
        error = (angles - walk.angles_rad)[there]
        assert np.rad2deg(np.abs(error[2000:, :2]).max()) < 3.0


def test_it_neither_streams_nor_predicts_a_standard_deviation(motion):
    smoothed = method(error_std_rad=np.ones(3))
    with pytest.raises(MethodNotApplicableError, match="smoothing needs the whole recording"):
        smoothed.recursion(100.0, 1, None)
    assert smoothed.run(motion("still").signals).std_rad is None
