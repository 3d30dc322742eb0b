"""The stability statement for networks of known stability."""

import json
import math

import numpy as np
import pytest
import torch
from scipy import signal

from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.stability import _rates, stability_statement
from narx.network.structure import NarxStructure
from narx.training.initial_weights import random_weights

RATE_HZ = 50.0


def linear_network(a1, a2, gain, coupled=False):
    """A network that is p_k = gain v_k + a1 p_{k-1} + a2 p_{k-2} for small arguments."""
    model = Narx(RATE_HZ, Normalisation(2.0, 0.4, rate_rms_rad_s=0.7), coupled=coupled)
    slope = 0.02
    with torch.no_grad():
        model.weights[0], model.weights[2], model.weights[3] = slope * gain, slope * a1, slope * a2
        model.weights[model.structure.w2.start] = 1.0 / slope
    return model


@pytest.mark.parametrize("coupled", [False, True])
def test_leaky_integrator(coupled):
    pole = math.exp(-1.0 / (RATE_HZ * 0.8))  # a time constant of 0.8 s
    statement = stability_statement(linear_network(pole, 0.0, 0.01, coupled))
    assert statement.operating_point_rad == 0.0
    assert statement.largest_pole == pytest.approx(pole)
    assert statement.time_constant_s == pytest.approx(0.8)
    assert statement.gain_at_zero_frequency_s == pytest.approx(0.01 / (1 - pole) * 0.4 / 2.0)
    assert statement.contracts
    assert statement.recovers
    assert statement.stable
    assert statement.contraction_ratio < 0.01
    assert statement.output_bound_rad == pytest.approx(50.0 * 0.4)
    json.dumps(vars(statement))


def test_the_gain_counts_the_feedback_of_both_angles():
    """At rest p = gain v + (a1 + a2) p."""
    statement = stability_statement(linear_network(0.6, 0.3, 0.01))
    assert statement.gain_at_zero_frequency_s == pytest.approx(0.01 / 0.1 * 0.4 / 2.0)


def test_an_oscillator_has_complex_poles():
    radius, angle = 0.9, 0.3
    statement = stability_statement(linear_network(2 * radius * math.cos(angle), -(radius**2), 0.1))
    poles = np.array([complex(*pole) for pole in statement.poles])
    np.testing.assert_allclose(np.sort_complex(poles), radius * np.exp([-1j * angle, 1j * angle]))
    assert statement.stable


def test_a_pole_outside_the_unit_circle_is_seen():
    """tanh bounds the output, so a bounded output is no evidence of stability."""
    statement = stability_statement(linear_network(1.02, 0.0, 0.01))
    assert statement.largest_pole == pytest.approx(1.02)
    assert statement.time_constant_s is None
    assert not statement.contracts
    assert not statement.stable
    assert math.isfinite(statement.excursion_rad)
    assert statement.excursion_rad <= statement.output_bound_rad
    json.dumps(vars(statement))


def test_contraction_bound_proves_where_it_can():
    statement = stability_statement(linear_network(0.9, 0.0, 0.1))
    assert statement.contraction_bound < 1.0
    assert statement.stable


def test_operating_point_of_a_network_with_biases():
    model = Narx(RATE_HZ, Normalisation(2.0, 0.4, 0.1, 0.05), odd=False, coupled=False)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(random_weights(model, np.random.default_rng(0))))
    statement = stability_statement(model)
    rest, _ = model(torch.zeros(1, 60 * int(RATE_HZ), 3, dtype=torch.float64))
    assert statement.operating_point_rad == pytest.approx(rest[0, -1, 0].item(), abs=1e-3)
    # the gain is the slope of the angle at rest against a small constant rate
    small = torch.full((1, 60 * int(RATE_HZ), 3), 1e-5, dtype=torch.float64)
    moved, _ = model(small)
    slope = (moved[0, -1, 0] - rest[0, -1, 0]).item() / 1e-5
    assert statement.gain_at_zero_frequency_s == pytest.approx(slope, rel=1e-2)


def test_coupled_axes_can_keep_two_states_apart_although_each_axis_contracts():
    """A steady turn about a tilted axis has several limits; a bound per axis proves nothing."""
    pole = math.exp(-1.0 / (RATE_HZ * 5.3))
    # gain of an integrator: the estimate turns as far as the segment
    gain = 2.0 / 0.4 / RATE_HZ
    statement = stability_statement(linear_network(pole, 0.0, gain, coupled=True))
    assert statement.contraction_bound < 1.0
    assert statement.coupled_rates_tried == 100
    assert 0 < statement.coupled_rates_apart < 20
    assert max(map(abs, statement.coupled_rate_apart_rad_s)) <= math.radians(20.0)
    alone = stability_statement(linear_network(pole, 0.0, gain, coupled=False))
    assert (alone.coupled_rates_tried, alone.coupled_rates_apart) == (0, 0)
    assert alone.coupled_rate_apart_rad_s is None


@pytest.mark.parametrize(
    ("rate_scale", "rate_rms", "angle_scale", "rate_range", "angle_range"),
    [
        (2.0, 0.7, 0.4, 2.1, 1.0),  # three times the rms; angles up to 1 rad
        (2.0, 0.5, 0.2, 2.0, 0.6),  # the scale itself; three times the scale
    ],
)
def test_the_tested_range_is_that_of_gait(
    rate_scale, rate_rms, angle_scale, rate_range, angle_range
):
    """Peaks of gait are about three times its root mean square."""
    model = linear_network(0.97, 0.0, 0.01)
    model.normalisation = Normalisation(rate_scale, angle_scale, rate_rms_rad_s=rate_rms)
    statement = stability_statement(model, n_levels=3)
    assert statement.rate_range_rad_s == pytest.approx(rate_range)
    assert statement.angle_range_rad == pytest.approx(angle_range)


def test_the_excursion_is_that_of_ten_times_the_rates():
    """A linear network at its gain: constant rates reach the angles of the range, times ten."""
    pole = math.exp(-1.0 / (RATE_HZ * 0.3))
    model = linear_network(pole, 0.0, 0.01)
    statement = stability_statement(model, n_levels=3)
    leak = 1.0 / 0.3
    size = min(statement.rate_range_rad_s, leak * statement.angle_range_rad)
    constant = 10.0 * size * statement.gain_at_zero_frequency_s
    assert statement.excursion_rad == pytest.approx(constant, rel=0.15)


def test_the_sign_of_a_neuron_does_not_change_the_bound():
    """Tanh is odd: with both its weights negated, a neuron computes the same."""
    model = linear_network(0.9, 0.0, 0.01)
    expected = stability_statement(model).output_bound_rad
    with torch.no_grad():
        for weights in (model.structure.w1, model.structure.b1, model.structure.w2):
            model.weights[weights] *= -1.0
    assert stability_statement(model).output_bound_rad == pytest.approx(expected)


def test_a_leaky_integrator_swings_through_the_tested_range_at_every_frequency():
    """Rates are those of an angle of the given size, unless they exceed the range of rates."""
    leak, rate_hz, n = 1.5, 200.0, 5
    rates = _rates(rate_hz, 60.0, 3.0, 0.5, leak, n, seed=0)[n : 2 * n].numpy()
    keep = np.exp(-leak / rate_hz)
    angles = signal.lfilter([(1.0 - keep) / leak], [1.0, -keep], rates, axis=1)
    reached = np.abs(angles[:, int(20 * rate_hz) :]).max(axis=(1, 2))
    limited = np.abs(rates).max(axis=(1, 2)) > 2.9
    assert limited.tolist() == [False, False, False, True, True]
    np.testing.assert_allclose(reached[~limited], 0.5, rtol=0.02)


@pytest.mark.parametrize(
    ("time_constant_s", "contraction_s", "contracts"),
    [(0.5, 10.0, True), (3.0, 24.0, True), (100.0, 300.0, False)],
)
def test_states_have_eight_time_constants_to_meet(time_constant_s, contraction_s, contracts):
    """At least 10 s, and at most 300 s, after which a twentieth is left of 100 s."""
    pole = math.exp(-1.0 / (RATE_HZ * time_constant_s))
    statement = stability_statement(linear_network(pole, 0.0, 1e-4), n_levels=2)
    assert statement.contraction_s == pytest.approx(contraction_s)
    left = math.exp(-contraction_s / time_constant_s)
    assert statement.contraction_ratio == pytest.approx(left, rel=0.25, abs=1e-9)
    assert statement.contracts == statement.stable == contracts


def test_the_bound_is_that_of_the_worst_slopes():
    """p = 1.5 p - 0.6 p by two neurons: while one of them is saturated, a step may grow by 1.5."""
    model = Narx(RATE_HZ, Normalisation(2.0, 0.4), NarxStructure(2, 1, 1, 1), coupled=False)
    with torch.no_grad():
        model.weights[model.structure.w1] = torch.tensor([0.0, 0.02, 0.0, 0.02])
        model.weights[model.structure.w2] = torch.tensor([75.0, -30.0])
    statement = stability_statement(model, n_levels=2)
    assert statement.largest_pole == pytest.approx(0.9)
    assert statement.contraction_bound == pytest.approx(1.5)


def test_the_bound_of_a_rotation_is_its_radius():
    """p_k = -0.81 p_{k-2}: in the norm in which it turns, both of its slopes shrink by 0.9."""
    statement = stability_statement(linear_network(0.0, -0.81, 0.01), n_levels=2)
    assert statement.contraction_bound == pytest.approx(0.9)


def test_rest_is_the_operating_point():
    """p = 0.9 p + 0.1: after the excursion it returns to 1 in units of 0.4 rad, not to zero."""
    model = Narx(RATE_HZ, Normalisation(2.0, 0.4), odd=False, coupled=False)
    with torch.no_grad():
        model.weights.copy_(linear_network(0.9, 0.0, 0.01).weights)
        model.weights[model.structure.b2] = 0.1
    statement = stability_statement(model, n_levels=2)
    assert statement.operating_point_rad == pytest.approx(0.4, rel=1e-3)
    assert statement.recovers
    assert statement.recovery_ratio < 1e-6


@pytest.mark.parametrize(("rate_hz", "highest_hz"), [(20.0, 5.0), (100.0, 10.0)])
def test_the_highest_frequency_is_one_that_the_rate_resolves(rate_hz, highest_hz):
    fastest = _rates(rate_hz, 20.0, 3.0, 0.5, 1.5, 3, seed=0)[5].numpy()
    power = np.abs(np.fft.rfft(fastest, axis=0)) ** 2
    peak = np.fft.rfftfreq(len(fastest), 1.0 / rate_hz)[power.argmax(axis=0)]
    np.testing.assert_allclose(peak, highest_hz, atol=0.1)


@pytest.mark.parametrize(("time_constant_s", "most_apart"), [(100.0, False), (200.0, True)])
def test_states_of_which_a_tenth_is_left_are_apart(time_constant_s, most_apart):
    """After 300 s exp(-3) = 0.05 and exp(-1.5) = 0.22 are left; the rates hardly count."""
    pole = math.exp(-1.0 / (RATE_HZ * time_constant_s))
    statement = stability_statement(linear_network(pole, 0.0, 1e-6, coupled=True), n_levels=2)
    assert (statement.coupled_rates_apart > 50) == most_apart
