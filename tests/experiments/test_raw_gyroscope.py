import numpy as np
import pytest

from narx.calibration.calibrate import calibrate
from narx.datasets.simulated_gait import SimulatedGait
from narx.experiments.raw_gyroscope import with_static_bias
from narx.kinematics.segment_angles import axis_rates, mirror_angular_rate
from narx.recordings.trial import side_of


@pytest.mark.parametrize("segment", ["thigh_right", "thigh_left"])
def test_rates_are_the_sensors_own(segment):
    (trial,) = SimulatedGait(
        subjects=["V1"], protocol="stand_walk_stand", conditions=["normal"], sensor="mpu6150",
        trials_per_condition=1, sampling_rate_hz=100, segments=[segment],
    )  # fmt: skip
    segment_of = calibrate(trial)[segment]
    raw = with_static_bias(segment_of)
    rate = segment_of.sensor_to_anatomical.apply(trial.imus[segment].gyroscope_rad_s)
    if side_of(segment) == "left":
        rate = mirror_angular_rate(rate)
    np.testing.assert_allclose(raw.signals.axis_rates_rad_s, axis_rates(rate), atol=1e-12)
    # the removed bias is not zero: an MPU's is degrees per second
    removed = raw.signals.axis_rates_rad_s - segment_of.signals.axis_rates_rad_s
    assert np.rad2deg(np.linalg.norm(removed[0])) > 1.0
    assert raw.notes[-1] == "static gyroscope bias restored"
