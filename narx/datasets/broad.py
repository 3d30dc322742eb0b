"""BROAD: one rigid IMU moved by hand, slow and fast, rotating and translating; not gait.

Laidig, Caruso, Cereatti, Seel: BROAD, a benchmark for robust inertial orientation estimation,
Data 6(7):72, 2021; the files are ``data_mat/`` of https://github.com/dlaidig/broad.
"""

import re
from typing import ClassVar

import numpy as np
import pandas as pd

from narx.datasets.base import TrialSource
from narx.datasets.download import checked_sources, find_recordings
from narx.datasets.mat_file import numeric_field, read_mat
from narx.datasets.tracked_sensor import RawSensor, align_sensors
from narx.errors import RecordingError
from narx.recordings.stamps import checked_rate_hz
from narx.recordings.trial import Trial
from narx.settings import FilePath, SamplingRate, checked

_SEGMENT = "imu"
_FILE = re.compile(r"(?P<number>\d\d)_(?P<condition>.+)\.mat")


class Broad(TrialSource):
    """BROAD trials: condition is the motion, trial the number in the benchmark.

    Parameters
    ----------
    root : path-like, optional
        Folder with ``<number>_<motion>.mat`` as published; without it, seven of the published
        files are downloaded once. Every such file is a trial.
    sampling_rate_hz : float, optional
        Rate of the uniform clock; None keeps the recording's 285.7 Hz.
    """

    name: ClassVar[str] = "broad"

    @checked
    def __init__(
        self, *, root: FilePath | None = None, sampling_rate_hz: SamplingRate | None = None
    ) -> None:
        self._root = root
        self._sampling_rate_hz = sampling_rate_hz

    def _list_trials(self) -> pd.DataFrame:
        folder = find_recordings(self.name, self._root)
        rows = [
            ("device", match["condition"], match["number"])
            for path in sorted(folder.glob("*.mat"))
            if (match := _FILE.fullmatch(path.name))
        ]
        if not rows:
            raise RecordingError(
                f"{folder}: no trial; expected files like 01_undisturbed_slow_rotation_A.mat"
            )
        return pd.DataFrame(rows, columns=["subject", "condition", "trial"])

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        root = find_recordings(self.name, self._root)
        path = root / f"{trial}_{condition}.mat"
        variables = read_mat(path)
        native_hz = checked_rate_hz(
            numeric_field(path, variables, "sampling_rate"), f"{path}: sampling_rate"
        )
        columns = {"imu_gyr": 3, "imu_acc": 3, "opt_quat": 4}
        tables = {name: numeric_field(path, variables, name) for name in columns}
        movement = np.atleast_1d(numeric_field(path, variables, "movement")) > 0.5
        for name, width in columns.items():
            if tables[name].shape != (len(movement), width):
                raise RecordingError(
                    f"{path}: {name} has shape {tables[name].shape}, expected "
                    f"({len(movement)}, {width})"
                )
        if movement[0] or not movement.any():
            raise RecordingError(f"{path}: movement does not begin with a rest")
        time = np.arange(len(movement)) / native_hz
        rest_s = float(time[int(np.argmax(movement)) - 1])
        gyroscope = tables["imu_gyr"]
        rate_hz = float(self._sampling_rate_hz or native_hz)
        aligned = align_sensors(
            {
                _SEGMENT: RawSensor(
                    np.column_stack([time, gyroscope]),
                    np.column_stack([time, tables["imu_acc"]]),
                    gyroscope[time <= rest_s].mean(axis=0),
                    time,
                    tables["opt_quat"],
                )
            },
            rate_hz,
            max_gap_s=1.5 / native_hz,
            max_optical_gap_s=1.5 / native_hz,
            where=str(path),
        )
        clock = aligned.imus[_SEGMENT].time_s
        nearest = np.clip(np.round(clock * native_hz).astype(int), 0, len(movement) - 1)
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
            scored=np.asarray(movement[nearest]),
            clock_offset_s=aligned.clock_offset_s,
            notes=(
                *aligned.notes,
                "the rest at the start is the calibration posture; the movement phase is scored",
            ),
            sources=checked_sources(self.name, root, [path]),
        )
