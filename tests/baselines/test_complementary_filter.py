import numpy as np
import pytest
from scipy import signal

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.errors import UserError
from narx.inference.stream import OrientationStream
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2


def signals_of(rate, tilt, rate_hz, initial=None):
    """Sagittal rate, and the accelerometer of a sagittal tilt."""
    rates = np.zeros((len(rate), 3))
    rates[:, 0] = rate
    force = GRAVITY_M_S2 * np.column_stack([np.sin(tilt), np.zeros_like(tilt), np.cos(tilt)])
    return SegmentSignals("thigh_right", rate_hz, rates, force, initial)


def steady_state(output, time_s, frequency_hz):
    """Complex amplitude of a sinusoid, over whole periods at the end."""
    periods = np.floor(frequency_hz * 0.5 * time_s[-1])
    keep = time_s > time_s[-1] - periods / frequency_hz + 1e-9
    carrier = np.exp(-2j * np.pi * frequency_hz * time_s[keep])
    return 2.0 * np.mean(output[keep] * carrier)


@pytest.mark.parametrize("frequency_hz", [0.02, 0.1, 1.0])
def test_both_branches_follow_their_transfer_functions(frequency_hz):
    crossover_hz, rate_hz = 0.1, 1000.0
    t = np.arange(int(200 * rate_hz)) / rate_hz
    sine = 0.3 * np.cos(2 * np.pi * frequency_hz * t)
    wc = 2 * np.pi * crossover_hz
    method = ComplementaryFilter(crossover_hz)
    for rate, tilt, numerator in [(sine, 0 * t, [1.0]), (0 * t, sine, [wc])]:
        _, expected = signal.freqresp((numerator, [1.0, wc]), [2 * np.pi * frequency_hz])
        angle = method.estimate(signals_of(rate, tilt, rate_hz))[:, 0]
        measured = steady_state(angle, t, frequency_hz) / 0.3
        # backward Euler: right to half a sample of phase and of the time constant
        half_sample = 0.5 * (wc + 2 * np.pi * frequency_hz) / rate_hz
        assert abs(measured - expected[0]) < 1.1 * half_sample * abs(expected[0])


def test_rectangle_rule_is_the_printed_recursion():
    rng = np.random.default_rng(1)
    rate, tilt = rng.normal(0, 1, 500), rng.normal(0, 0.3, 500)
    alpha, interval_s = 0.97, 0.01
    angle = 0.0
    printed = [0.0]
    for k in range(1, 500):
        angle = alpha * (angle + rate[k] * interval_s) + (1 - alpha) * tilt[k]
        printed.append(angle)
    method = ComplementaryFilter.from_alpha(alpha, 100.0)
    np.testing.assert_allclose(
        method.estimate(signals_of(rate, tilt, 100.0))[:, 0], printed, atol=1e-12
    )


@pytest.mark.parametrize("alpha", [0.5, 0.999, 0.9999])
def test_alpha_and_crossover_are_two_names_for_one_thing(alpha):
    method = ComplementaryFilter.from_alpha(alpha, 100.0)
    assert method.alpha(100.0) == pytest.approx(alpha, rel=1e-12)
    wc = 2 * np.pi * method.crossover_hz
    assert alpha == pytest.approx(1 / (1 + wc * 0.01), rel=1e-12)
    # at another rate the crossover stays, alpha does not
    assert method.alpha(500.0) > alpha


def test_the_papers_offline_alpha_gives_a_crossover_of_1_6_mhz():
    assert ComplementaryFilter.from_alpha(0.9999, 100.0).crossover_hz == pytest.approx(
        0.0016, rel=0.01
    )


def test_a_constant_bias_becomes_an_angle_of_bias_over_wc():
    bias = np.deg2rad(0.5)
    t = np.arange(20000) / 100.0
    method = ComplementaryFilter(crossover_hz=0.05)
    angle = method.estimate(signals_of(bias + 0 * t, 0 * t, 100.0))[-1, 0]
    assert angle == pytest.approx(bias / (2 * np.pi * 0.05), rel=1e-6)


def test_a_wrap_of_the_accelerometer_angle_makes_no_jump():
    t = np.arange(4000) / 100.0
    # turns over backwards and rocks about 180 degrees, where atan2 jumps
    true = np.minimum(t / 10.0, 1.0) * np.pi + 0.05 * np.sin(2 * np.pi * t) * (t > 12)
    rate = np.gradient(true, 0.01)
    angle = ComplementaryFilter(0.05).estimate(signals_of(rate, true, 100.0))[:, 0]
    assert np.abs(angle - true).max() < 0.01


def test_the_other_axes_are_missing(motion):
    walk = motion("walking", duration_s=5.0)
    both = ComplementaryFilter().estimate(walk.signals)
    assert np.isnan(both[:, 2]).all()
    assert np.isfinite(both[:, :2]).all()
    one = ComplementaryFilter(axes=["sagittal"]).estimate(walk.signals)
    assert np.isnan(one[:, 1:]).all()
    np.testing.assert_array_equal(one[:, 0], both[:, 0])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"crossover_hz": 0.0}, "crossover_hz is 0.0, expected a positive number"),
        ({"crossover_hz": np.nan}, "crossover_hz is nan, expected a positive number"),
        ({"axes": ["transverse"]}, "expected sagittal, frontal or both"),
        ({"axes": []}, "expected sagittal, frontal or both"),
        ({"rule": "euler"}, "rule is 'euler'"),
    ],
)
def test_wrong_parameters_are_one_clear_line(parameters, message):
    with pytest.raises(UserError, match=message):
        ComplementaryFilter(**parameters)


@pytest.mark.parametrize("alpha", [0.0, 1.0, -3.0])
def test_alpha_lies_between_zero_and_one(alpha):
    with pytest.raises(UserError, match="expected 0 < alpha < 1"):
        ComplementaryFilter.from_alpha(alpha, 100.0)


@pytest.mark.parametrize("coupled", [True, False])
def test_sample_by_sample_it_is_the_same(coupled):
    rng = np.random.default_rng(2)
    rates, force = rng.normal(size=(2, 200, 3))
    method = ComplementaryFilter(1.0, coupled=coupled)
    angles = method.estimate(SegmentSignals("thigh_right", 100.0, rates, force))
    stream = OrientationStream(method, 100.0)
    one_by_one = stream.update_block(np.hstack([rates, force])).angles_rad
    np.testing.assert_allclose(one_by_one, angles, atol=1e-12)
    assert (np.ptp(angles[:, :2], axis=0) > 0.2).all()
