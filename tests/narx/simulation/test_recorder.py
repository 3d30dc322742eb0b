"""The recorder: its clock, the delay and noise of its sensors, and whose errors are whose."""

import numpy as np
import pytest

from narx.recordings.trial import GRAVITY_M_S2
from narx.simulation.body import Body
from narx.simulation.recorder import Recorder
from narx.simulation.sensor import TriadErrors, sensor_model
from narx.simulation.session import ErrorSource, draw_session, leave_out

SENSOR = sensor_model("physilog")


def _session(**errors):
    session = draw_session(0, "S1", Body(1.7, 65.0), SENSOR, "random", ["thigh_right"])
    session = leave_out(session, ErrorSource.__args__)
    for triad, own in errors.items():
        getattr(session, triad)["thigh_right"] = own
    return session


def _measured(rate_hz, rate, force, session, length_s=20.0):
    recorder = Recorder(rate_hz, SENSOR, False, 0)
    time_s, _ = recorder.clock_s(length_s)
    signals = (np.stack([f(time_s)] * 3, axis=1) for f in (rate, force))
    return recorder.measured("thigh_right", *signals, time_s, session, ("test",))


@pytest.mark.parametrize(
    ("rate_hz", "motion_hz"), [(100.0, 500.0), (200.0, 600.0), (285.0, 570.0), (500.0, 500.0)]
)
def test_motion_is_computed_at_500_hz_or_more(rate_hz, motion_hz):
    """The smallest multiple of the sampling rate that is not below 500 Hz."""
    recorder = Recorder(rate_hz, SENSOR, True, 0)
    time_s, found_hz = recorder.clock_s(3.0)
    assert found_hz == motion_hz
    assert 1.0 / np.diff(time_s).mean() == pytest.approx(motion_hz)
    kept = time_s[recorder.kept(time_s)]
    np.testing.assert_allclose(kept, np.arange(3.0 * rate_hz) / rate_hz, atol=1e-12)
    assert time_s[0] < -1.0
    assert time_s[-1] > 4.0


@pytest.mark.parametrize(("rate_hz", "cutoff_hz"), [(500.0, 100.0), (100.0, 40.0)])
def test_a_reading_is_late_by_its_filter_only(rate_hz, cutoff_hz):
    """Butterworth of second order, by the bilinear transform of its rate of 500 Hz."""
    low_delay_s = np.sqrt(2.0) / (2.0 * 500.0 * np.tan(np.pi * cutoff_hz / 500.0))
    omega = 2.0 * np.pi * 2.0
    wave = _measured(
        rate_hz, lambda t: 3.0 * np.sin(omega * t), lambda t: 9.0 * np.cos(omega * t), _session()
    )
    for signal, first in ((wave.gyroscope_rad_s, np.sin), (wave.accelerometer_m_s2, np.cos)):
        ahead, behind = first(omega * wave.time_s), first(omega * wave.time_s - 0.5 * np.pi)
        (one, other), *_ = np.linalg.lstsq(np.stack([ahead, behind], axis=1), signal[:, 0])
        delay_s = np.arctan2(other, one) / omega
        assert delay_s == pytest.approx(low_delay_s, rel=0.02)


@pytest.mark.parametrize(("rate_hz", "cutoff_hz"), [(500.0, 100.0), (100.0, 40.0)])
def test_noise_is_that_of_the_band_which_the_filter_lets_pass(rate_hz, cutoff_hz):
    """0.05 deg/s and 350 ug per root of hertz; a Butterworth of second order has 1.11 cut-offs."""
    still = _measured(rate_hz, np.zeros_like, np.zeros_like, _session())
    band_hz = cutoff_hz * (0.25 * np.pi) / np.sin(0.25 * np.pi)
    noise = np.degrees(still.gyroscope_rad_s.std())
    assert noise == pytest.approx(0.05 * np.sqrt(band_hz), rel=0.1)
    noise_g = still.accelerometer_m_s2.std() / GRAVITY_M_S2
    assert noise_g == pytest.approx(350e-6 * np.sqrt(band_hz), rel=0.1)


def test_each_sensor_has_its_own_errors():
    gyroscopes = TriadErrors(np.eye(3), np.array([0.1, 0.2, 0.3]))
    accelerometers = TriadErrors(1.1 * np.eye(3), np.array([-1.0, 0.0, 2.0]))
    session = _session(gyroscopes=gyroscopes, accelerometers=accelerometers)
    still = _measured(100.0, np.zeros_like, lambda t: 0.0 * t + 5.0, session)
    np.testing.assert_allclose(still.gyroscope_rad_s.mean(axis=0), [0.1, 0.2, 0.3], atol=2e-3)
    np.testing.assert_allclose(still.accelerometer_m_s2.mean(axis=0), [4.5, 5.5, 7.5], atol=2e-2)
