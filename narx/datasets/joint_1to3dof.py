"""Two IMUs across a joint with one, two or three degrees of freedom.

Weygers, Kok: Drift-free inertial sensor-based joint kinematics for long-term arbitrary
movements, IEEE Sensors Journal 20(14), 2020; the files are ``data/`` of
https://github.com/daniel-om-weber/dfjimu.
"""

import re
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from narx.datasets.base import TrialSource
from narx.datasets.download import checked_sources, find_recordings
from narx.datasets.mat_file import numeric_field, read_mat
from narx.datasets.tracked_sensor import RawSensor, align_sensors
from narx.errors import RecordingError
from narx.recordings.rest import first_rest_s
from narx.recordings.stamps import checked_rate_hz
from narx.recordings.trial import Trial
from narx.settings import FilePath, SamplingRate, checked
from narx.types import FloatArray

_SEGMENTS = ("imu1", "imu2")
_FILE = re.compile(r"data_(?P<joint>[123]D)_(?P<number>\d+)\.mat")
_SENSOR_COLUMNS, _REFERENCE_COLUMNS = 12, 8


class Joint1To3Dof(TrialSource):
    """Trials of two IMUs: condition is the joint (1D, 2D, 3D), trial its number.

    Parameters
    ----------
    root : path-like, optional
        Folder with ``data_<joint>_<number>.mat`` as published; without it, the published files
        are downloaded once.
    sampling_rate_hz : float, optional
        Rate of the uniform clock; None keeps the recording's 50 Hz.
    """

    name: ClassVar[str] = "joint_1to3dof"

    @checked
    def __init__(
        self, *, root: FilePath | None = None, sampling_rate_hz: SamplingRate | None = None
    ) -> None:
        self._root = root
        self._sampling_rate_hz = sampling_rate_hz

    def _list_trials(self) -> pd.DataFrame:
        folder = find_recordings(self.name, self._root)
        rows = [
            ("device", match["joint"], match["number"])
            for path in sorted(folder.glob("data_*.mat"))
            if (match := _FILE.fullmatch(path.name))
        ]
        if not rows:
            raise RecordingError(f"{folder}: no trial; expected files like data_1D_01.mat")
        return pd.DataFrame(rows, columns=["subject", "condition", "trial"])

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        root = find_recordings(self.name, self._root)
        path = root / f"data_{condition}_{trial}.mat"
        variables = read_mat(path)
        native_hz = checked_rate_hz(
            numeric_field(path, variables, "data.rate"), f"{path}: data.rate"
        )
        sensors = _columns(path, variables, "data.sensorData", _SENSOR_COLUMNS)
        reference = _columns(path, variables, "data.ref", _REFERENCE_COLUMNS)
        if len(sensors) != len(reference):
            raise RecordingError(
                f"{path}: sensorData has {len(sensors)} rows, ref has {len(reference)}"
            )
        time = np.arange(len(sensors)) / native_hz
        gyroscopes = {s: sensors[:, 6 * k + 3 : 6 * k + 6] for k, s in enumerate(_SEGMENTS)}
        rest_s = first_rest_s(list(gyroscopes.values()), native_hz)
        if rest_s == 0.0:
            raise RecordingError(f"{path}: the sensors are not at rest at the start")
        resting = time <= rest_s
        rate_hz = float(self._sampling_rate_hz or native_hz)
        aligned = align_sensors(
            {
                segment: RawSensor(
                    np.column_stack([time, gyroscopes[segment]]),
                    np.column_stack([time, sensors[:, 6 * k : 6 * k + 3]]),
                    gyroscopes[segment][resting].mean(axis=0),
                    time,
                    reference[:, 4 * k : 4 * k + 4],
                )
                for k, segment in enumerate(_SEGMENTS)
            },
            rate_hz,
            max_gap_s=1.5 / native_hz,
            max_optical_gap_s=1.5 / native_hz,
            where=str(path),
        )
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=rate_hz,
            imus=aligned.imus,
            reference=aligned.reference,
            still_s=((0.0, rest_s),),
            starts_in_calibration_posture=True,
            clock_offset_s=aligned.clock_offset_s,
            notes=(*aligned.notes, "the rest at the start is the calibration posture"),
            sources=checked_sources(self.name, root, [path]),
        )


def _columns(path: Path, variables: dict[str, object], name: str, count: int) -> FloatArray:
    values = numeric_field(path, variables, name)
    if values.ndim != 2 or values.shape[1] < count:
        raise RecordingError(
            f"{path}: {name} has shape {values.shape}, expected (N, {count} or more)"
        )
    return values[:, :count]
