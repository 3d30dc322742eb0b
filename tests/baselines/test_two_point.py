from dataclasses import replace

import numpy as np
import pytest

from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.two_point import TwoPoint
from narx.errors import MethodNotApplicableError, UserError
from narx.kinematics.segment_angles import tilt_from_specific_force
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2


def rms_deg(error):
    return np.rad2deg(np.sqrt(np.mean(error**2, axis=0)))


@pytest.fixture
def walk(motion):
    """Stands 4 s, walks, stands from 16 s on."""
    return motion("stand_walk_stand", 100.0, 20.0)


def test_start_and_stop_are_where_the_standing_ends_and_begins(walk):
    parts = TwoPoint().parts(walk.signals)
    # the motion itself rises smoothly from 4.0 s on and has ended at 16.0 s
    assert 4.0 <= parts.start / 100 < 4.4
    assert 15.6 < parts.stop / 100 <= 16.0


def test_a_constant_bias_is_taken_off_as_a_line(walk):
    bias = np.deg2rad([0.8, -0.5, 1.2])
    biased = replace(walk.signals, axis_rates_rad_s=walk.signals.axis_rates_rad_s + bias)
    method = TwoPoint(4.0, 16.0)
    clean, dirty = method.parts(walk.signals), method.parts(biased)
    # up to what the bias does in the half second over which the errors are averaged
    allowed = np.abs(bias) * 0.31
    assert (np.abs(dirty.angles_rad - clean.angles_rad) <= allowed).all()
    drift = (dirty.drift_rad - clean.drift_rad)[dirty.start : dirty.stop + 1]
    expected = np.arange(dirty.start, dirty.stop + 1)[:, None] * 0.01 * bias
    assert (np.abs(drift - expected) <= allowed).all()
    middle = len(drift) // 2
    np.testing.assert_allclose(drift[middle], expected[middle], atol=1e-9)


def test_a_drift_beyond_half_a_turn_is_taken_off_whole(walk):
    """The error after the walk, 0.2 rad/s times 16 s, is known only up to whole turns."""
    bias = np.array([0.2, 0.0, 0.0])
    biased = replace(walk.signals, axis_rates_rad_s=walk.signals.axis_rates_rad_s + bias)
    method = TwoPoint(4.0, 16.0)
    drift = method.parts(biased).drift_rad - method.parts(walk.signals).drift_rad
    expected = np.arange(400, 1601) * 0.01 * 0.2
    assert np.abs(drift[400:1601, 0] - expected).max() < 0.2 * 0.31


def test_it_is_better_than_plain_integration_on_every_axis(walk):
    bias = np.deg2rad([0.4, -0.3, 0.5])
    biased = replace(walk.signals, axis_rates_rad_s=walk.signals.axis_rates_rad_s + bias)
    compensated = rms_deg(TwoPoint().estimate(biased) - walk.angles_rad)
    plain = rms_deg(GyroIntegration().estimate(biased) - walk.angles_rad)
    assert (compensated < plain).all()
    assert (compensated < 1.5).all()


def _tilt(signals):
    tilt = np.zeros((signals.n_samples, 3))
    tilt[:, :2] = tilt_from_specific_force(signals.specific_force_m_s2)
    return tilt


def test_printed_equations(walk):
    """(8) to (14) one by one, rectangle rule, each error a mean over 61 samples."""
    rates = walk.signals.axis_rates_rad_s + np.deg2rad([0.8, -0.5, 1.2])
    parts = TwoPoint(rule="rectangle").parts(replace(walk.signals, axis_rates_rad_s=rates))
    a, b = parts.start, parts.stop
    psi = np.zeros((b + 1, 3))
    for n in range(1, b + 1):
        psi[n] = psi[n - 1] + rates[n] * 0.01
    before, after = np.arange(a - 60, a + 1), np.arange(b, b + 61)
    psi_all = np.cumsum(rates, axis=0) * 0.01
    error_a = (psi_all - psi_all[0] - _tilt(walk.signals))[before].mean(axis=0)
    error_b = (psi_all - psi_all[0] - _tilt(walk.signals))[after].mean(axis=0)
    weight = (np.arange(a, b + 1) - a)[:, None] / (b - a)
    theta = psi[a : b + 1] - (error_a * (1 - weight) + error_b * weight)
    np.testing.assert_allclose(parts.angles_rad[a : b + 1], theta, atol=1e-10)


def test_the_average_over_standing_does_not_reach_into_the_walk():
    n = 1200
    rates = np.zeros((n, 3))
    t = np.arange(400) / 100.0
    rates[400:800, 0] = 2.0 * np.cos(2 * np.pi * t)
    force = np.tile([0.0, 0.0, GRAVITY_M_S2], (n, 1))
    force[400:800, 0] += 5.0 * np.cos(2 * np.pi * t)
    parts = TwoPoint().parts(SegmentSignals("thigh_right", 100.0, rates, force))
    np.testing.assert_allclose(parts.angles_rad[: parts.start], 0.0, atol=1e-12)
    np.testing.assert_allclose(parts.angles_rad[parts.stop + 1 :], 0.0, atol=1e-12)


def test_no_still_part_is_refused_with_which_and_how_long(walk):
    signals = walk.signals
    with pytest.raises(MethodNotApplicableError) as refusal:
        TwoPoint().estimate(signals.select(slice(700, None)))
    message = str(refusal.value)
    assert "two_point does not apply to thigh_right: no still part before the walk" in message
    assert "none of 0.5 s" in message
    assert "\n" not in message
    with pytest.raises(MethodNotApplicableError, match=r"no still part after the walk: .* last \d"):
        TwoPoint().estimate(signals.select(slice(0, 1300)))


def test_times_given_by_hand(walk):
    by_hand = TwoPoint(start_s=4.0, stop_s=16.0).parts(walk.signals)
    assert (by_hand.start, by_hand.stop) == (400, 1600)
    automatic = TwoPoint().estimate(walk.signals)
    assert np.rad2deg(np.abs(by_hand.angles_rad - automatic).max()) < 2.0


@pytest.mark.parametrize("times", [(-1.0, 16.0), (16.0, 4.0), (4.0, 20.01)])
def test_times_outside_the_recording_are_refused(walk, times):
    with pytest.raises(MethodNotApplicableError, match=r"start_s < stop_s <= 20\.00 in thigh"):
        TwoPoint(*times).estimate(walk.signals)


def test_half_a_pair_of_times_is_a_mistake():
    with pytest.raises(UserError, match="expected both or neither"):
        TwoPoint(start_s=3.0)


def test_shaky_legs(walk):
    rng = np.random.default_rng(4)
    t = walk.time_s
    tremor = np.deg2rad(14.0) * np.sin(2 * np.pi * 5.0 * t + rng.uniform(0, 6, 1))
    rates = walk.signals.axis_rates_rad_s + np.column_stack([tremor, 0 * t, 0 * t])
    force = walk.signals.specific_force_m_s2.copy()
    force[:, 2] += 0.09 * GRAVITY_M_S2 * np.sin(2 * np.pi * 5.0 * t)
    signals = replace(walk.signals, axis_rates_rad_s=rates, specific_force_m_s2=force)
    with pytest.raises(MethodNotApplicableError, match="no still part"):
        TwoPoint().estimate(signals)
    with pytest.raises(MethodNotApplicableError, match="no still part"):
        TwoPoint(shaky_legs=True, shaky_margin=0.5).estimate(signals)
    parts = TwoPoint(shaky_legs=True).parts(signals)
    assert 3.9 < parts.start / 100 < 4.5
    assert 15.5 < parts.stop / 100 < 16.1
    assert (rms_deg(parts.angles_rad - walk.angles_rad) < 2.0).all()


def test_a_gap_inside_the_walk_keeps_its_length(walk):
    rates = walk.signals.axis_rates_rad_s.copy()
    rates[900:905] = np.nan
    parts = TwoPoint().parts(replace(walk.signals, axis_rates_rad_s=rates))
    whole = TwoPoint().parts(walk.signals)
    assert (parts.start, parts.stop) == (whole.start, whole.stop)
    missing = np.isnan(parts.angles_rad).any(axis=1)
    assert np.flatnonzero(missing).tolist() == list(range(900, 905))
    # the rotation lost in the gap is distributed over the walk
    assert np.rad2deg(np.nanmax(np.abs(parts.angles_rad - whole.angles_rad))) < 7.0


def test_without_the_accelerometer_the_rotation_in_the_walk_is_kept(walk):
    force = walk.signals.specific_force_m_s2.copy()
    force[900:905] = np.nan
    angles = TwoPoint().estimate(replace(walk.signals, specific_force_m_s2=force))
    assert np.isnan(angles[900:905]).all()
    rest = np.r_[0:900, 905:2000]
    np.testing.assert_allclose(angles[rest], TwoPoint().estimate(walk.signals)[rest], atol=1e-12)


def test_a_walk_may_end_with_the_recording(walk):
    last_s = (walk.signals.n_samples - 1) / 100.0
    assert TwoPoint(4.0, last_s).parts(walk.signals).stop == walk.signals.n_samples - 1


def test_a_walk_may_begin_with_the_recording(walk):
    parts = TwoPoint(0.0, 16.0).parts(walk.signals)
    assert parts.start == 0
    np.testing.assert_allclose(parts.drift_rad[0], 0.0, atol=1e-12)


def test_standing_is_the_tilt_of_the_mean_force(walk):
    """Eq. (7) over 61 samples, the outermost two with half a weight."""
    force = walk.signals.specific_force_m_s2
    force = force + np.random.default_rng(0).normal(0.0, 0.5, force.shape)
    parts = TwoPoint(4.0, 16.0).parts(replace(walk.signals, specific_force_m_s2=force))
    weights = np.array([0.5, *[1.0] * 59, 0.5]) / 60.0
    for k in (200, 1800):
        expected = tilt_from_specific_force(weights @ force[k - 30 : k + 31])
        np.testing.assert_allclose(parts.angles_rad[k], [*expected, 0.0], atol=1e-12)


def test_coupled_axes_integrate_the_rates_of_the_angles(motion):
    turn = motion("stand_turn_stand", 100.0, 40.0).signals
    start = np.append(tilt_from_specific_force(turn.specific_force_m_s2[:1])[0], 0.0)
    known = replace(turn, initial_angles_rad=start)
    for coupled in (False, True):
        found = TwoPoint(4.0, 36.0, coupled=coupled).parts(turn).gyroscope_angles_rad
        expected = GyroIntegration(coupled=coupled).estimate(known)
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_missing_standing_is_refused(walk):
    force = walk.signals.specific_force_m_s2.copy()
    force[:500] = np.nan
    signals = replace(walk.signals, specific_force_m_s2=force)
    with pytest.raises(MethodNotApplicableError, match="no still part before"):
        TwoPoint().estimate(signals)
    with pytest.raises(MethodNotApplicableError, match="before the walk is missing"):
        TwoPoint(4.0, 16.0).estimate(signals)


def test_a_recording_that_stands_still_throughout_is_tilt(motion):
    tilted = motion("tilted", duration_s=4.0)
    parts = TwoPoint().parts(tilted.signals)
    assert parts.start is None
    np.testing.assert_allclose(parts.angles_rad, tilted.angles_rad, atol=1e-12)


def test_it_needs_the_whole_recording():
    with pytest.raises(MethodNotApplicableError, match="two_point needs the whole recording"):
        TwoPoint().recursion(100.0, 1, None)


def test_a_tilt_that_wraps_while_standing_makes_no_step_where_the_walk_begins():
    """A sensor upside down: its tilt passes half a turn before the walk."""
    time_s = np.arange(1200) / 100.0
    tilt = np.pi + 0.05 * np.clip(time_s - 3.7, -0.2, 0.2)
    walking = (time_s > 4.0) & (time_s < 8.0)
    tilt += 0.3 * walking * np.sin(2.0 * np.pi * time_s)
    rates = np.zeros((1200, 3))
    rates[:, 0] = np.gradient(tilt, 0.01)
    force = GRAVITY_M_S2 * np.stack([np.sin(tilt), 0.0 * tilt, np.cos(tilt)], axis=1)
    parts = TwoPoint().parts(SegmentSignals("thigh_right", 100.0, rates, force))
    assert 390 < parts.start < 420
    around = parts.angles_rad[parts.start - 5 : parts.start + 5, 0]
    assert np.abs(np.diff(around)).max() < 0.1


def test_the_integral_starts_from_the_tilt_of_the_first_sample(motion):
    walk = motion("stand_walk_stand", 100.0, 20.0).signals
    force = walk.specific_force_m_s2.copy()
    force[0] = GRAVITY_M_S2 * np.array([np.sin(0.1), 0.0, np.cos(0.1)])
    parts = TwoPoint(4.0, 16.0).parts(replace(walk, specific_force_m_s2=force))
    tilt = tilt_from_specific_force(force[:1])[0]
    assert abs(tilt).max() == pytest.approx(0.1)
    np.testing.assert_allclose(parts.gyroscope_angles_rad[0, :2], tilt[:2], atol=1e-3)
