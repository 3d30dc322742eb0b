"""Faults are found where they were inserted, and nothing else is changed."""

import warnings

import numpy as np
import pytest

from narx.recordings.faults import repeated_share, repeats_of_a_slower_sensor, without_faults


@pytest.fixture(scope="module")
def walk(device_walk):
    return device_walk(50.0, 30.0)


def _held(rate):
    rate[850:900] = rate[850]
    return np.arange(851, 900), "repeat their predecessor bit by bit"


def _zeros(rate):
    rate[850:870] = 0.0
    rate[1000] = 0.0
    return np.r_[850:870, 1000], "of exactly zero within movement"


def _spikes(rate):
    rate[[700, 900, 1100], 1] = [30.0, -20.0, 8.0]
    return np.array([700, 900, 1100]), "with a spike"


def _impossible(rate):
    rate[800, 2], rate[900, 0] = 1e30, -1e308
    return np.array([800, 900]), "beyond any gyroscope"


def _stuck(rate):
    rate[850:900, 1] = rate[850, 1]
    return np.arange(851, 900), "with a constant axis while the others move"


@pytest.mark.parametrize("damage", [_held, _zeros, _spikes, _impossible, _stuck])
def test_faults_become_missing_and_are_counted(walk, damage):
    rate = walk.gyroscope_rad_s.copy()
    wrong, what = damage(rate)
    found, notes = without_faults(walk.time_s, rate)
    assert set(np.flatnonzero(np.isnan(found).any(axis=1))) == set(wrong)
    np.testing.assert_array_equal(np.delete(found, wrong, axis=0), np.delete(rate, wrong, axis=0))
    assert any(what in note and note.startswith(str(len(wrong))) for note in notes)


@pytest.mark.parametrize(("rows", "found"), [(13, False), (14, True)])
def test_an_axis_that_stays_for_a_quarter_of_a_second_is_stuck(walk, rows, found):
    rate = walk.gyroscope_rad_s.copy()
    rate[850 : 850 + rows, 1] = rate[850, 1]
    missing = np.isnan(without_faults(walk.time_s, rate)[0]).any(axis=1)
    assert set(np.flatnonzero(missing)) == (set(range(851, 850 + rows)) if found else set())


def test_a_clean_walk_is_unchanged(walk):
    noise = np.random.default_rng(0).normal(0.0, 0.02, walk.gyroscope_rad_s.shape)
    for rate in (walk.gyroscope_rad_s, walk.gyroscope_rad_s + noise):
        found, notes = without_faults(walk.time_s, rate)
        np.testing.assert_array_equal(found, rate)
        assert not notes


def test_coarse_numbers_are_no_fault(walk):
    """Rounded to 1 deg/s a sensor at rest repeats itself, and peaks have flat tops."""
    rate = np.radians(np.round(np.degrees(walk.gyroscope_rad_s)))
    found, notes = without_faults(walk.time_s, rate)
    np.testing.assert_array_equal(found, rate)
    assert not notes


@pytest.mark.parametrize("limit_deg_s", [60.0, 100.0])
def test_clipping_is_reported_and_left(walk, limit_deg_s):
    limit = np.radians(limit_deg_s)
    rate = np.clip(walk.gyroscope_rad_s, -limit, limit)
    found, notes = without_faults(walk.time_s, rate)
    np.testing.assert_array_equal(found, rate)
    share = (np.abs(rate) == limit).any(axis=1).mean()
    assert notes[0].startswith(f"{100 * share:.0f} % of the rows are at the same extreme value")


def test_extremes_after_lost_samples_are_not_called_clipped(walk):
    """Whether the signal reached them at full slope is unknown then."""
    limit = np.radians(60.0)
    rate = np.clip(walk.gyroscope_rad_s, -limit, limit)
    at_limit = np.abs(rate) == limit
    rate[:-1][at_limit[1:] & ~at_limit[:-1]] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _, notes = without_faults(walk.time_s, rate)
    assert not any("same extreme value" in note for note in notes)


def test_a_slower_sensor_on_a_faster_clock(walk):
    held = np.repeat(walk.gyroscope_rad_s, 4, axis=0)
    repeats = repeats_of_a_slower_sensor(held)
    # standing still at zero repeats itself anyway
    assert not repeats[np.arange(801, len(held)) // 4 * 4].any()
    assert repeats[800:].mean() == pytest.approx(0.75, abs=0.01)
    assert repeats_of_a_slower_sensor(walk.gyroscope_rad_s) is None


def test_repeats_in_runs_of_any_length_are_not_a_slower_sensor(walk):
    """They are held values, which become missing."""
    rate = walk.gyroscope_rad_s.copy()
    for start, length in ((300, 2), (400, 300), (800, 3), (900, 2), (1000, 300)):
        rate[start : start + length] = rate[start]
    assert repeated_share(rate) > 0.3
    assert repeats_of_a_slower_sensor(rate) is None


@pytest.mark.parametrize(
    ("rate_hz", "rows", "found"),
    [(50.0, 2, False), (50.0, 3, True), (200.0, 4, False), (200.0, 7, True)],
)
def test_three_rows_over_30_ms_are_held(device_walk, rate_hz, rows, found):
    fast = device_walk(rate_hz, 12.0)
    rate, at = fast.gyroscope_rad_s.copy(), round(6.0 * rate_hz)
    at += int(np.argmax(np.linalg.norm(rate[at:], axis=1)))
    rate[at : at + rows] = rate[at]
    missing = np.isnan(without_faults(fast.time_s, rate)[0]).any(axis=1)
    assert set(np.flatnonzero(missing)) == (set(range(at + 1, at + rows)) if found else set())


def test_a_spike_stands_out_from_all_other_samples():
    """Noise of a known size: eight times the usual deviation is noise, sixteen times a spike."""
    noise = np.random.default_rng(0).normal(0.0, 0.4, (3000, 3))
    time_s = np.arange(3000) / 100.0
    line = 0.5 * (noise[:-2] + noise[2:])
    usual = np.quantile(np.linalg.norm(noise[1:-1] - line, axis=1), 0.75)
    for factor, is_spike in ((8.0, False), (16.0, True)):
        rate = noise.copy()
        rate[1500] = line[1499] + [0.0, factor * usual, 0.0]
        found, _ = without_faults(time_s, rate)
        assert np.isnan(found[1500]).all() == is_spike
        assert np.isfinite(np.delete(found, 1500, axis=0)).all()


@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("size_rad_s", [6.0, 35.0])
def test_many_spikes_of_several_samples(walk, width, size_rad_s):
    """A hundredth of the samples are spikes, on one axis or on all."""
    rate = walk.gyroscope_rad_s.copy()
    rng = np.random.default_rng(width)
    wrong = np.zeros(len(rate), dtype=bool)
    for start in range(260, 1480, 100 * width):
        wrong[start : start + width] = True
        axes = slice(None) if rng.random() < 0.5 else rng.integers(3)
        rate[start : start + width, axes] += rng.choice([-1, 1]) * size_rad_s
    found, notes = without_faults(walk.time_s, rate)
    missing = np.isnan(found).any(axis=1)
    np.testing.assert_array_equal(missing, wrong)
    assert "with a spike taken as missing" in notes[0]


def test_a_jump_of_less_than_two_degrees_is_not_a_spike():
    time_s = np.arange(3000) / 100.0
    for turn_deg, is_spike in ((1.5, False), (3.0, True)):
        rate = np.random.default_rng(0).normal(0.0, 0.001, (3000, 3))
        rate[1500, 1] = np.radians(turn_deg) * 100.0
        assert np.isnan(without_faults(time_s, rate)[0][1500]).all() == is_spike


def test_an_impact_that_rings_is_not_a_spike():
    """A step does not return to its previous value."""
    rate = np.random.default_rng(0).normal(0.0, 0.001, (3000, 3))
    rate[1500:, 1] += 3.0
    rate[1500, 1] += 4.0
    assert np.isfinite(without_faults(np.arange(3000) / 100.0, rate)[0]).all()


def test_a_sensor_that_turns_steadily_about_one_axis_is_not_stuck():
    """On a turntable, one axis is constant because the others do not move."""
    time_s = np.arange(1000) / 100.0
    rate = 0.01 * np.random.default_rng(0).standard_normal((1000, 3))
    rate[200:500, 2], rate[500:503, 2] = 1.0, [1.5, 2.0, 1.5]
    found, notes = without_faults(time_s, rate)
    np.testing.assert_array_equal(found, rate)
    assert not notes


def test_zeros_before_a_movement_that_starts_within_a_sample_are_missing():
    """At the start, and after a movement of 10 deg/s; one that begins slowly is none."""
    rate = np.random.default_rng(0).normal(0.0, 0.001, (3000, 3))
    rate[:, 1] += np.radians(10.0)
    rate[20:400, 1] = rate[1020:2000, 1] = np.radians(30.0)
    rate[:20] = rate[1000:1020] = rate[2500:2520] = 0.0
    found, notes = without_faults(np.arange(3000) / 100.0, rate)
    missing = np.flatnonzero(np.isnan(found).any(axis=1))
    assert set(missing) == {*range(20), *range(1000, 1020)}
    assert notes[0].startswith("40 samples of exactly zero within movement")


@pytest.mark.parametrize(("size_rad_s", "is_spike"), [(3.7, True), (-3.7, True), (3.3, False)])
def test_a_spike_deviates_from_the_line_between_its_neighbours(size_rad_s, is_spike):
    """Two degrees at 100 Hz are 3.5 rad/s from the middle of a step of 0.8 rad/s."""
    rate = np.random.default_rng(0).normal(0.0, 0.001, (3000, 3))
    rate[:1500, 1] -= 0.4
    rate[1500:, 1] += 0.4
    rate[1500, 1] = size_rad_s
    found, _ = without_faults(np.arange(3000) / 100.0, rate)
    assert np.isnan(found[1500]).all() == is_spike


def test_a_spike_stands_out_from_movement_and_not_from_rest():
    """A twentieth of the recording moves, with noise of which eight times the usual is no spike."""
    rng = np.random.default_rng(0)
    rate = rng.normal(0.0, 0.001, (10000, 3))
    rate[5000:5500] = noise = rng.normal(0.0, 0.4, (500, 3))
    line = 0.5 * (noise[:-2] + noise[2:])
    usual = np.quantile(np.linalg.norm(noise[1:-1] - line, axis=1), 0.75)
    for factor, is_spike in ((8.0, False), (16.0, True)):
        rate[5250] = line[249] + [0.0, factor * usual, 0.0]
        found, _ = without_faults(np.arange(10000) / 100.0, rate)
        assert np.isnan(found[5250]).all() == is_spike


@pytest.mark.parametrize(("rows", "reported"), [(11, False), (56, True)])
def test_a_thousandth_of_clipped_rows_is_not_reported_and_half_a_per_cent_is(rows, reported):
    """Half a sine, cut at two thirds of its peak, is at that level for half of its rows."""
    rate = np.random.default_rng(0).normal(0.0, 0.01, (6000, 3))
    rate[3000 : 3000 + rows, 1] += 3.0 * np.sin(np.pi * (np.arange(rows) + 0.5) / rows)
    rate = np.minimum(rate, 2.0)
    share = (rate[:, 1] == 2.0).mean()
    assert (share > 0.002) == reported
    found, notes = without_faults(np.arange(6000) / 100.0, rate)
    np.testing.assert_array_equal(found, rate)
    assert any("the gyroscope's range is too small" in note for note in notes) == reported


@pytest.mark.parametrize(("file_hz", "slower"), [(66.0, False), (80.0, True)])
def test_a_third_of_repeated_rows_is_a_slower_sensor(walk, file_hz, slower):
    """Fifty samples of a sensor in 66 or 80 rows of a file: 24 and 37 % repeat the previous one."""
    rows = np.floor(np.arange(round(30.0 * file_hz)) * 50.0 / file_hz + 1e-9).astype(int)
    held = walk.gyroscope_rad_s[np.minimum(rows, 1499)][round(5.0 * file_hz) :]
    repeats = repeats_of_a_slower_sensor(held)
    assert (repeats is not None) == slower
    assert not slower or repeats.mean() == pytest.approx(3 / 8, abs=0.01)


def test_repeats_are_a_share_of_the_movement(walk):
    rest = np.random.default_rng(0).normal(0.0, 0.001, (6000, 3))
    held = np.repeat(walk.gyroscope_rad_s[300:], 4, axis=0)
    assert repeated_share(np.vstack([rest, held])) == pytest.approx(0.75, abs=0.02)
