"""Posture, bias and standard deviation of a tracked network, on walks with a known truth."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy import stats
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from narx.calibration.calibrate import calibrate
from narx.datasets import SimulatedGait
from narx.errors import MethodNotApplicableError, UserError
from narx.inference.checkpoint import Checkpoint, load, save
from narx.inference.pretrained import pretrained
from narx.inference.stream import Quality
from narx.inference.tracker import LinearRecursion, PostureTracker, leak_rad_s
from narx.inference.tracking import Tracking
from narx.kernels import tracker_layout as kernel
from narx.kinematics.segment_angles import (
    angles_from_orientation,
    axis_rates,
    orientation_from_angles,
)
from narx.method import SegmentSignals
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.training.initial_weights import leaky_integrator_weights

RATE_HZ = 50.0
# the model includes variation of the mean from swing to swing, so errors are in degrees
CLOSE_DEG = 2.0


def network(leak=0.05):
    model = Narx(RATE_HZ, Normalisation(3.0, 0.5, 0.0, 0.0))
    with torch.no_grad():
        model.weights.copy_(torch.from_numpy(leaky_integrator_weights(model, leak)))
    return model


def tracked(smoothing=False, **parameters):
    return Checkpoint(network(), tracker=PostureTracker(**parameters)).method(smoothing)


class Walk:
    """A person who walks indoors and turns now and then; angles in degrees."""

    def __init__(self, duration_s=90.0, turns=True):
        self.time_s = np.arange(0.0, duration_s, 1.0 / RATE_HZ)
        self.walks = np.ones_like(self.time_s)
        self.turn = 1.2 * (np.sin(0.25 * self.time_s) > 0.5) * turns  # rad/s
        self.posture_deg = np.zeros((len(self.time_s), 2))

    def ramp(self, at_s, duration_s):
        return np.clip((self.time_s - at_s) / duration_s, 0.0, 1.0)

    def signals(self, bias_deg_s=(0.0, 0.0, 0.0), known=False):
        phase = 2.0 * np.pi * 0.9 * self.time_s
        sway = 3.0 * self.turn
        degrees = np.column_stack(
            [
                self.posture_deg[:, 0]
                + 15.0 * self.walks * (np.sin(phase) + 0.3 * np.sin(2 * phase)),
                self.posture_deg[:, 1] + 4.0 * self.walks * np.sin(phase + 1.0) + sway,
                np.degrees(np.cumsum(self.turn) / RATE_HZ) + 3.0 * self.walks * np.sin(phase),
            ]
        )
        truth = np.radians(degrees)
        turned = Rotation.from_quat(orientation_from_angles(truth), scalar_first=True)
        rates = (turned[:-1].inv() * turned[1:]).as_rotvec() * RATE_HZ
        # mean of the rates over the intervals before and after the sample
        rates = 0.5 * (np.vstack([rates[:1], rates]) + np.vstack([rates, rates[-1:]]))
        force = turned.inv().apply(np.tile([0.0, 0.0, 9.81], (len(rates), 1)))
        start = truth[0] if known else None
        signals = SegmentSignals(
            "thigh", RATE_HZ, axis_rates(rates) + np.radians(bias_deg_s), force, start
        )
        return signals, angles_from_orientation(orientation_from_angles(truth))


def off_deg(method, walk, part, **kwargs):
    signals, truth = walk.signals(**kwargs)
    error = np.degrees(truth - method.estimate(signals))[:, :2]
    begin, end = (round(second * RATE_HZ) for second in part)
    return np.sqrt(np.mean(error[begin:end] ** 2, axis=0)).max()


def test_the_leak_is_that_of_the_leaky_integrator():
    assert leak_rad_s(network(0.15)) == pytest.approx(0.15)


def test_a_network_that_ignores_the_rate_is_refused():
    deaf = network(0.15)
    with torch.no_grad():
        deaf.weights[deaf.structure.w2] = 0.0
    with pytest.raises(UserError, match="the network's angle changes by 0 of a constant rate"):
        leak_rad_s(deaf)
    with pytest.raises(UserError, match="changes by 0 of"):
        leak_rad_s(LinearRecursion(100.0, (0.01, -0.01), (0.9,)))


def test_a_walk_is_followed_from_an_unknown_start():
    assert off_deg(tracked(), Walk(), (10, 90)) < CLOSE_DEG


def test_a_bias_that_was_left_in_is_found():
    bias = (0.8, -0.6, 0.0)
    with_tracker = off_deg(tracked(bias_sd_deg_s=2.0), Walk(), (45, 90), bias_deg_s=bias)
    assert with_tracker < CLOSE_DEG
    start_up_alone = Checkpoint(network(0.2)).method()
    assert off_deg(start_up_alone, Walk(), (45, 90), bias_deg_s=bias) > 1.5 * with_tracker


def test_a_posture_that_wanders_is_not_taken_for_a_bias_that_was_measured():
    walk = Walk(120.0, turns=False)
    walk.walks = walk.ramp(4.0, 1.0)
    wander = 3.0 * np.sin(2.0 * np.pi * walk.time_s / 40.0)
    walk.posture_deg[:] = (wander * walk.ramp(4.0, 1.0))[:, None]
    doubtful = off_deg(tracked(known_bias_sd_deg_s=0.5), walk, (10, 120), known=True)
    assert off_deg(tracked(), walk, (10, 120), known=True) < 0.9 * doubtful


def test_an_unmeasured_bias_is_doubtful_from_either_start():
    tracker = tracked().with_doubtful_bias().tracker
    for start in (None, np.zeros(3)):
        covariance = Tracking(tracker, network(), start).covariance
        np.testing.assert_allclose(
            np.degrees(np.sqrt(np.diag(covariance)[kernel.BIAS : kernel.LEAN])), 2.0
        )


def test_the_bias_is_taken_from_rest_at_once():
    walk = Walk(30.0)
    walk.walks = walk.ramp(10.0, 1.0)
    walk.turn[:] = 0.0
    method = tracked(known_bias_sd_deg_s=3.0)
    bias = (2.0, -1.5, 1.0)
    assert off_deg(method, walk, (5, 10), bias_deg_s=bias, known=True) < 2.5
    assert off_deg(method, walk, (20, 30), bias_deg_s=bias, known=True) < 2.5


def test_a_known_start_keeps_its_zero():
    walk = Walk(turns=False)
    walk.posture_deg[:] = 20.0, -5.0
    walk.posture_deg *= walk.ramp(4.0, 1.0)[:, None]
    walk.walks = walk.ramp(4.0, 1.0)
    assert off_deg(tracked(), walk, (10, 90), known=True) < CLOSE_DEG


@pytest.mark.parametrize("begin_s", [8.0, 20.0])
def test_a_heading_after_a_turn_is_not_drawn_back(begin_s):
    walk = Walk(45.0)
    walk.turn = np.pi / 2.0 * ((walk.time_s > begin_s) & (walk.time_s < begin_s + 2.0))
    signals, truth_rad = walk.signals(known=True)
    away = tracked().estimate(signals)[:, 2] - truth_rad[:, 2]
    off_deg = np.degrees(np.abs((away + np.pi) % (2.0 * np.pi) - np.pi))
    assert off_deg[round((begin_s + 3.0) * RATE_HZ) :].max() < 10.0


def test_ten_minutes_of_straight_walking_do_not_drift():
    walk = Walk(600.0, turns=False)
    walk.posture_deg[:] = (15.0, 0.0) * walk.ramp(4.0, 1.0)[:, None]
    walk.walks = walk.ramp(4.0, 1.0)
    parts = [
        off_deg(tracked(), walk, part, known=True, bias_deg_s=(0.2, 0.1, 0.1))
        for part in ((10, 60), (550, 600))
    ]
    assert parts[1] < parts[0] + 0.5
    assert parts[1] < 2.5


def test_a_bias_that_drifts_for_twenty_minutes_is_followed():
    walk = Walk(1200.0, turns=False)
    walk.walks = walk.ramp(4.0, 1.0)
    signals, truth = walk.signals(known=True)
    drift = np.radians(0.4) * (walk.time_s / 1200.0)[:, None]
    signals = replace(signals, axis_rates_rad_s=signals.axis_rates_rad_s + drift)

    def last_minute_deg(**parameters):
        error = truth - tracked(**parameters).estimate(signals)
        return np.degrees(np.abs(error[-3000:].mean(axis=0)))

    followed = last_minute_deg()
    assert followed.max() < 0.5
    # bias noise of a sensor at constant temperature
    assert (followed < 0.5 * last_minute_deg(bias_noise_deg_s=0.0001)).all()


@pytest.mark.parametrize(
    ("sits_deg", "pause_s"), [(0.0, 20.0), (80.0, 20.0), (80.0, 60.0)], ids=["stand", "sit", "long"]
)
def test_a_pause_is_waited_for(sits_deg, pause_s):
    walk = Walk(50.0 + pause_s + 40.0)
    pause = walk.ramp(50.0, 1.5) - walk.ramp(48.5 + pause_s, 1.5)
    walk.walks = 1.0 - walk.ramp(49.0, 1.0) + walk.ramp(50.0 + pause_s, 1.0)
    walk.turn = walk.turn * (walk.walks == 1.0)
    walk.posture_deg[:, 0] = sits_deg * pause
    signals, _ = walk.signals()
    method = tracked()
    assert method.run(signals).starting[round(56 * RATE_HZ) : round((48 + pause_s) * RATE_HZ)].all()
    sitting = (54.0, 48.0 + pause_s)
    assert off_deg(method, walk, sitting) < 8.0
    again = 50.0 + pause_s + 10.0
    assert off_deg(method, walk, (again, again + 30.0)) < 3.0


# where in the stride the person sits down
@pytest.mark.parametrize("begin_s", [30.0, 30.25, 30.5, 30.75])
def test_sitting_down_while_walking_is_not_a_swing(begin_s):
    never, paused = Walk(60.0), Walk(90.0)
    begin, end = round(begin_s * RATE_HZ), round((begin_s + 30.0) * RATE_HZ)
    sits = 80.0 * (paused.ramp(begin_s, 1.5) - paused.ramp(begin_s + 28.5, 1.5))
    signals, truth = never.signals()
    angles = np.degrees(np.insert(truth, [begin] * (end - begin), truth[begin], axis=0))
    angles[:, 0] += sits
    turned = Rotation.from_quat(orientation_from_angles(np.radians(angles)), scalar_first=True)
    rates = axis_rates((turned[:-1].inv() * turned[1:]).as_rotvec() * RATE_HZ)
    known = signals.axis_rates_rad_s
    rates = np.concatenate([known[:begin], rates[begin:end], known[begin:]])
    method = tracked()
    with_pause = method.run(replace(signals, axis_rates_rad_s=rates, specific_force_m_s2=rates))
    # the network, which leaks towards the posture, stops as soon as the person has sat down
    seated = slice(begin + round(1.6 * RATE_HZ), end)
    assert with_pause.starting[seated].all()
    error = angles[seated, 0] - np.degrees(with_pause.angles_rad[seated, 0])
    assert np.abs(error[: round(3.0 * RATE_HZ)]).max() < 4.0
    away = np.degrees(with_pause.angles_rad[end:] - method.estimate(signals)[begin:])[:, :2]
    assert np.abs(away[round(10.0 * RATE_HZ) :]).max() < 3.0


@pytest.mark.parametrize("gap_s", [0.1, 0.2])
def test_a_short_gap_is_interpolated_with_its_own_uncertainty(gap_s):
    walk = Walk(60.0)
    signals, truth = walk.signals()
    method = tracked()
    errors, deviations = [], []
    for begin in range(round(40.0 * RATE_HZ), round(41.1 * RATE_HZ), 4):
        after = begin + round(gap_s * RATE_HZ)
        rates = signals.axis_rates_rad_s.copy()
        rates[begin:after] = np.nan
        found = method.run(replace(signals, axis_rates_rad_s=rates))
        assert not found.starting[after]
        errors.append(np.degrees(truth - found.angles_rad)[after, :2])
        deviations.append(np.degrees(found.std_rad)[after, :2])
    # the last angle, held, is wrong by ten and twenty degrees
    rms_deg = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (rms_deg < 250.0 * gap_s**2).all()
    assert (np.abs(errors) < 1.96 * np.array(deviations)).mean() > 0.9


def test_nothing_is_learned_from_the_swing_in_which_a_recording_begins():
    signals, _ = Walk(20.0, turns=False).signals()
    later = signals.axis_rates_rad_s[round(0.5 * RATE_HZ) :]
    signals = replace(signals, axis_rates_rad_s=later, specific_force_m_s2=later)
    std = np.degrees(tracked().run(signals).std_rad[:, 0])
    # the leg reverses first after 0.8 s, and a second time after another stride of 1.1 s
    assert std[round(1.5 * RATE_HZ)] > 50.0
    # three and a half times that of a leg, of which it is not yet certain
    assert std[round(2.2 * RATE_HZ)] < 30.0


@pytest.mark.parametrize("slip_deg", [15.0, 40.0])
def test_a_slip_is_a_new_posture(slip_deg):
    walk = Walk(90.0)
    walk.posture_deg[:, 0] = slip_deg * walk.ramp(45.0, 0.5)
    # nine tenths of it at once, and no lasting mistake about what has changed
    assert off_deg(tracked(), walk, (46, 50)) < 0.2 * slip_deg
    assert off_deg(tracked(), walk, (65, 80)) < 0.2 * slip_deg


def test_a_phone_that_goes_from_the_hand_into_the_pocket_is_not_taken_for_gait():
    walk = Walk(60.0)
    walk.walks = walk.ramp(6.0, 1.0)
    walk.turn = walk.turn * walk.walks
    walk.posture_deg[:, 0] = 76.0 * (1.0 - walk.ramp(2.0, 2.0))
    walk.posture_deg[:, 1] = 30.0 * walk.ramp(1.0, 1.0) * (1.0 - walk.ramp(3.0, 1.5))
    assert off_deg(tracked(), walk, (12, 60)) < 3.0


def test_a_large_net_rotation_reopens_the_angle_of_an_unknown_start_only():
    walk = Walk(60.0, turns=False)
    walk.posture_deg[:, 0] = 50.0 * walk.ramp(30.9, 0.4)
    after = round(31.0 * RATE_HZ)
    for known in (False, True):
        signals, _ = walk.signals(known=known)
        with_doubt, without = (
            tracked(reopened_sd_deg=sd_deg).run(signals).std_rad[:, 0] for sd_deg in (20.0, 1e-9)
        )
        opened_deg = np.degrees(np.max((with_doubt - without)[after:]))
        assert opened_deg == 0.0 if known else opened_deg > 5.0


def test_an_uncertain_time_adds_the_rate_times_its_standard_deviation():
    """Its square is added; a constant rate about a level axis is that of the angle."""
    rates = np.tile([0.4, 0.0, 0.0], (200, 1))
    signals = SegmentSignals("thigh", RATE_HZ, rates, np.zeros_like(rates), np.zeros(3))
    sure, unsure = (
        tracked(delay_s=delay_s, std_scale=(2.0, 1.0, 1.0)).run(signals).std_rad[100, 0]
        for delay_s in (1e-9, 2.0)
    )
    assert unsure**2 - sure**2 == pytest.approx((2.0 * 2.0 * 0.4) ** 2, rel=1e-9)


def sums_of_corrections(signals, angles_rad, by_network, time_s=15.0):
    """Recent corrections of the sagittal angle: the difference of its changes and the rates.

    For a rotation about the sagittal axis alone, and a bias of zero.
    """
    rate = signals.axis_rates_rad_s[:, 0]
    moved = 0.5 * (rate[1:] + rate[:-1]) / RATE_HZ
    corrections = (np.diff(angles_rad[:, 0]) - moved) * by_network[1:]
    return lfilter([1.0], [1.0, -np.exp(-1.0 / RATE_HZ / time_s)], [0.0, *corrections])


def test_the_standard_deviation_grows_with_the_square_of_recent_corrections():
    phase = 2.0 * np.pi * 0.9 * np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    rates = np.zeros((len(phase), 3))
    rates[:, 0] = 2.0 * (np.cos(phase) + 0.5 * np.cos(2.0 * phase))
    rates[round(30.0 * RATE_HZ) :, 0] += np.radians(0.5)  # which the leg's return contradicts
    signals = SegmentSignals("thigh", RATE_HZ, rates, rates, np.zeros(3))
    settings = {"known_bias_sd_deg_s": 1e-9, "bias_noise_deg_s": 1e-9, "alignment_sd_deg": 1e-9}
    plain, grown = (
        tracked(**settings, corrected_sd_deg=sd_deg).run(signals) for sd_deg in (1e6, 2.0)
    )
    c = sums_of_corrections(signals, plain.angles_rad, ~plain.starting)
    added = np.sqrt(grown.std_rad**2 - plain.std_rad**2)
    late = slice(round(20.0 * RATE_HZ), None)
    assert np.degrees(np.abs(c).max()) > 4.0
    np.testing.assert_allclose(added[late, 0], c[late] ** 2 / np.radians(2.0), rtol=0.02, atol=1e-5)
    np.testing.assert_array_equal(added[:, 2], 0.0)
    np.testing.assert_array_equal(plain.angles_rad, grown.angles_rad)
    doubtful = grown.quality == Quality.DOUBTFUL
    assert doubtful.any()
    np.testing.assert_array_equal(
        doubtful[late], (added[late].max(axis=1) > np.radians(5.0)) & ~grown.starting[late]
    )
    assert not (plain.quality == Quality.DOUBTFUL).any()


def test_after_a_slip_the_band_holds_the_error_or_the_samples_are_marked():
    source = SimulatedGait(
        subjects=("V3", "V4", "V9"), conditions=("normal",), sampling_rate_hz=100.0,
        treadmill_duration_s=46.0, segments=("thigh_right", "shank_right"), slips_s=[30.0],
    )  # fmt: skip
    segments = [s for trial in source.select() for s in calibrate(trial).values()]
    shares = {}
    for sd_deg in (1e6, 3.0):
        shipped = pretrained()
        tracker = replace(shipped.tracker, corrected_sd_deg=sd_deg)
        method, counted = replace(shipped, tracker=tracker).method(), []
        for segment in segments:
            found = method.run(segment.signals)
            off = np.abs(segment.reference_angles_rad - found.angles_rad)[3500:4500, :2]
            held = off < 1.96 * found.std_rad[3500:4500, :2]
            marked = np.isin(found.quality[3500:4500], (Quality.STARTING, Quality.DOUBTFUL))
            counted.append((held | marked[:, None])[np.isfinite(off).all(axis=1)].mean(axis=0))
        shares[sd_deg] = np.mean(counted, axis=0)
    assert (shares[3.0] > 0.85).all()
    assert (shares[1e6] < 0.8).any()


def test_a_known_start_leaves_what_calibration_and_skin_leave():
    walk = Walk(60.0)
    for known in (True, False):
        signals, _ = walk.signals(known=known)
        free, limited = (
            tracked(alignment_sd_deg=sd_deg).run(signals).std_rad for sd_deg in (1e-9, 2.5)
        )
        assert np.min(free[1000:, :2]) < np.radians(2.5)
        expected = np.maximum(free, np.radians(2.5)) if known else free
        np.testing.assert_allclose(limited, expected, rtol=1e-12)


def test_the_own_rotation_of_a_leg_is_not_a_turn():
    """A thigh that rotates to and fro by 10 degrees: nothing measures the tilt meanwhile."""
    walk = Walk(60.0, turns=False)
    walk.turn = np.radians(10.0) * 5.6 * np.cos(5.6 * walk.time_s)
    swaying = walk.signals(known=True)[0]
    parts = {}
    for turning_time_s in (0.1, 1.0):
        tracking = Tracking(PostureTracker(turning_time_s=turning_time_s), network(), np.zeros(3))
        tracking.follow(swaying.axis_rates_rad_s, swaying.specific_force_m_s2)
        parts[turning_time_s] = tracking.covariance[kernel.CENTRE, kernel.CENTRE + 1]
    assert parts[1.0] == 0.0
    assert parts[0.1] != 0.0


def test_the_standard_deviation_follows_the_available_information():
    walk = Walk(90.0)
    signals, truth = walk.signals()
    rates = signals.axis_rates_rad_s.copy()
    rates[round(60 * RATE_HZ) : round(63 * RATE_HZ)] = np.nan
    signals = replace(signals, axis_rates_rad_s=rates)
    method = tracked(std_scale=(2.0, 1.0, 1.0), corrected_sd_deg=1e6)
    std = np.degrees(method.run(signals).std_rad)
    plain = np.degrees(tracked(corrected_sd_deg=1e6).run(signals).std_rad)
    np.testing.assert_allclose(std[:, 0], 2.0 * plain[:, 0])
    np.testing.assert_array_equal(std[:, 1], plain[:, 1])
    at = {
        second: plain[round(second * RATE_HZ), :2].max() for second in (0.1, 3.0, 50.0, 63.1, 80.0)
    }
    assert at[0.1] > 50.0
    assert at[3.0] > 1.5 * at[50.0]
    assert at[63.1] > 40.0
    assert at[80.0] < 4.0
    assert np.isnan(std[round(61 * RATE_HZ)]).all()
    error = np.degrees(truth - method.estimate(signals))[:, :2]
    inside = np.abs(error) < 1.96 * plain[:, :2]
    assert inside[np.isfinite(error)].mean() > 0.9


@pytest.mark.parametrize(
    ("second", "skewness", "growth", "quality"),
    [
        (0.5, 0.758, 1.0, Quality.GOOD),  # a leg
        (0.2, 0.4, 1.5, Quality.GOOD),
        (0.0, 0.0, 3.5, Quality.DOUBTFUL),  # an arm
        (-0.5, -0.758, 6.0, Quality.DOUBTFUL),  # a leg with the sensor the wrong way round
    ],
)
def test_the_standard_deviation_grows_where_the_motion_is_not_that_of_a_leg(
    second, skewness, growth, quality
):
    phase = 2.0 * np.pi * 0.9 * np.arange(0.0, 60.0, 1.0 / RATE_HZ)
    rates = np.zeros((len(phase), 3))
    rates[:, 0] = 2.0 * (np.cos(phase) + second * np.cos(2.0 * phase))
    np.testing.assert_allclose(stats.skew(rates[:, 0]), skewness, atol=1e-3)
    signals = SegmentSignals("thigh", RATE_HZ, rates, rates, None)
    method = tracked()
    found = Tracking(method.tracker, method.model, None).follow(rates, rates)
    estimate = method.run(signals)
    late = slice(round(40.0 * RATE_HZ), None)
    np.testing.assert_allclose(found.std_growth[late].mean(), growth, rtol=0.03)
    np.testing.assert_array_equal(estimate.quality[late], quality)
    grown = found.std_rad * found.std_growth[:, None]
    np.testing.assert_allclose(estimate.std_rad, np.hypot(grown, found.corrected_rad))
    # it is a leg until shown otherwise only if the start pose is known
    known = Tracking(method.tracker, method.model, np.zeros(3)).follow(rates[:1], rates[:1])
    np.testing.assert_allclose([known.std_growth[0], found.std_growth[0]], [1.0, 3.5])


def test_the_accelerometer_gives_the_mean_angle_too():
    walk = Walk(60.0)
    walk.posture_deg[:] = 12.0, -6.0
    # walking a circle at 0.9 m/s has centripetal acceleration; this motion has none, so speed is 0
    method = tracked(aided=True, speed_m_s=1e-3)
    assert off_deg(method, walk, (5, 60)) < 1.0
    assert method.needs_accelerometer


def test_both_directions_together_are_better():
    walk = Walk(60.0)
    walk.posture_deg[:, 0] = 30.0 * (1.0 - walk.ramp(2.0, 1.0))
    both, one = (
        off_deg(tracked(smoothing=smoothing), walk, (0, 58)) for smoothing in (True, False)
    )
    assert both < 0.5 * one


def test_another_sampling_rate_gives_the_same_angles():
    walk = Walk(60.0)
    signals, _ = walk.signals()
    rates = signals.axis_rates_rad_s
    between = np.arange(2 * len(rates) - 1) / 2.0
    finer = np.column_stack([np.interp(between, np.arange(len(rates)), axis) for axis in rates.T])
    finer[2000:2100] = np.nan
    method = tracked()
    found = method.estimate(
        SegmentSignals("thigh", 2 * RATE_HZ, finer, np.full_like(finer, np.nan))
    )
    assert np.isnan(found[2000:2100]).all()
    difference = np.degrees(found[::2] - method.estimate(signals))[:, :2]
    assert np.nanmax(np.abs(difference[500:1000])) < 0.5
    # the gap is as long at the network's rate
    lost = rates.copy()
    lost[1000:1050] = np.nan
    native = method.run(replace(signals, axis_rates_rad_s=lost, specific_force_m_s2=lost))
    other = method.run(SegmentSignals("thigh", 2 * RATE_HZ, finer, np.full_like(finer, np.nan)))
    shown = slice(1300, 2900)
    difference = np.degrees(other.angles_rad[::2] - native.angles_rad)[shown, :2]
    assert np.abs(difference).max() < 1.5
    for name in ("starting", "quality"):
        same = getattr(other, name)[::2] == getattr(native, name)
        assert same[shown].mean() > 0.99
        assert same[:1000].mean() > 0.99
    np.testing.assert_allclose(other.std_rad[::2][shown], native.std_rad[shown], rtol=0.2)


def test_it_streams_at_its_own_rate_only():
    with pytest.raises(MethodNotApplicableError, match="at 50 Hz, not at 100 Hz"):
        tracked().recursion(100.0, 1, None)
    with pytest.raises(MethodNotApplicableError, match="smoothing=false"):
        tracked(smoothing=True).recursion(RATE_HZ, 1, None)


def test_a_checkpoint_keeps_its_tracker(tmp_path):
    checkpoint = Checkpoint(network(), tracker=PostureTracker(idle_s=2.0, swing_sd_deg=(4, 3, 2)))
    save(checkpoint, tmp_path / "tracked.pt")
    assert load(tmp_path / "tracked.pt").tracker == checkpoint.tracker


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"forward_sd_m_s": 1e300}, r"forward_sd_m_s is 1e\+300, .* above zero \(1e-9 to 1e6\)"),
        ({"idle_s": 0.0}, r"tracker\.idle_s is 0\.0, expected a number above zero"),
        ({"idle_s": 0.9e-9}, r"tracker\.idle_s is 9e-10, .* above zero \(1e-9 to 1e6\)"),
        ({"idle_s": 1.1e6}, r"tracker\.idle_s is 1100000\.0, .* above zero \(1e-9 to 1e6\)"),
        ({"idle_s": True}, r"tracker\.idle_s is True, expected a number above zero"),
        ({"bias_sd_deg_s": "much"}, r"tracker\.bias_sd_deg_s is 'much'"),
        ({"speed_m_s": float("nan")}, r"tracker\.speed_m_s is nan"),
        ({"swing_sd_deg": (1.0, 2.0)}, r"tracker\.swing_sd_deg .* three numbers above zero"),
        ({"swing_sd_deg": 3.0}, r"tracker\.swing_sd_deg is 3\.0, expected three numbers"),
        ({"aided": "yes"}, r"tracker\.aided is 'yes', expected true or false"),
    ],
)
def test_nonsense_is_refused(parameters, message):
    with pytest.raises(UserError, match=message):
        PostureTracker(**parameters)


def test_the_limits_of_a_parameter_are_allowed():
    assert PostureTracker(idle_s=1e-9, swing_sd_deg=(1e6, 1e-9, 1.0)).idle_s == 1e-9
