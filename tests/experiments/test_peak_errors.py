import numpy as np
import pytest

from narx.errors import MethodNotApplicableError
from narx.experiments.peak_errors import peak_errors, swing, swing_results


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
