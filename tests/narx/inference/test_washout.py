"""The slow mean subtracted from the network's output."""

import numpy as np
import pytest
import torch

from narx.errors import UserError
from narx.inference.narx_method import NarxMethod
from narx.inference.start_up import StartUp
from narx.inference.washout import wash_out, washout_gain
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights

POSTURE = np.array([0.3, -0.1, 0.0])


def test_by_hand():
    angles = POSTURE + np.array([[1.0, 0.0, 2.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    mean = np.zeros(3)
    washed = wash_out(angles, POSTURE, 0.25, mean)
    np.testing.assert_allclose(mean, [0.578125, 0.1875, 0.28125], atol=1e-15)
    means = [[0.25, 0.0, 0.5], [0.4375, 0.25, 0.375], [0.578125, 0.1875, 0.28125]]
    np.testing.assert_allclose(washed, angles - means, atol=1e-15)


def test_in_pieces_it_is_the_whole():
    angles = POSTURE + np.random.default_rng(0).normal(size=(500, 3))
    gain = washout_gain(2.0, 0.01)
    whole = wash_out(angles, POSTURE, gain, np.zeros(3))
    mean = np.zeros(3)
    pieces = [
        wash_out(piece, POSTURE, gain, mean) for piece in np.split(angles, [0, 1, 170, 170, 499])
    ]
    np.testing.assert_allclose(np.concatenate(pieces), whole, atol=1e-13)


def test_none_leaves_every_bit():
    angles, mean = np.random.default_rng(0).normal(size=(50, 3)), np.zeros(3)
    assert washout_gain(None, 0.01) == 0.0
    np.testing.assert_array_equal(wash_out(angles, POSTURE, 0.0, mean), angles)
    assert not mean.any()


@pytest.mark.parametrize("washout_s", [0.0, -1.0, float("nan"), float("inf"), "long"])
def test_a_time_constant_that_is_none_is_refused(washout_s):
    with pytest.raises(UserError, match=r"washout_s is .*, expected seconds above zero"):
        washout_gain(washout_s, 0.01)


def constant_rate(rate_rad_s, duration_s, washout_s, known):
    """Response to a constant gyroscope bias: a swinging leg with it, less the same without."""
    time = np.arange(round(100 * duration_s)) / 100.0
    swing = np.zeros((len(time), 3))
    swing[:, 0] = 2.0 * np.cos(2 * np.pi * 0.9 * time)
    model = Narx(100.0, Normalisation(2.0, 0.25), coupled=False)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, 0.2)))
    method = NarxMethod(model, StartUp(4.0, 3.0), washout_s=washout_s)
    angles = [
        method.estimate(
            SegmentSignals("shank", 100.0, rates, swing, np.zeros(3) if known else None)
        )[:, 1]
        for rates in (swing + np.array([0.0, rate_rad_s, 0.0]), swing)
    ]
    return time, angles[0] - angles[1]


@pytest.mark.parametrize("known", [True, False])
def test_a_constant_rate_fades_with_the_time_constant(known):
    rate, leak, washout = np.deg2rad(0.1), 0.2, 40.0
    time, lasting = constant_rate(rate, 300.0, None, known)
    # eq. (4) of Tham et al.: gain 1 / leak; the start-up's posture error stays below it
    posture = lasting[-1] - rate / leak
    assert known or abs(posture) < 1e-3 * rate / leak
    time, washed = constant_rate(rate, 300.0, washout, known)
    # leaky integrator and washout in series: once the integrator has settled, a pure decay
    late = time > 60.0
    decay = np.polyfit(time[late], np.log(np.abs(washed[late] - posture)), 1)
    np.testing.assert_allclose(decay[0], -1.0 / washout, rtol=0.02)
    assert abs(washed[-1] - posture) < 0.005 * rate / leak


def test_it_is_the_high_pass_of_theory():
    gain = washout_gain(10.0, 0.01)
    time = np.arange(3000) * 0.01
    step = wash_out(np.ones((3000, 3)), np.zeros(3), gain, np.zeros(3))
    np.testing.assert_allclose(step[:, 0], np.exp(-(time + 0.01) / 10.0), atol=1e-3)
    # of a stride a second it takes a sine of 1 / (2 pi 10)
    swing = np.sin(2 * np.pi * time)[:, None] * np.ones(3)
    taken = swing - wash_out(swing, np.zeros(3), gain, np.zeros(3))
    np.testing.assert_allclose(np.ptp(taken[-100:]), 2.0 / (2 * np.pi * 10.0), rtol=0.02)


def test_the_gain_is_backward_euler():
    """m' = (d - m) / T, with the derivative at the end of the step: (m T + h d) / (T + h)."""
    assert washout_gain(3.0, 1.0) == pytest.approx(0.25)
    assert washout_gain(1.0, 1.0) == pytest.approx(0.5)
