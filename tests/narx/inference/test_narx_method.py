"""The network as a method: start-up and network together, gaps, streams, scales, rates."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from narx.errors import MethodNotApplicableError, UserError
from narx.inference.narx_method import NarxMethod, quality_of
from narx.inference.start_up import StartUp
from narx.inference.stream import OrientationStream, Quality
from narx.method import SegmentSignals, longest_gap_s
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights, random_weights

START_UP = StartUp(duration_s=4.0, averaging_s=3.0)


def network(rate_hz=100.0, coupled=True, odd=True, leak_rad_s=0.15, rate_rms_rad_s=1.0, seed=None):
    """A leaky integrator, or with a seed a nonlinear network as training may produce."""
    model = Narx(
        rate_hz, Normalisation(2.0, 0.25, rate_rms_rad_s=rate_rms_rad_s), odd=odd, coupled=coupled
    )
    weights = leaky_integrator_weights(model, leak_rad_s)
    if seed is not None:
        weights = random_weights(model, np.random.default_rng(seed), slope=0.2)
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(weights))
    return model


def by_stream(method, signals):
    stream = OrientationStream(method, signals.sampling_rate_hz)
    return np.array([stream.update(rates).angles_rad for rates in signals.axis_rates_rad_s])


def unknown(motion):
    return replace(motion.signals, initial_angles_rad=None)


@pytest.mark.parametrize("start_up", [START_UP, StartUp(duration_s=0.0)])
@pytest.mark.parametrize("coupled", [True, False])
@pytest.mark.parametrize("odd", [True, False])
def test_stream_equals_batch(motion, start_up, coupled, odd):
    signals = unknown(motion("stand_walk_stand", duration_s=20.0))
    rates = signals.axis_rates_rad_s.copy()
    rates[[0, 300, 301, 1200]] = np.nan  # before, amid and after the start-up
    signals = replace(signals, axis_rates_rad_s=rates)
    method = NarxMethod(network(coupled=coupled, odd=odd, seed=1), start_up, washout_s=5.0)
    angles = method.estimate(signals)
    np.testing.assert_array_equal(by_stream(method, signals), angles)
    assert np.rad2deg(np.nanmax(np.abs(angles))) > 10.0


def test_streams_do_not_share_their_state(motion):
    signals = unknown(motion("walking", duration_s=8.0))
    method = NarxMethod(network(), START_UP)
    first, second = OrientationStream(method, 100.0), OrientationStream(method, 100.0)
    one = first.update_block(signals.axis_rates_rad_s).angles_rad
    other = second.update(signals.axis_rates_rad_s[0]).angles_rad
    np.testing.assert_array_equal(other, np.zeros(3))
    assert np.abs(one[-1]).max() > 0.01


def test_a_long_gap_is_as_if_time_had_stood_still(motion):
    signals = motion("walking", duration_s=20.0).signals
    rates = signals.axis_rates_rad_s.copy()
    there = np.ones(len(rates), dtype=bool)
    there[[0, 1, *range(500, 505), *range(1500, 1600)]] = False
    rates[~there] = np.nan
    std_rad = np.array([0.1, 0.2, 0.3])
    method = NarxMethod(network(), START_UP, error_std_rad=std_rad, washout_s=5.0)
    gappy = replace(signals, axis_rates_rad_s=rates)
    angles = method.estimate(gappy)
    assert np.isnan(angles[~there]).all()
    np.testing.assert_array_equal(angles[there], method.estimate(signals.select(there)))
    std = method.run(gappy).std_rad
    assert np.isnan(std[~there]).all()
    np.testing.assert_array_equal(std[there], np.tile([0.1, 0.2, 0.3], (there.sum(), 1)))
    # one axis missing is a sample missing
    rates[700, 2] = np.nan
    assert np.isnan(method.estimate(replace(signals, axis_rates_rad_s=rates))[700]).all()


def test_a_short_gap_is_bridged_by_a_straight_line(motion):
    signals = motion("walking", duration_s=20.0).signals
    lost, straight = signals.axis_rates_rad_s.copy(), signals.axis_rates_rad_s.copy()
    missing = np.zeros(len(lost), dtype=bool)
    for begin, end in ((7, 8), (500, 504), (1500, 1502)):
        missing[begin:end] = True
        for k in range(begin, end):
            share = (k - begin + 1) / (end - begin + 1)
            straight[k] = (1 - share) * straight[begin - 1] + share * signals.axis_rates_rad_s[end]
    lost[missing] = np.nan
    method = NarxMethod(network(), START_UP, washout_s=5.0)
    angles = method.estimate(replace(signals, axis_rates_rad_s=lost))
    assert np.isnan(angles[missing]).all()
    expected = method.estimate(replace(signals, axis_rates_rad_s=straight))
    np.testing.assert_allclose(angles[~missing], expected[~missing], rtol=0, atol=1e-12)


def test_lost_samples_cost_little(motion):
    signals = motion("walking", duration_s=60.0).signals
    rates = signals.axis_rates_rad_s.copy()
    rates[np.random.default_rng(0).random(len(rates)) < 0.02] = np.nan
    method = NarxMethod(network(), START_UP)
    lost = method.estimate(replace(signals, axis_rates_rad_s=rates))
    error = np.rad2deg(lost - method.estimate(signals))[1500:]
    # without bridging, the pauses would cost 0.8 to 1 degrees
    assert np.nanstd(error, axis=0).max() < 0.1


def test_a_rate_that_no_leg_has_is_a_missing_sample(motion):
    signals = motion("walking", duration_s=10.0).signals
    saturated, lost = signals.axis_rates_rad_s.copy(), signals.axis_rates_rad_s.copy()
    saturated[400, 1], lost[400, 1] = 34.9, np.nan
    method = NarxMethod(network(), START_UP)
    np.testing.assert_array_equal(
        method.estimate(replace(signals, axis_rates_rad_s=saturated)),
        method.estimate(replace(signals, axis_rates_rad_s=lost)),
    )


def sagittal_swing(duration_s, start=None):
    """A leg that swings by 20 degrees to either side of where it starts."""
    time = np.arange(round(100 * duration_s)) / 100.0
    rates = np.zeros((len(time), 3))
    rates[:, 0] = 2.0 * np.cos(2 * np.pi * 0.9 * time)
    return SegmentSignals("shank", 100.0, rates, np.zeros_like(rates), start)


def test_a_known_start_keeps_the_mean_angle_and_an_unknown_one_swings_about_zero():
    bent = np.deg2rad([20.0, 0.0, 0.0])
    method = NarxMethod(network(), START_UP)
    known, unknown_start = (
        np.rad2deg(method.estimate(sagittal_swing(40.0, start))) for start in (bent, None)
    )
    strides = slice(-2000, None)  # 18 strides
    np.testing.assert_allclose(known[strides].mean(axis=0), [20.0, 0.0, 0.0], atol=0.3)
    np.testing.assert_allclose(unknown_start[strides].mean(axis=0), 0.0, atol=0.3)
    np.testing.assert_allclose(np.ptp(known[strides, 0]), 40.5, atol=0.5)


@pytest.mark.parametrize("known", [True, False])
def test_nothing_jumps_where_the_network_takes_over(motion, known):
    walk = motion("walking", duration_s=12.0)
    signals = walk.signals if known else unknown(walk)
    angles = NarxMethod(network(), START_UP, washout_s=5.0).estimate(signals)
    taken = len(
        START_UP.run(signals.axis_rates_rad_s, 0.01, START_UP.begin(signals.initial_angles_rad))
    )
    assert 400 <= taken < 600
    jump = np.diff(angles - walk.angles_rad, axis=0)[taken - 2 : taken + 3]
    assert np.rad2deg(np.abs(jump)).max() < 0.1


def test_without_start_up_only_the_network_runs(motion):
    signals = motion("walking", duration_s=5.0).signals
    model = network(seed=2)
    for start in (None, np.array([0.3, 0.1, 0.0])):
        method = NarxMethod(model, StartUp(duration_s=0.0), washout_s=None)
        angles = method.estimate(replace(signals, initial_angles_rad=start))
        with torch.no_grad():
            alone, _ = model(torch.from_numpy(signals.axis_rates_rad_s))
        np.testing.assert_allclose(angles, alone.numpy(), rtol=0, atol=1e-14)


def test_only_coupled_axes_are_right_after_a_turn(motion):
    turn = motion("half_turn", duration_s=40.0)
    after = turn.time_s > 30.0
    error_deg = {
        coupled: np.rad2deg(
            np.abs(
                NarxMethod(network(coupled=coupled), START_UP).estimate(turn.signals)
                - turn.angles_rad
            )[after][:, :2].max()
        )
        for coupled in (True, False)
    }
    assert error_deg[True] < 3.0
    assert error_deg[False] > 10.0


def test_without_tilt_coupling_changes_nothing():
    signals = sagittal_swing(15.0, np.zeros(3))  # rotation about one axis does not tilt the others
    coupled, alone = (
        NarxMethod(network(coupled=c, seed=3), START_UP).estimate(signals) for c in (True, False)
    )
    np.testing.assert_allclose(coupled, alone, atol=1e-9)
    assert not coupled[:, 1:].any()


def test_own_scaling_equals_training_scaling_only_for_a_linear_network(motion):
    signals = motion("walking", duration_s=15.0).signals

    def angles(scaling, **options):
        return NarxMethod(network(**options), START_UP, scaling).estimate(signals)

    # a linear leaky integrator is invariant to scaling, a saturating tanh is not
    np.testing.assert_allclose(angles("own"), angles("training"), atol=np.deg2rad(0.1))
    assert np.abs(angles("own", seed=1) - angles("training", seed=1)).max() > np.deg2rad(0.5)


def test_own_scaling_runs_every_axis_at_the_amplitude_of_training():
    """Scaling the rates by a tenth scales the angles by exactly a tenth."""
    rates = np.random.default_rng(0).normal(size=(800, 1)) * np.array([1.0, 0.1, 0.1])
    rms = float(np.sqrt(np.mean(rates[:, 0] ** 2)))
    model = network(coupled=False, seed=1, rate_rms_rad_s=rms)
    signals = SegmentSignals("shank", 100.0, rates, np.zeros_like(rates))
    own, training = (
        NarxMethod(model, StartUp(duration_s=1.0, averaging_s=0.5), scaling).estimate(signals)
        for scaling in ("own", "training")
    )
    np.testing.assert_allclose(own[:, 1:], 0.1 * own[:, :1] * np.ones(2), atol=1e-12)
    np.testing.assert_allclose(own[:, 0], training[:, 0], atol=1e-12)
    assert np.abs(own[:, 1] - training[:, 1]).max() > 1e-4


@pytest.mark.parametrize("rate_hz", [50.0, 94.3, 200.0, 500.0])
def test_a_recording_at_another_rate_gives_the_angles_of_the_native_one(motion, rate_hz):
    model = network(seed=1)
    native = motion("walking", 100.0, 20.0)
    other = motion("walking", rate_hz, 20.0)
    expected = NarxMethod(model, START_UP).estimate(native.signals)
    angles = NarxMethod(model, START_UP).estimate(other.signals)
    at_native = np.stack(
        [np.interp(native.time_s, other.time_s, column) for column in angles.T], axis=1
    )
    # 50 Hz undersamples the movement, and linear interpolation shows the error
    tolerance_deg = 0.3 if rate_hz < 100 else 0.05
    inside = native.time_s < other.time_s[-1]
    assert np.rad2deg(np.abs(at_native - expected)[inside]).max() < tolerance_deg


def test_a_recording_at_another_rate_keeps_its_gaps(motion):
    signals = motion("walking", 200.0, 10.0).signals
    rates = signals.axis_rates_rad_s.copy()
    rates[900:920] = np.nan
    angles = NarxMethod(network(), START_UP).estimate(replace(signals, axis_rates_rad_s=rates))
    assert np.isnan(angles[900:920]).all()
    assert np.isfinite(np.delete(angles, slice(900, 920), axis=0)).all()


def test_refusals():
    with pytest.raises(UserError, match="axis_scaling is 'mine', expected one of training, own"):
        NarxMethod(network(), axis_scaling="mine")
    with pytest.raises(UserError, match=r"washout_s is 0\.0, expected seconds above zero"):
        NarxMethod(network(), washout_s=0.0)
    with pytest.raises(MethodNotApplicableError, match="at 100 Hz, not at 50 Hz"):
        NarxMethod(network()).recursion(50.0, 1, None)
    with pytest.raises(MethodNotApplicableError, match="axis_scaling=own needs the whole record"):
        NarxMethod(network(), axis_scaling="own").recursion(100.0, 1, None)


@pytest.mark.parametrize("rate_hz", [100.0, 250.0])
@pytest.mark.parametrize("known", [True, False])
def test_the_start_up_has_a_standard_deviation_of_its_own(motion, rate_hz, known):
    walk = motion("walking", rate_hz, 12.0)
    signals = walk.signals if known else unknown(walk)
    rates = signals.axis_rates_rad_s.copy()
    rates[[50, -1]] = np.nan
    signals = replace(signals, axis_rates_rad_s=rates)
    method = NarxMethod(
        network(),
        START_UP,
        error_std_rad=np.array([0.1, 0.2, np.nan]),
        start_std_rad=np.array([0.4, np.nan, np.nan]),
    )
    starting = method.run(signals).starting
    assert 4.0 <= starting.sum() / rate_hz < 6.0
    # contiguous from the first sample on, except for the missing sample
    assert np.flatnonzero(~starting).tolist() == [50, *range(starting.sum() + 1, len(starting))]
    std = method.run(signals).std_rad
    there = np.isfinite(rates).all(axis=1)
    np.testing.assert_array_equal(std[starting, 0], 0.4)
    np.testing.assert_array_equal(std[there & ~starting, 0], 0.1)
    np.testing.assert_array_equal(std[there, 1], 0.2)
    assert np.isnan(std[:, 2]).all()
    assert np.isnan(std[~there]).all()
    # it ends where the network starts, from which sample on the washout has an effect
    one, other = (
        NarxMethod(network(), START_UP, washout_s=w).estimate(signals) for w in (None, 5.0)
    )
    parts = np.flatnonzero(np.abs(one - other).max(axis=1) > 1e-12)[0]
    assert abs(parts - np.flatnonzero(starting)[-1]) <= np.ceil(rate_hz / 100.0) + 1


def test_the_start_up_ends_with_the_sample_that_it_hands_over(motion):
    signals = motion("walking", duration_s=12.0).signals
    state = START_UP.begin(signals.initial_angles_rad)
    taken = len(START_UP.run(signals.axis_rates_rad_s, signals.interval_s, state))
    starting = NarxMethod(network(), START_UP).run(signals).starting
    assert np.flatnonzero(starting).tolist() == list(range(taken))


@pytest.mark.parametrize("interval_s", [0.01, 0.010001, 0.004, 1 / 94.3])
def test_the_longest_gap_that_is_bridged_is_no_pause(interval_s):
    """Also at a rate that is off by a ten-thousandth, as stamps may have it."""
    longest = round(longest_gap_s(interval_s) / interval_s)
    for samples in range(1, 2 * longest):
        there = np.ones(3 * longest, dtype=bool)
        there[1:samples] = False
        quality = quality_of(there, np.zeros_like(there), interval_s)
        paused = samples * interval_s > longest_gap_s(interval_s) + 1e-5
        assert quality[samples] == (Quality.AFTER_PAUSE if paused else Quality.GOOD)


def test_no_error_known_no_standard_deviation(motion):
    assert NarxMethod(network()).run(motion("still").signals).std_rad is None
