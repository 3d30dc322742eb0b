"""Smartphones in a trouser pocket or a hand during free walking, with an optical reference.

Michel, Genevès, Fourati, Layaïda: Attitude estimation for indoor navigation and augmented
reality with smartphones, Pervasive and Mobile Computing 46, 2018; the files are
``datasets/`` of https://github.com/tyrex-team/benchmarks-attitude-smartphones.
"""

import re
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from narx.datasets.base import INDEX_COLUMNS, TrialSource
from narx.datasets.download import checked_sources, find_recordings
from narx.datasets.mat_file import numeric_field, read_mat
from narx.datasets.text_table import read_numbers
from narx.datasets.tracked_sensor import RawSensor, align_sensors, on_clock
from narx.errors import RecordingError
from narx.recordings.input_file import regular_file
from narx.recordings.resampling import uniform_clock
from narx.recordings.stamps import checked_rate_hz
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, Trial
from narx.settings import FilePath, SamplingRate, checked
from narx.types import FloatArray

# still recordings, calib_gyr_<phone>, are in the same folder as the trials
_TRIAL_FOLDER = re.compile(
    r"(?!calib_)(?P<walker>[^_]+)_(?P<phone>[^_]+)_(?P<condition>[^_]+_(?P<motion>[^_]+))"
)
_SYSTEMS = ("android", "ios")
# the phones' longest regular interval is 21 ms, the optical system's 17 ms
_MAX_GAP_S = 0.05
_MAX_OPTICAL_GAP_S = 0.025
# largest deviation of a matrix times its transpose from the unit matrix
_ROTATION_TOLERANCE = 0.1


class SmartphonePocket(TrialSource):
    """Walks with a phone: subject is the walker, trial the phone, condition field and motion.

    In a pocket (a motion that ends in ``Pocket``) the phone is on the segment ``thigh``; which
    thigh, left or right, is not recorded. Any other motion (texting, phoning, swinging the phone
    in the hand) is a ``hand``, which has no swing to calibrate from: ``auto`` uses the sensor's
    frame.

    Parameters
    ----------
    root : path-like, optional
        Folder with ``android``, ``ios`` and ``qualisys`` as published; without it, the
        published files are downloaded once. Every folder ``<walker>_<phone>_<field>_<motion>``
        in it is a trial, including walkers added later. The field is ``NoDist`` or
        ``Dist`` (magnetically disturbed); ``<field>_<motion>`` is the condition, by which
        `select` chooses.
    sampling_rate_hz : float
        Rate of the uniform clock, Hz.
    """

    name: ClassVar[str] = "smartphone_pocket"

    @checked
    def __init__(
        self, *, root: FilePath | None = None, sampling_rate_hz: SamplingRate = 100.0
    ) -> None:
        self._root = root
        self._sampling_rate_hz = float(sampling_rate_hz)

    def _list_trials(self) -> pd.DataFrame:
        folder = find_recordings(self.name, self._root)
        rows = [
            (match["walker"], match["condition"], match["phone"], match["phone"], match["motion"])
            for system in _SYSTEMS
            for path in sorted((folder / system).glob("*"))
            if path.is_dir() and (match := _TRIAL_FOLDER.fullmatch(path.name))
        ]
        if not rows:
            raise RecordingError(
                f"{folder}: no trial; expected folders like "
                "android/<walker>_<phone>_NoDist_FrontPocket"
            )
        index = pd.DataFrame(rows, columns=[*INDEX_COLUMNS, "device", "motion"])
        return index.sort_values(["subject", "condition", "trial"])

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        root = find_recordings(self.name, self._root)
        name = f"{subject}_{trial}_{condition}"
        segment = "thigh" if condition.endswith("Pocket") else "hand"
        system = next(s for s in _SYSTEMS if (root / s / name).is_dir())
        phone = root / system / name
        gyroscope, accelerometer, files = _read_phone(phone, ios=system == "ios")
        still, still_files = self._still_recording(
            root / system, trial, segment, ios=system == "ios"
        )
        bias = still.gyroscope_rad_s.mean(axis=0)
        optical_file = root / "qualisys" / f"{name}.mat"
        optical_time, body = _read_rigid_body(optical_file)
        alignment_file = phone / "timeAlignment.txt"
        alignment = read_numbers(alignment_file, columns=1)[0, 0]
        gyroscope[:, 0] += alignment
        accelerometer[:, 0] += alignment

        aligned = align_sensors(
            {segment: RawSensor(gyroscope, accelerometer, bias, optical_time, body)},
            self._sampling_rate_hz,
            max_gap_s=_MAX_GAP_S,
            max_optical_gap_s=_MAX_OPTICAL_GAP_S,
            where=f"{phone}, {optical_file}",
        )
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=self._sampling_rate_hz,
            imus=aligned.imus,
            reference=aligned.reference,
            calibration={"still": {segment: still}},
            clock_offset_s=aligned.clock_offset_s,
            notes=(
                "clocks aligned by timeAlignment.txt, then by angular speed",
                *aligned.notes,
                f"resampled to {self._sampling_rate_hz:g} Hz, optical gaps not interpolated",
            ),
            sources=checked_sources(self.name, root, [*files, optical_file], own=still_files),
        )

    def _still_recording(
        self, folder: Path, phone: str, segment: str, *, ios: bool
    ) -> tuple[ImuRecording, list[Path]]:
        """Read the still recording of a phone, for the gyroscope's bias."""
        candidates = sorted(folder.glob(f"calib_gyr_{phone}*"))
        if not candidates:
            raise RecordingError(
                f"{folder}: no folder 'calib_gyr_{phone}*', the still recording that the "
                "gyroscope's bias is taken from"
            )
        gyroscope, accelerometer, files = _read_phone(candidates[0], ios=ios)
        clock = uniform_clock(
            max(gyroscope[0, 0], accelerometer[0, 0]),
            min(gyroscope[-1, 0], accelerometer[-1, 0]),
            self._sampling_rate_hz,
            str(candidates[0]),
        )
        still = on_clock(segment, gyroscope, accelerometer, clock, max_gap_s=_MAX_GAP_S)
        return still, files


def _read_phone(folder: Path, *, ios: bool) -> tuple[FloatArray, FloatArray, list[Path]]:
    """Read time, x, y, z of gyroscope (rad/s) and accelerometer (m/s^2) in SI."""
    files = [folder / "gyroscope.txt", folder / "accelerometer.txt"]
    gyroscope, accelerometer = (read_numbers(file, columns=4, terminated=True) for file in files)
    for file, table in zip(files, (gyroscope, accelerometer), strict=True):
        backwards = np.flatnonzero(np.diff(table[:, 0]) <= 0)
        if backwards.size:
            raise RecordingError(
                f"{file}: time does not increase from row {backwards[0] + 1} to the next"
            )
    if ios:
        description = folder / "description.txt"
        start = _boot_time_s(description)
        gyroscope[:, 0] -= start
        accelerometer[:, 0] -= start
        # iOS reports gravity in g; the specific force has the opposite sign
        accelerometer[:, 1:] *= -GRAVITY_M_S2
        files.append(description)
    return gyroscope, accelerometer, files


def _boot_time_s(path: Path) -> float:
    try:
        text = regular_file(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: not UTF-8 text (byte {error.start})") from None
    match = re.search(r"^BootTime\s*=\s*(\d+(?:\.\d+)?)\s*$", text, re.MULTILINE)
    if match is None:
        raise RecordingError(f"{path}: no line 'BootTime = <seconds>'")
    return float(match[1])


def _read_rigid_body(path: Path) -> tuple[FloatArray, FloatArray]:
    """Read frame times in s and body-to-lab quaternions, NaN where the body was lost."""
    variables = read_mat(path)
    if len(variables) != 1:
        raise RecordingError(
            f"{path}: found {len(variables)} variables, expected one QTM measurement"
        )
    measurement = next(iter(variables))
    rate_hz = checked_rate_hz(
        numeric_field(path, variables, f"{measurement}.FrameRate"), f"{path}: FrameRate"
    )
    rotations = numeric_field(path, variables, f"{measurement}.RigidBodies.Rotations")
    if rotations.ndim != 2 or rotations.shape[0] != 9:
        raise RecordingError(
            f"{path}: RigidBodies.Rotations has shape {rotations.shape}, expected (9, frames) of "
            "one rigid body"
        )
    matrices = rotations.T.reshape(-1, 3, 3).transpose(0, 2, 1)  # stored column by column
    quaternion = np.full((len(matrices), 4), np.nan)
    valid = np.isfinite(matrices).all(axis=(1, 2)) & matrices.any(axis=(1, 2))
    # bounded, since squares of large numbers overflow
    bounded = np.clip(matrices[valid], -2.0, 2.0)
    deviation = np.abs(bounded @ bounded.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    wrong = np.flatnonzero((deviation > _ROTATION_TOLERANCE) | (np.linalg.det(bounded) < 0.0))
    if wrong.size:
        raise RecordingError(
            f"{path}: RigidBodies.Rotations of frame {np.flatnonzero(valid)[wrong[0]] + 1} is not "
            "a rotation matrix (damaged?)"
        )
    if valid.any():
        quaternion[valid] = Rotation.from_matrix(matrices[valid]).as_quat(scalar_first=True)
    return np.arange(len(matrices)) / rate_hz, quaternion
