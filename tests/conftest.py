"""Motions whose angles, angular rates and specific force are known exactly."""

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from narx.kinematics.segment_angles import orientation_from_angles
from narx.method import SegmentSignals
from narx.recordings.trial import GRAVITY_M_S2

# modules that tests share; behind the package, since this folder has a folder narx as well, which
# processes that start with this path would import
sys.path += [str(Path(__file__).parents[1]), str(Path(__file__).parent)]


@dataclass(frozen=True)
class Motion:
    """Signals of an ideal sensor at the centre of rotation, and the angles behind them."""

    signals: SegmentSignals
    angles_rad: np.ndarray

    @property
    def time_s(self):
        return np.arange(self.signals.n_samples) / self.signals.sampling_rate_hz

    def changed(self, **changes):
        return Motion(replace(self.signals, **changes), self.angles_rad)


def _smooth_step(t, begin, end):
    u = np.clip(((t - begin) / (end - begin)).real, 0.0, 1.0)
    # beyond the ends the slope is zero, so a complex step may be dropped there
    u = u + 1j * np.where((u > 0) & (u < 1), (t / (end - begin)).imag, 0.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


STRIDE_HZ = 0.9


def _strides(t):
    """Thigh-like: 40 degrees of flexion range, less about the other axes, zero mean."""
    p = 2.0 * np.pi * STRIDE_HZ * t
    return np.stack(
        [
            0.35 * np.sin(p) + 0.06 * np.sin(2 * p + 0.4) - 0.06 * np.sin(0.4),
            0.08 * np.sin(p + 0.2) + 0.03 * np.sin(2 * p),
            0.06 * np.sin(p + 0.3) + 0.02 * np.sin(3 * p),
        ],
        axis=-1,
    )


def _still(t):
    return np.zeros((len(t), 3), dtype=complex)


def _walking(t):
    return _strides(t) * _smooth_step(t, 0.0, 1.5)[:, None]


def _stand_walk_stand(t):
    last = t[-1].real
    envelope = _smooth_step(t, 4.0, 5.0) * (1.0 - _smooth_step(t, last - 5.0, last - 4.0))
    return _strides(t) * envelope[:, None]


def _half_turn(t):
    """Walks, turns by 180 degrees between 20 and 23 s, walks on."""
    angles = _walking(t)
    angles[:, 2] += np.pi * _smooth_step(t, 20.0, 23.0)
    return angles


def _stand_turn_stand(t):
    """The same half turn between standing and standing."""
    angles = _stand_walk_stand(t)
    angles[:, 2] += np.pi * _smooth_step(t, 20.0, 23.0)
    return angles


def _tilted(t):
    return np.tile(np.array([0.3, -0.2, 0.0], dtype=complex), (len(t), 1))


KINDS = {
    "still": _still,
    "tilted": _tilted,
    "walking": _walking,
    "stand_walk_stand": _stand_walk_stand,
    "half_turn": _half_turn,
    "stand_turn_stand": _stand_turn_stand,
}


def make_motion(kind: str, sampling_rate_hz: float = 100.0, duration_s: float = 40.0) -> Motion:
    time = np.arange(round(duration_s * sampling_rate_hz) + 1) / sampling_rate_hz
    # complex-step differentiation is exact to rounding
    stepped = KINDS[kind](time + 1e-30j)
    angles, derivative = stepped.real, stepped.imag / 1e-30
    sagittal, frontal, _ = angles.T
    d_sagittal, d_frontal, d_heading = derivative.T
    rates = np.column_stack(
        [
            d_sagittal + np.sin(frontal) * d_heading,
            np.cos(sagittal) * d_frontal - np.sin(sagittal) * np.cos(frontal) * d_heading,
            np.sin(sagittal) * d_frontal + np.cos(sagittal) * np.cos(frontal) * d_heading,
        ]
    )
    orientation = Rotation.from_quat(orientation_from_angles(angles), scalar_first=True)
    force = orientation.inv().apply([0.0, 0.0, GRAVITY_M_S2])
    signals = SegmentSignals("thigh_right", sampling_rate_hz, rates, force, angles[0].copy())
    return Motion(signals, angles)


@pytest.fixture(scope="session", autouse=True)
def _own_store_of_prepared_trials(tmp_path_factory: pytest.TempPathFactory) -> None:
    os.environ["NARX_PREPARED"] = str(tmp_path_factory.mktemp("prepared"))


@pytest.fixture(scope="session")
def motion() -> Callable[..., Motion]:
    """Build a motion: ``motion(kind, sampling_rate_hz=100.0, duration_s=40.0)``."""
    return make_motion


@pytest.fixture(scope="session")
def data_root() -> Path:
    """Folder with a folder per source; skips without it."""
    root = os.environ.get("NARX_DATA_ROOT")
    if root is None or not Path(root).is_dir():
        pytest.skip("no recordings: set NARX_DATA_ROOT")
    return Path(root)
