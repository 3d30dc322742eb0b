"""Standard deviations that are measured on training trials."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from narx.calibration import calibrate
from narx.datasets import SimulatedGait
from narx.training import TrialReader
from narx.training.trial_reader import Stretch


@pytest.fixture(scope="module")
def stretch():
    source = SimulatedGait(treadmill_duration_s=40.0, sampling_rate_hz=100.0)
    trial = source.load("S1", "normal", "1")
    segments = calibrate(trial)
    return Stretch(trial, segments={name: segments[name] for name in ("thigh_right", "shank_left")})


class Erring:
    """The reference with normal errors of known size; predicts a constant standard deviation."""

    def __init__(self, stretch, error_rad, std_rad):
        self._references = {
            id(segment.signals): segment.reference_angles_rad
            for segment in stretch.segments.values()
        }
        self._error_rad, self._std_rad = np.array(error_rad), np.array(std_rad)

    def reference(self, signals):
        return self._references[id(signals)]

    def run(self, signals):
        reference = self.reference(signals)
        error = np.random.default_rng(0).normal(size=reference.shape) * self._error_rad
        # what is skipped at the start must not count
        error[:300] = 100.0
        return SimpleNamespace(
            angles_rad=reference - error, std_rad=np.broadcast_to(self._std_rad, reference.shape)
        )


def test_a_factor_makes_the_bands_hold_their_shares(stretch):
    method = Erring(stretch, error_rad=(0.03, 0.01, 0.02), std_rad=(0.01, 0.01, 0.04))
    scale = TrialReader(skip_s=5.0).std_scale(method, [stretch])
    assert scale == pytest.approx((3.0, 1.0, 0.5), rel=0.04)


def test_normal_errors_of_the_predicted_size_need_no_factor(stretch):
    """Quantiles of the normal distribution, in any order."""
    n = len(stretch.trial.time_s)
    quantiles = norm.ppf((np.arange(n - 500) + 0.5) / (n - 500))
    errors = np.r_[np.zeros(500), np.random.default_rng(0).permutation(quantiles)]
    method = Erring(stretch, error_rad=(0.0, 0.0, 0.0), std_rad=(0.01, 0.02, 0.03))

    def run(signals):
        found = Erring.run(method, signals)
        own = np.array([0.01, 0.02, 0.03]) * errors[:, None]
        return SimpleNamespace(angles_rad=method.reference(signals) - own, std_rad=found.std_rad)

    scale = TrialReader(skip_s=5.0).std_scale(SimpleNamespace(run=run), [stretch])
    assert scale == pytest.approx((1.0,) * 3, abs=0.006)


def test_an_axis_without_angles_gets_the_mean_factor(stretch):
    method = Erring(stretch, error_rad=(0.03, 0.01, np.nan), std_rad=(0.01, 0.01, 0.01))
    sagittal, frontal, transverse = TrialReader(skip_s=5.0).std_scale(method, [stretch])
    assert transverse == pytest.approx((sagittal + frontal) / 2)
    assert TrialReader().std_scale(method, []) == (1.0, 1.0, 1.0)


def test_errors_are_root_mean_squares_before_and_after_the_start_up(stretch):
    """Half of the samples err by 0.03 rad and half by 0.01 after the start-up, by 0.2 within it."""

    def run(signals):
        reference = next(
            segment.reference_angles_rad
            for segment in stretch.segments.values()
            if segment.signals is signals
        )
        n = len(reference)
        starting = np.arange(n) < 1500
        error = np.where(starting, 0.2, np.where(np.arange(n) % 2, 0.03, 0.01))
        error[:300] = 100.0
        return SimpleNamespace(angles_rad=reference - error[:, None], starting=starting)

    after, start = TrialReader(skip_s=5.0).error_stds(SimpleNamespace(run=run), [stretch])
    assert start == pytest.approx((0.2,) * 3)
    assert after == pytest.approx((np.sqrt((0.03**2 + 0.01**2) / 2),) * 3, rel=1e-3)


@pytest.mark.parametrize(
    ("start_s", "stop_s", "expected"),
    [(0.0, 10.0, (500, 1000)), (7.0, 10.0, (700, 1000)), (0.0, np.inf, (500, 4000))],
)
def test_a_part_begins_after_what_is_skipped_and_ends_before_its_stop(
    stretch, start_s, stop_s, expected
):
    part = Stretch(stretch.trial, start_s, stop_s, stretch.segments)
    first, stop = expected
    for one in TrialReader(skip_s=5.0).sequences([part]):
        whole = stretch.segments[one.name.rsplit("/", 1)[1]].signals.axis_rates_rad_s
        np.testing.assert_array_equal(one.signals.axis_rates_rad_s, whole[first:stop])


def test_a_part_counts_from_the_first_sample_of_a_clock_that_is_not_zero(stretch):
    whole = stretch.trial
    late = SimpleNamespace(name=whole.name, dataset=whole.dataset, time_s=whole.time_s + 1000.0)
    parts = [Stretch(trial, 7.0, 10.0, stretch.segments) for trial in (whole, late)]
    one, other = (TrialReader(skip_s=5.0).sequences([part]) for part in parts)
    assert [sequence.signals.n_samples for sequence in other] == [300, 300]
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.target_rad, b.target_rad)
