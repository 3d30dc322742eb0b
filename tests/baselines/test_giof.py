from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, freqz

from narx.baselines.giof import Giof, _Biquad
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.stream import OrientationStream
from narx.kinematics.segment_angles import coupled_rates
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2


def printed_pseudocode(rate, force, interval_s, eta, gamma_3):
    """Abhayasinghe et al., Fig. 6, with the absolute value in (2)."""
    angle, out = 0.0, []
    for k in range(len(rate)):
        norm_squared = float(force[k] @ force[k])
        low, high = (GRAVITY_M_S2 - eta) ** 2, (GRAVITY_M_S2 + eta) ** 2
        if low < norm_squared < high and abs(rate[k]) < gamma_3:
            angle = np.arctan2(force[k, 0], force[k, 2])
        elif k > 0:
            angle = angle + 0.5 * interval_s * (rate[k] + rate[k - 1])
        out.append(angle)
    return np.array(out)


def test_one_axis_without_low_pass_is_the_printed_pseudocode():
    rng = np.random.default_rng(3)
    rates = rng.normal(0, 0.2, (2000, 3))
    force = np.array([1.0, 0.0, GRAVITY_M_S2]) + rng.normal(0, 0.3, (2000, 3))
    method = Giof("real_time", ["sagittal"], eta_m_s2=0.15, rest_s=0.0, low_pass_hz=None)
    angles = method.estimate(SegmentSignals("thigh_right", 100.0, rates, force))
    expected = printed_pseudocode(rates[:, 0], force, 0.01, 0.15, np.deg2rad(5.0))
    np.testing.assert_allclose(angles[:, 0], expected, atol=1e-12)
    assert np.isnan(angles[:, 1:]).all()


def test_a_fast_backward_swing_is_not_rest():
    """As printed, (2) would take any negative rate for rest."""
    rates = np.zeros((50, 3))
    rates[:, 0] = -2.0
    # gravity alone, but tilted: as printed the angle would stay at the accelerometer's
    force = np.tile(GRAVITY_M_S2 * np.array([np.sin(0.5), 0, np.cos(0.5)]), (50, 1))
    method = Giof("real_time", low_pass_hz=None)
    angles = method.estimate(SegmentSignals("thigh_right", 100.0, rates, force))
    assert angles[-1, 0] == pytest.approx(-2.0 * 0.49, abs=1e-12)


@pytest.mark.parametrize(("deviation", "believed"), [(0.19, True), (0.21, False)])
@pytest.mark.parametrize("sign", [1, -1])
def test_eta_is_the_deviation_of_the_norm(deviation, believed, sign):
    norm = GRAVITY_M_S2 + sign * deviation
    force = np.tile(norm * np.array([np.sin(0.5), 0, np.cos(0.5)]), (5, 1))
    signals = SegmentSignals("thigh_right", 100.0, np.zeros((5, 3)), force)
    angle = Giof("real_time", low_pass_hz=None, eta_m_s2=0.2, rest_s=0.0).estimate(signals)[-1, 0]
    assert angle == pytest.approx(0.5 if believed else 0.0, abs=1e-12)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 500.0])
def test_rest_must_last(rate_hz):
    n = round(1.0 * rate_hz)
    force = np.tile(GRAVITY_M_S2 * np.array([np.sin(0.5), 0, np.cos(0.5)]), (n, 1))
    rates = np.zeros((n, 3))
    rates[: round(0.3 * rate_hz)] = 0.2
    signals = SegmentSignals("thigh_right", rate_hz, rates, force)
    angle = Giof("real_time", low_pass_hz=None, rest_s=0.2).estimate(signals)[:, 0]
    believed = np.flatnonzero(np.isclose(angle, 0.5))
    assert believed[0] / rate_hz == pytest.approx(0.5, abs=1e-9)


def test_both_axes_must_rest():
    rates = np.zeros((5, 3))
    rates[:, 1] = 1.0
    force = np.tile(GRAVITY_M_S2 * np.array([np.sin(0.5), 0, np.cos(0.5)]), (5, 1))
    signals = SegmentSignals("thigh_right", 100.0, rates, force)
    one = Giof("real_time", ["sagittal"], rest_s=0.0, low_pass_hz=None).estimate(signals)[-1, 0]
    both = Giof("real_time", rest_s=0.0, low_pass_hz=None).estimate(signals)[-1, 0]
    assert one == pytest.approx(0.5)
    assert both == 0.0


def test_offline_removes_a_gyroscope_offset(motion):
    walk = motion("walking", duration_s=30.0)
    biased = replace(
        walk.signals, axis_rates_rad_s=walk.signals.axis_rates_rad_s + np.deg2rad([2.0, -1.0, 0])
    )
    with_bias = Giof().estimate(biased)
    without = Giof().estimate(walk.signals)
    assert np.rad2deg(np.nanmax(np.abs(with_bias - without))) < 0.5


def test_a_window_that_is_no_whole_number_of_strides_stretches_the_angle(motion):
    """1.5 s of 0.9 strides a second: the average keeps -21 % of the swing and adds it."""
    walk = motion("walking", duration_s=40.0)
    middle = (walk.time_s > 10) & (walk.time_s < 30)

    def gain(window_s):
        angle = Giof(offset_window_s=window_s, axes=["sagittal"]).estimate(walk.signals)[middle, 0]
        carrier = np.exp(-2j * np.pi * 0.9 * walk.time_s[middle])
        return np.abs((angle * carrier).mean() / (walk.angles_rad[middle, 0] * carrier).mean())

    noise_window = np.sinc(0.9 * 0.1)
    # updates from the accelerometer pull a little back
    assert gain(1.5) == pytest.approx(noise_window - np.sinc(0.9 * 1.5), abs=0.03)
    assert gain(None) == pytest.approx(1.0, abs=0.02)


def test_the_average_covers_two_strides(motion):
    """With two strides even a change of every second stride averages to nothing."""
    walk = motion("walking", duration_s=40.0)
    alternating = 0.3 * np.sin(np.pi * 0.9 * walk.time_s)  # rad/s, half the stride frequency
    rates = walk.signals.axis_rates_rad_s + alternating[:, None]
    limping = replace(walk.signals, axis_rates_rad_s=rates)
    free, two = (
        Giof(offset_window_s=w, axes=["sagittal"], eta_m_s2=1e-9).estimate(limping)[1500:2500, 0]
        for w in (None, 2.0 / 0.9)
    )
    assert np.rad2deg(np.abs(free - free.mean() - two + two.mean()).max()) < 0.5


def test_without_strides_the_window_is_that_of_the_papers():
    rates = np.tile(np.linspace(0.0, 1.0, 1000)[:, None], 3)
    signals = SegmentSignals("thigh_right", 100.0, rates, np.zeros((1000, 3)))
    np.testing.assert_array_equal(
        Giof(offset_window_s=None).estimate(signals), Giof(offset_window_s=1.5).estimate(signals)
    )


def test_sample_by_sample_the_low_pass_begins_in_its_steady_state():
    rates = np.tile(np.deg2rad([20.0, -10.0, 3.0]), (50, 1))
    signals = SegmentSignals("thigh_right", 100.0, rates, np.tile([0, 0, 1.0], (50, 1)))
    angles = Giof("real_time").estimate(signals)
    # a constant rate passes a low pass unchanged from the first sample on
    np.testing.assert_allclose(angles[-1, :2], rates[0, :2] * 0.49, atol=1e-12)
    one_by_one = _Biquad(*butter(2, 10.0, fs=100.0))
    np.testing.assert_allclose([one_by_one(0.3) for _ in range(50)], 0.3, atol=1e-12)


def test_real_time_subtracts_the_static_offset():
    rates = np.tile(np.deg2rad([20.0, -10.0, 3.0]), (200, 1))
    force = np.zeros((200, 3))
    method = Giof("real_time", static_offset_deg_s=[20.0, -10.0, 3.0])
    angles = method.estimate(SegmentSignals("thigh_right", 100.0, rates, force))
    np.testing.assert_allclose(angles[:, :2], 0.0, atol=1e-12)


def test_starts_from_known_angles():
    rates = np.full((10, 3), 1.0)
    signals = SegmentSignals(
        "thigh_right", 100.0, rates, np.zeros((10, 3)), np.array([0.3, -0.1, 0.0])
    )
    angles = Giof("real_time").estimate(signals)
    np.testing.assert_allclose(angles[:, 0], 0.3 + np.arange(10) * 0.01, atol=1e-12)


@pytest.mark.parametrize("rate_hz", [18.0, 20.0])
def test_a_cut_off_from_half_the_sampling_rate_on_is_refused(rate_hz):
    signals = SegmentSignals("thigh_right", rate_hz, np.zeros((10, 3)), np.zeros((10, 3)))
    message = f"less than half the sampling rate of {rate_hz:g} Hz"
    with pytest.raises(MethodNotApplicableError, match=message):
        Giof("real_time").estimate(signals)


def test_offline_does_not_stream():
    with pytest.raises(MethodNotApplicableError, match="mode=offline needs the whole recording"):
        Giof().recursion(100.0, 1, None)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"mode": "online"}, "mode is 'online', expected one of offline, real_time"),
        ({"eta_m_s2": 0.0}, "eta_m_s2 is 0.0"),
        ({"rate_threshold_deg_s": -5.0}, "rate_threshold_deg_s is -5.0"),
        ({"rest_s": -0.1}, "rest_s is -0.1, expected 0 or more"),
        ({"offset_window_s": 0.0}, "offset_window_s is 0.0"),
        ({"static_offset_deg_s": [1.0]}, "has 1 values, expected three"),
        ({"axes": ["yaw"]}, "expected sagittal, frontal or both"),
    ],
)
def test_wrong_parameters_are_one_clear_line(parameters, message):
    with pytest.raises(UserError, match=message):
        Giof(**parameters)


@pytest.mark.parametrize("low_pass_hz", [None, 10.0])
def test_sample_by_sample_it_is_the_same(low_pass_hz):
    """Rest of ten samples, broken by a fast backward swing, a fast forward one, and a push."""
    n = 400
    force = np.tile(GRAVITY_M_S2 * np.array([np.sin(0.5), 0.1, np.cos(0.5)]), (n, 1))
    force *= GRAVITY_M_S2 / np.linalg.norm(force[0])
    rates = np.zeros((n, 3))
    rates[50:70, 0], rates[120:140, 1], force[200:220, 2] = -1.0, 1.0, 3.0
    rates[231, 0] = 1.0  # after eleven samples of rest
    method = Giof("real_time", low_pass_hz=low_pass_hz, static_offset_deg_s=[0.5, -0.3, 0.0])
    angles = method.estimate(SegmentSignals("thigh_right", 100.0, rates, force))
    stream = OrientationStream(method, 100.0)
    one_by_one = stream.update_block(np.hstack([rates, force])).angles_rad
    np.testing.assert_allclose(one_by_one, angles, atol=1e-12)
    assert (np.ptp(angles[:, :2], axis=0) > 0.1).all()


@pytest.mark.parametrize("frequency_hz", [3.0, 10.0, 30.0])
def test_the_low_pass_is_a_second_order_butterworth(frequency_hz):
    """Gain of the analog filter, at frequencies that the bilinear transform bends."""
    low_pass = Giof("real_time", low_pass_hz=10.0)._butterworth(200.0)
    _, gain = freqz(*low_pass, [frequency_hz], fs=200.0)
    bent = np.tan(np.pi * frequency_hz / 200.0) / np.tan(np.pi * 10.0 / 200.0)
    assert np.abs(gain) == pytest.approx(1.0 / np.sqrt(1.0 + bent**4))


def test_offline_noise_of_ten_hertz_averages_to_nothing():
    """The window is 0.1 s; integrated, the noise would have an amplitude of 1 / (2 pi 10) rad."""
    time_s = np.arange(3000) / 1000.0
    rates = np.tile(np.cos(2.0 * np.pi * 10.0 * time_s)[:, None], 3)
    signals = SegmentSignals("thigh_right", 1000.0, rates, np.zeros((3000, 3)))
    angles = Giof(offset_window_s=1.5).estimate(signals)[1000:2000, :2]
    assert np.ptp(angles, axis=0).max() < 1e-4


def test_offline_the_tilt_of_a_first_pass_couples_the_axes_once(motion):
    known = np.array([0.3, -0.2, 0.0])
    turn = motion("half_turn", 100.0, 30.0).changed(initial_angles_rad=known).signals
    alone = Giof(offset_window_s=1.5)
    tilt = alone.estimate(turn)[:, :2]
    rates = turn.axis_rates_rad_s
    coupled = replace(turn, axis_rates_rad_s=coupled_rates(rates, np.c_[tilt, 0.0 * tilt[:, :1]]))
    found = Giof(offset_window_s=1.5, coupled=True).estimate(turn)[:, :2]
    np.testing.assert_allclose(found, alone.estimate(coupled)[:, :2], atol=1e-12)
    assert np.abs(found - tilt).max() > 0.02


def test_strides_are_those_of_the_sagittal_rate():
    time_s = np.arange(4000) / 100.0
    rates = np.sin(2.0 * np.pi * time_s[:, None] * [0.9, 1.4, 1.4])
    signals = SegmentSignals("thigh_right", 100.0, rates, np.zeros((4000, 3)))
    found, given = (Giof(offset_window_s=w).estimate(signals) for w in (None, 2.0 / 0.9))
    np.testing.assert_allclose(found[:, :2], given[:, :2], atol=2e-3)


def test_it_is_causal_in_real_time_and_in_one_direction():
    assert Giof("real_time").causal
    assert not Giof("real_time", smoothing=True).causal
    assert not Giof("offline").causal
