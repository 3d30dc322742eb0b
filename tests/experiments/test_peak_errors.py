import numpy as np
import pytest

from narx.errors import MethodNotApplicableError
from narx.experiments.peak_errors import Swing, _peaks, peak_errors, swing, swing_results


@pytest.fixture
def walk(make_walk):
    walk = make_walk(methods=("giof",))
    walk.estimates_rad["giof"][:] = walk.reference_rad
    return walk


def test_from_minimum_to_minimum_at_1000_hz(walk):
    angles = swing(walk, "giof")
    np.testing.assert_allclose(np.diff(angles.time_s), 0.001)
    # 0.4 sin(2 pi 0.9 t) has its minima at (0.75 + k) / 0.9 s; scored from 2 s on
    np.testing.assert_allclose(angles.time_s[[0, -1]], [2.75 / 0.9, 17.75 / 0.9], atol=0.011)
    np.testing.assert_allclose(angles.reference_deg[0], -np.rad2deg(0.4), rtol=1e-2)
    np.testing.assert_array_equal(angles.estimate_deg, angles.reference_deg)


def test_peaks_of_a_scaled_delayed_and_shifted_estimate(walk):
    reference = walk.reference_rad[:, 0]
    delay = 3
    walk.estimates_rad["giof"][delay:, 0] = 0.9 * reference[:-delay] + np.deg2rad(1.0)
    peaks = peak_errors(swing(walk, "giof"))
    positive, negative = (peaks[peaks["peak"] == kind] for kind in ("positive", "negative"))
    assert len(positive) == 15
    assert len(negative) == 14
    amplitude = np.rad2deg(0.4)
    np.testing.assert_allclose(positive["error_deg"], 0.1 * amplitude - 1.0, atol=0.05)
    np.testing.assert_allclose(negative["error_deg"], -0.1 * amplitude - 1.0, atol=0.05)
    np.testing.assert_allclose(positive["lag_s"], delay / 50.0, atol=0.021)


def test_a_peak_that_the_estimate_lacks_has_no_pair(walk):
    time, estimate = walk.time_s, walk.estimates_rad["giof"][:, 0]
    straight = (time > 6.0) & (time < 9.0)
    estimate[straight] = np.interp(time[straight], time[~straight], estimate[~straight])
    peaks = peak_errors(swing(walk, "giof"))
    inside = peaks["time_s"].between(6.2, 8.8)
    assert not inside.any()
    assert len(peaks) > 20


def test_the_longest_stretch_without_a_gap(walk):
    walk.reference_rad[300] = np.nan
    angles = swing(walk, "giof")
    assert angles.time_s[0] > 6.0
    assert np.isfinite(angles.reference_deg).all()


def test_too_short_a_walk_is_refused(make_walk):
    short = make_walk(duration_s=3.0, methods=("giof",))
    with pytest.raises(MethodNotApplicableError, match="expected two to trim between"):
        swing(short, "giof")
    still = make_walk(methods=("giof",))
    still.reference_rad[:] = np.nan
    with pytest.raises(MethodNotApplicableError, match="0 minima"):
        swing(still, "giof")


def test_it_begins_and_ends_at_a_minimum(walk):
    """Straight lines between the samples at 50 Hz have their minima at samples."""
    angles = swing(walk, "giof")
    assert angles.reference_deg[0] < angles.reference_deg[1]
    assert angles.reference_deg[-1] < angles.reference_deg[-2]
    ends = 50.0 * angles.time_s[[0, -1]]
    np.testing.assert_allclose(ends, ends.round(), atol=1e-6)


def _zigzag(*corners, corner_s=0.3):
    """Straight lines between corners, one every 0.3 s, at 1000 Hz."""
    n = round(1000 * corner_s)
    return np.interp(np.arange(n * (len(corners) - 1) + 1), n * np.arange(len(corners)), corners)


@pytest.mark.parametrize(("frequency_hz", "expected"), [(1.6, 16), (2.4, 12)])
def test_peaks_are_at_least_half_a_second_apart(frequency_hz, expected):
    """All of a run at 1.6 strides a second, and every second one of a faster oscillation."""
    time_s = np.arange(10_000) / 1000.0
    wave = np.sin(2.0 * np.pi * frequency_hz * time_s)
    assert len(_peaks(wave, "positive")) == pytest.approx(expected, abs=1)


@pytest.mark.parametrize(("prominence", "counts"), [(2.0, False), (4.0, True)])
def test_a_ripple_below_a_third_of_the_range_is_no_peak(prominence, counts):
    angle = _zigzag(0, 10, 0, prominence, 0, 10, 0)
    assert len(_peaks(angle, "positive")) == 2 + counts
    assert len(_peaks(-angle, "negative")) == 2 + counts


def test_the_range_does_not_count_a_single_spike():
    angle = np.concatenate([_zigzag(*[0, 10] * 8, 0), np.zeros(600)])
    angle[-300] = 60.0
    assert len(_peaks(angle, "positive")) == 9


@pytest.mark.parametrize(("late_s", "pairs"), [(0.24, 2), (0.26, 0)])
def test_a_peak_a_quarter_of_a_second_later_is_another_one(late_s, pairs):
    reference = _zigzag(0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0)
    time_s = np.arange(len(reference)) / 1000.0
    late = np.interp(time_s - late_s, time_s, 0.5 * reference)
    peaks = peak_errors(Swing(time_s, reference, late))
    peaks = peaks[peaks["peak"] == "positive"]
    assert len(peaks) == pairs
    np.testing.assert_allclose(peaks["lag_s"], late_s)
    np.testing.assert_allclose(peaks["error_deg"], 5.0)


def test_one_peak_is_not_the_estimate_of_two():
    reference = _zigzag(0, 10, 0, 10, 0, corner_s=0.25)
    estimate = _zigzag(0, 0, 10, 0, 0, corner_s=0.25)
    peaks = peak_errors(Swing(np.arange(len(reference)) / 1000.0, reference, estimate))
    assert (peaks["peak"] == "positive").sum() == 1


def test_trials_without_results_are_listed(make_walk):
    walks = [make_walk(methods=("giof",)), make_walk(subject="S2", methods=("giof",), duration_s=3)]
    trials, peaks, refused = swing_results(walks, {"S1": "Males"})
    assert trials["group"].tolist() == ["Males"]
    assert set(peaks["peak"]) == {"positive", "negative"}
    assert len(refused) == 1
    assert "S2" in refused[0]
    trials, peaks, refused = swing_results([])
    assert trials.empty
    assert peaks.empty
