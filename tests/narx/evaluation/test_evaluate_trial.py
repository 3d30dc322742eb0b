"""Trials are scored at the requested rate; methods estimate at their own rate."""

import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.datasets.splits import TrialPart
from narx.evaluation.comparison import rows
from narx.evaluation.trial import evaluate_trial
from narx.evaluation.workload import Workload
from narx.method import Estimate, OrientationMethod


@pytest.fixture(scope="module")
def walk():
    source = SimulatedGait(
        subjects=("S1",), conditions=("normal",), treadmill_duration_s=20, sampling_rate_hz=100
    )
    trial = next(iter(source))
    return trial, calibrate(trial)


class Counting(OrientationMethod):
    """The reference plus a slow error; records how many samples it was given."""

    def __init__(self, calibrated):
        self.calibrated, self.asked = calibrated, []

    def _estimate(self, signals):
        raise NotImplementedError

    def run(self, signals):
        self.asked.append(signals.n_samples)
        time_s = np.arange(signals.n_samples) * signals.interval_s
        error = 0.02 * np.sin(2 * np.pi * 0.7 * time_s)[:, None]
        angles = self.calibrated[signals.segment].reference_angles_rad - error
        return Estimate(angles, np.full((signals.n_samples, 3), 0.02))


def test_samples_are_picked_after_the_method_has_run(walk):
    trial, calibrated = walk
    part = TrialPart("s", trial.subject, trial.condition, trial.trial)
    found, scored = {}, {}
    for rate_hz in (None, 100.0, 25.0, 1000.0):
        method, workload = Counting(calibrated), Workload()
        found[rate_hz], refusals = evaluate_trial(
            trial, calibrated, {"m": method}, part, 5.0, workload, rate_hz
        )
        assert not refusals
        assert set(method.asked) == {trial.n_samples}
        assert workload.n_samples == {"m": trial.n_samples * len(calibrated)}
        scored[rate_hz] = [row for one in found[rate_hz] for row in rows(one)]
    assert scored[100.0] == scored[1000.0] == scored[None]
    for whole, picked in zip(found[None], found[25.0], strict=True):
        assert picked.sampling_rate_hz == 25.0
        np.testing.assert_array_equal(picked.time_s, whole.time_s[::4])
        np.testing.assert_array_equal(picked.reference_rad, whole.reference_rad[::4])
        np.testing.assert_array_equal(picked.estimates_rad["m"], whole.estimates_rad["m"][::4])
        np.testing.assert_array_equal(picked.std_rad["m"], whole.std_rad["m"][::4])
    for all_samples, fewer in zip(scored[None], scored[25.0], strict=True):
        assert fewer["n_samples"] == pytest.approx(all_samples["n_samples"] / 4, abs=1)
        assert fewer["rmse_deg"] == pytest.approx(all_samples["rmse_deg"], rel=0.01)
