from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from narx.baselines.pseudo_integrator import PseudoIntegrator
from narx.errors import MethodNotApplicableError, UserError
from narx.method import SegmentSignals

STRIDE_HZ = 0.9


def signals_of(rate, rate_hz):
    rates = np.zeros((len(rate), 3))
    rates[:, 0] = rate
    return SegmentSignals("thigh_right", rate_hz, rates, np.zeros((len(rate), 3)))


@pytest.mark.parametrize("ratio", [1 / (2 * np.pi), 1.0])
@pytest.mark.parametrize("frequency_hz", [0.1, 0.9, 3.0])
def test_it_follows_its_transfer_function(ratio, frequency_hz):
    rate_hz = 200.0
    t = np.arange(int(120 * rate_hz)) / rate_hz
    sine = np.cos(2 * np.pi * frequency_hz * t)
    method = PseudoIntegrator(breakpoint_ratio=ratio, gait_frequency_hz=STRIDE_HZ)
    angle = method.estimate(signals_of(sine, rate_hz))[:, 0]
    late = t >= 60.0
    measured = 2 * np.mean(angle[late] * np.exp(-2j * np.pi * frequency_hz * t[late]))
    tau = 1.0 / (2 * np.pi * STRIDE_HZ * ratio)
    system = ([tau**2, 0.0], [tau**2, 2 * tau, 1.0])
    _, expected = signal.freqresp(system, [2 * np.pi * frequency_hz])
    # the bilinear transform bends frequencies by (w Ts)^2 / 12
    assert abs(measured - expected[0]) < 2e-3 * abs(expected[0])


def test_it_is_scipys_bilinear_transform():
    rng = np.random.default_rng(2)
    rate = rng.normal(size=2000)
    tau = 1.0 / (2 * np.pi * STRIDE_HZ * 0.3)
    b, a = signal.bilinear([tau**2, 0.0], [tau**2, 2 * tau, 1.0], fs=100.0)
    method = PseudoIntegrator(breakpoint_ratio=0.3, gait_frequency_hz=STRIDE_HZ)
    np.testing.assert_allclose(
        method.estimate(signals_of(rate, 100.0))[:, 0], signal.lfilter(b, a, rate), atol=1e-10
    )


def phase_at_gait_frequency_deg(ratio):
    t = np.arange(12000) / 100.0
    rate = np.cos(2 * np.pi * STRIDE_HZ * t)
    angle = PseudoIntegrator(ratio).estimate(signals_of(rate, 100.0))[:, 0]
    late = t > t[-1] - 40 / STRIDE_HZ
    return np.rad2deg(np.angle(np.mean(angle[late] * np.exp(-2j * np.pi * STRIDE_HZ * t[late]))))


def test_with_the_breakpoint_at_the_gait_frequency_the_phase_is_lost(motion):
    assert phase_at_gait_frequency_deg(1.0) == pytest.approx(0.0, abs=1.0)
    walk = motion("walking", duration_s=60.0)
    late = walk.time_s > 20.0

    def correlation(ratio):
        estimate = PseudoIntegrator(ratio).estimate(walk.signals)[late, 0]
        return np.corrcoef(estimate, walk.angles_rad[late, 0])[0, 1]

    assert abs(correlation(1.0)) < 0.2
    assert correlation(1 / (2 * np.pi)) > 0.9


def test_at_the_default_ratio_the_phase_is_nearly_an_integrators():
    # atan(1 / (2 pi)) = 9 degrees for each of the two poles
    assert phase_at_gait_frequency_deg(1 / (2 * np.pi)) == pytest.approx(-90 + 2 * 9.04, abs=0.5)


def test_the_breakpoint_comes_from_the_cadence(motion):
    walk = motion("walking", duration_s=60.0)
    constant = PseudoIntegrator().breakpoint_rad_s(walk.signals)
    np.testing.assert_allclose(constant, STRIDE_HZ, rtol=0.01)
    following = PseudoIntegrator(
        frequency="following", frequency_without_gait_hz=1.5
    ).breakpoint_rad_s(walk.signals)
    assert following[0] == pytest.approx(1.5)
    np.testing.assert_allclose(following[walk.time_s > 15], STRIDE_HZ, rtol=0.02)


def test_the_cadence_is_that_of_the_sagittal_rate():
    time_s = np.arange(6000) / 100.0
    rates = np.sin(2 * np.pi * time_s[:, None] * [STRIDE_HZ, 1.4, 1.4])
    signals = SegmentSignals("thigh_right", 100.0, rates, np.zeros((6000, 3)))
    np.testing.assert_allclose(PseudoIntegrator().breakpoint_rad_s(signals), STRIDE_HZ, rtol=0.01)


def test_without_gait_the_breakpoint_is_the_one_given():
    method = PseudoIntegrator(1.0, frequency_without_gait_hz=1.5)
    still = method.breakpoint_rad_s(signals_of(np.zeros(500), 100.0))
    np.testing.assert_allclose(still, 2 * np.pi * 1.5)


def test_it_starts_from_zero_also_from_a_known_start():
    rate = np.random.default_rng(0).normal(size=500)
    method, unknown = PseudoIntegrator(gait_frequency_hz=STRIDE_HZ), signals_of(rate, 100.0)
    known = replace(unknown, initial_angles_rad=np.array([0.3, -0.2, 0.1]))
    np.testing.assert_array_equal(method.estimate(known), method.estimate(unknown))


def test_it_is_causal_unless_it_looks_for_one_frequency_or_goes_both_ways():
    assert not PseudoIntegrator().causal
    assert PseudoIntegrator(frequency="following").causal
    assert PseudoIntegrator(gait_frequency_hz=0.9).causal
    assert not PseudoIntegrator(gait_frequency_hz=0.9, smoothing=True).causal


def test_a_constant_bias_is_forgotten():
    angle = PseudoIntegrator().estimate(signals_of(np.full(6000, 0.01), 100.0))
    assert np.abs(angle[-1]).max() < 1e-8


def test_the_detected_constant_frequency_needs_the_whole_recording():
    with pytest.raises(MethodNotApplicableError, match="give gait_frequency_hz or set"):
        PseudoIntegrator().recursion(100.0, 1, None)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"breakpoint_ratio": -1.0}, "breakpoint_ratio is -1.0"),
        ({"gait_frequency_hz": 0.0}, "gait_frequency_hz is 0.0"),
        ({"frequency": "sometimes"}, "frequency is 'sometimes'"),
        ({"frequency_without_gait_hz": np.inf}, "frequency_without_gait_hz is inf"),
    ],
)
def test_wrong_parameters_are_one_clear_line(parameters, message):
    with pytest.raises(UserError, match=message):
        PseudoIntegrator(**parameters)
