"""Rates in degrees per second are detected in every Python function that takes rates."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import torch

from narx import SimulatedGait, Trainer, calibrate
from narx.kinematics.rate_unit import warn_of_degrees
from narx.method import SegmentSignals
from narx.network import Narx, Normalisation
from narx.training import LevenbergMarquardt
from narx.windows import TrainingSequence, from_arrays

TIME_S = np.arange(0.0, 10.0, 0.01)
ANGLES_RAD = 0.4 * np.sin(2 * np.pi * 0.9 * TIME_S)[:, None] * [1.0, 0.2, 0.1]
RATES_RAD_S = np.gradient(ANGLES_RAD, 0.01, axis=0)
# slow walking: a third of the rates of normal walking
SLOW_DEG_S = np.degrees(RATES_RAD_S) / 3.0
WORDS = "degrees per second"


def test_what_a_leg_does_passes_and_degrees_do_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for factor in (0.0, 0.2, 1.0, 6.0):  # standing, strolling, walking, sprinting
            warn_of_degrees(factor * RATES_RAD_S, "walk")
        spikes = RATES_RAD_S.copy()
        spikes[::500] = np.nan
        warn_of_degrees(spikes, "walk")
        warn_of_degrees(np.full((100, 3), np.nan), "walk")
        warn_of_degrees(np.empty((0, 3)), "walk")
    with pytest.warns(UserWarning, match=f"^walk: .*{WORDS}"):
        warn_of_degrees(SLOW_DEG_S, "walk")


def test_missing_samples_do_not_make_rates_smaller():
    """Eleven rad/s where there is a sample, in a fourth of the rows."""
    rates = np.full((400, 3), np.nan)
    rates[::4] = 11.0
    with pytest.warns(UserWarning, match="root mean square of 11 rad/s"):
        warn_of_degrees(rates, "walk")


def test_degrees_are_seen_amid_rest():
    """A tenth of the time at 40: root mean square 12.6, mean size 4."""
    rates = np.zeros((1000, 3))
    rates[:100] = 40.0
    with pytest.warns(UserWarning, match="root mean square of 12.6 rad/s"):
        warn_of_degrees(rates, "walk")


@pytest.mark.parametrize(("n", "every"), [(1999, 1), (2000, 2), (10_000, 10)])
def test_a_thousand_samples_or_more_are_read_from_all_of_a_recording(n, every):
    """Those that are read turn by 40 rad/s in the second half, the others by 1000."""
    rates = np.full((2, n, 3), 1000.0)
    rates[:, ::every] = 0.0
    rates[:, n // 2 :][:, (-(n // 2)) % every :: every] = 40.0
    with pytest.warns(UserWarning, match="root mean square of 28.3 rad/s"):
        warn_of_degrees(rates, "walk")


def test_a_network_warns():
    model = Narx(100.0, Normalisation(2.0, 0.5))
    with pytest.warns(UserWarning, match=WORDS):
        model(torch.from_numpy(np.degrees(RATES_RAD_S)))


def test_arrays_warn():
    with pytest.warns(UserWarning, match=f"rates_rad_s.*{WORDS}") as caught:
        from_arrays(np.degrees(RATES_RAD_S), ANGLES_RAD, 100.0)
    assert caught[0].filename == __file__  # the line of the user


@pytest.mark.filterwarnings("ignore:axis_rates")  # the network warns as well
def test_a_training_warns():
    quick = LevenbergMarquardt(restarts=1, iterations=1)
    signals = SegmentSignals("thigh", 100.0, np.degrees(RATES_RAD_S), np.zeros_like(RATES_RAD_S))
    with pytest.warns(UserWarning, match=f"training: walk.*{WORDS}"):
        Trainer(optimizer=quick).fit([TrainingSequence("walk", signals, ANGLES_RAD)])


def test_a_calibration_warns():
    trial = SimulatedGait(treadmill_duration_s=20.0, sampling_rate_hz=100.0).load(
        "S1", "normal", "1"
    )
    wrong = {
        name: replace(imu, gyroscope_rad_s=np.degrees(imu.gyroscope_rad_s))
        for name, imu in trial.imus.items()
    }
    with pytest.warns(UserWarning, match=WORDS):
        calibrate(replace(trial, imus=wrong), "sensor")
