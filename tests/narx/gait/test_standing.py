import numpy as np
import pytest

from narx.errors import MethodNotApplicableError
from narx.gait.standing import StillThresholds, runs, start_and_stop, still_samples
from narx.recordings.trial import GRAVITY_M_S2

RATE_HZ = 100.0


def still(n):
    return np.zeros((n, 3)), np.tile([0.0, 0.0, GRAVITY_M_S2], (n, 1))


def recording(*parts):
    """Build a recording from parts, 'still' or 'walk', with their durations in seconds."""
    n = round(sum(length for _, length in parts) * RATE_HZ)
    rates, force = still(n)
    begin = 0
    for kind, length in parts:
        end = begin + round(length * RATE_HZ)
        if kind == "walk":
            rates[begin:end, 0] = 1.0
        begin = end
    return rates, force


def test_runs():
    flags = np.array([1, 1, 0, 0, 1, 0, 1, 1, 1], dtype=bool)
    assert runs(flags) == [(0, 2), (4, 5), (6, 9)]
    assert runs(np.zeros(3, dtype=bool)) == []
    assert runs(np.zeros(0, dtype=bool)) == []


@pytest.mark.parametrize(
    ("norm_g", "is_still"), [(0.94, True), (1.06, True), (0.92, False), (1.08, False)]
)
def test_gravity_counts_from_both_sides(norm_g, is_still):
    """As printed, (3) would classify 1.08 g, and any impact, as still."""
    rates, force = still(100)
    assert still_samples(rates, norm_g * force, RATE_HZ).all() == is_still
    assert still_samples(rates, norm_g * force, RATE_HZ).any() == is_still


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize(
    ("rate_deg_s", "is_still"), [(9.9, True), (-9.9, True), (10.1, False), (-10.1, False)]
)
def test_every_axis_counts(axis, rate_deg_s, is_still):
    rates, force = still(100)
    rates[:, axis] = np.deg2rad(rate_deg_s)
    assert still_samples(rates, force, RATE_HZ).all() == is_still


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 500.0])
def test_a_run_must_last_half_a_second_at_any_rate(rate_hz):
    n = round(2 * rate_hz)
    for lasts_s, expected in [(0.45, False), (0.55, True)]:
        rates, force = still(n)
        rates[round(lasts_s * rate_hz) :, 2] = 1.0
        assert still_samples(rates, force, rate_hz).any() == expected


def test_a_missing_sample_is_not_still():
    rates, force = still(300)
    rates[100, 1] = np.nan
    force[200, 0] = np.nan
    marked = still_samples(rates, force, RATE_HZ)
    assert np.flatnonzero(~marked).tolist() == [100, 200]


@pytest.mark.parametrize("stands_after_s", [1.0, 4.0, 30.0])
def test_start_and_stop_for_any_length_of_standing(stands_after_s):
    rates, force = recording(("still", 4), ("walk", 5), ("still", stands_after_s))
    assert start_and_stop(rates, force, RATE_HZ) == (399, 900)


def test_a_pause_shorter_than_half_a_second_does_not_stop_the_walk():
    rates, force = recording(("still", 4), ("walk", 2), ("still", 0.4), ("walk", 2), ("still", 4))
    assert start_and_stop(rates, force, RATE_HZ) == (399, 840)


def test_standing_throughout_has_no_walk():
    assert start_and_stop(*still(500), RATE_HZ) is None


def test_refusals_say_which_part_and_how_long_it_was_looked_for():
    rates, force = recording(("walk", 6), ("still", 4))
    with pytest.raises(MethodNotApplicableError, match=r"before the walk: .* in the first 3\.0 s"):
        start_and_stop(rates, force, RATE_HZ)
    rates, force = recording(("still", 4), ("walk", 6))
    with pytest.raises(MethodNotApplicableError, match=r"after the walk: .* in the last 3\.0 s"):
        start_and_stop(rates, force, RATE_HZ)


def test_pauses_within_a_longer_walk_are_not_standing_before_and_after_it():
    rates, force = recording(
        ("walk", 10), ("still", 0.6), ("walk", 20), ("still", 0.6), ("walk", 10)
    )
    with pytest.raises(MethodNotApplicableError, match=r"at 10\.6 s .* 50% of the movement lies"):
        start_and_stop(rates, force, RATE_HZ)


def test_strapping_the_sensor_on_and_off_does_not_matter():
    rates, force = recording(("walk", 1), ("still", 3), ("walk", 10), ("still", 3), ("walk", 1))
    assert start_and_stop(rates, force, RATE_HZ) == (399, 1400)


def test_thresholds_rise_above_the_first_second_and_never_fall():
    rates, force = still(300)
    thresholds = StillThresholds()
    assert thresholds.raised_for_shaky_legs(rates, force, RATE_HZ) == thresholds
    rates[:, 1] = 0.3
    force *= 1.1
    raised = thresholds.raised_for_shaky_legs(rates, force, RATE_HZ, margin=2.0)
    assert raised.rate_rad_s == pytest.approx(0.6)
    assert raised.gravity_fraction == pytest.approx(0.2)
    assert raised.duration_s == thresholds.duration_s
    # later samples do not matter
    rates[100:] = 5.0
    assert thresholds.raised_for_shaky_legs(rates, force, RATE_HZ).rate_rad_s == pytest.approx(0.6)


def test_fifty_samples_at_100_hz_are_enough_and_49_are_not():
    for n, expected in ((50, True), (49, False)):
        rates, force = still(200)
        rates[n:, 0] = 1.0
        assert still_samples(rates, force, RATE_HZ).any() == expected


def test_a_sinusoidal_tremor_stays_below_twice_its_mean():
    """Its peaks are pi / 2 times its mean magnitude."""
    rates, force = still(1000)
    rates[:, 0] = 0.4 * np.sin(2 * np.pi * 8.0 * np.arange(1000) / RATE_HZ)
    raised = StillThresholds().raised_for_shaky_legs(rates, force, RATE_HZ)
    assert raised.rate_rad_s == pytest.approx(2.0 * 0.4 * 2.0 / np.pi, rel=0.03)
    assert still_samples(rates, force, RATE_HZ, raised).all()
