"""A walk with known angles, as recorded at the right thigh, and the file formats that hold it."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.recordings.trial import GRAVITY_M_S2, ImuRecording

STAND_S, STRIDE_HZ = 4.0, 0.9
GYROSCOPE = tuple(f"gyroscope_{axis}_rad_s" for axis in "xyz")
ACCELEROMETER = tuple(f"accelerometer_{axis}_m_s2" for axis in "xyz")


def true_angles_rad(time_s):
    """Sagittal, frontal and transverse angle: standing, then strides about a flexed posture."""
    ramp = np.clip(time_s - STAND_S, 0.0, 1.0)
    ramp = ramp**2 * (3.0 - 2.0 * ramp)
    phase = 2.0 * np.pi * STRIDE_HZ * (time_s - STAND_S)
    sagittal = 18 * np.sin(phase) + 5 * np.sin(2 * phase + 0.9) + 1.5 * np.sin(3 * phase + 0.4) + 6
    frontal = 4 * np.sin(phase + 1.2) + np.sin(2 * phase)
    transverse = 5 * np.sin(phase + 2.5)
    return np.radians(np.column_stack([sagittal, frontal, transverse]) * ramp[:, None])


def _orientation(time_s):
    sagittal, frontal, transverse = true_angles_rad(time_s).T
    return Rotation.from_euler("ZXY", np.column_stack([transverse, -frontal, -sagittal]))


@dataclass(frozen=True)
class Walk:
    """Signals at given times; `error_sd_deg` compares an estimate with the truth."""

    time_s: np.ndarray
    gyroscope_rad_s: np.ndarray
    accelerometer_m_s2: np.ndarray

    def recording(self, **changes):
        parts = {
            "time_s": self.time_s,
            "gyroscope_rad_s": self.gyroscope_rad_s,
            "accelerometer_m_s2": np.full_like(self.gyroscope_rad_s, np.nan),
        }
        return ImuRecording("imu", **(parts | changes))

    def columns(self, accelerometer=False):
        columns = {"time_s": self.time_s}
        columns |= dict(zip(GYROSCOPE, self.gyroscope_rad_s.T, strict=True))
        if accelerometer:
            columns |= dict(zip(ACCELEROMETER, self.accelerometer_m_s2.T, strict=True))
        return columns

    @staticmethod
    def error_sd_deg(time_s, angles_rad, after_s=20.0):
        error = np.degrees(angles_rad - true_angles_rad(np.asarray(time_s)))[time_s >= after_s]
        return np.nanstd(error, axis=0)


@pytest.fixture(scope="session")
def device_walk():
    """Build a walk: ``device_walk(rate_hz=50.0, duration_s=30.0)``, or at given ``time_s``."""

    def build(rate_hz=50.0, duration_s=30.0, time_s=None):
        time = np.arange(round(duration_s * rate_hz)) / rate_hz if time_s is None else time_s
        step = 1e-4
        turned = _orientation(time - step).inv() * _orientation(time + step)
        force = _orientation(time).inv().apply([0.0, 0.0, GRAVITY_M_S2])
        return Walk(time, turned.as_rotvec() / (2 * step), force)

    return build


@pytest.fixture(scope="session")
def text_of():
    """Write columns as text: ``text_of(columns, separator=",", decimal=".", ...)``."""

    def write(columns, separator=",", decimal=".", header=True, end="\n", digits=5):
        lines = [separator.join(columns)] if header else []
        for row in zip(*columns.values(), strict=True):
            cells = [
                cell if isinstance(cell, str) else "" if np.isnan(cell) else f"{cell:.{digits}f}"
                for cell in row
            ]
            lines.append(separator.join(cell.replace(".", decimal) for cell in cells))
        return end.join(lines) + end

    return write


@pytest.fixture(scope="session")
def integrated():
    """Function of rates (N, 3), their sampling rate and the orientation at the second sample.

    It returns the orientations at samples 1 to N - 2, by fourth-order Magnus steps: mean rate by a
    four-point Adams formula, and the commutator term.
    """

    def integrate(rate_rad_s, sampling_rate_hz, start):
        step = 1.0 / sampling_rate_hz
        a, b, c, d = rate_rad_s[:-3], rate_rad_s[1:-2], rate_rad_s[2:-1], rate_rad_s[3:]
        turn = step * (-a + 13.0 * b + 13.0 * c - d) / 24.0 + step**2 / 12.0 * np.cross(b, c)
        found = [start]
        for one in Rotation.from_rotvec(turn):
            found.append(found[-1] * one)
        return Rotation.concatenate(found)

    return integrate
