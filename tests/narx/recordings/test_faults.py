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
