"""One person walking, turning and walking back, with IMUs on thighs and shanks, beside Vicon.

Sample of the neura-sparse01 data set (NeuRA, Sy et al., IEEE Trans. Biomed. Eng. 68(4), 2021);
the files are ``data/sample/`` of https://github.com/gait-tech/gaittoolbox.
"""

import re
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from narx.datasets.base import TrialSource
from narx.datasets.download import checked_sources, find_recordings
from narx.datasets.mat_file import numeric_field, read_mat
from narx.datasets.text_table import read_numbers
from narx.datasets.tracked_sensor import (
    on_clock,
    refuse_contradiction,
    refuse_tilted,
    turn_frame,
)
from narx.errors import RecordingError
from narx.gait.straight_walk import walk_before_turn_s
from narx.recordings.clock_alignment import estimate_clock_offset, estimate_misalignment
from narx.recordings.resampling import resample_quaternions, uniform_clock
from narx.recordings.rest import first_rest_s
from narx.recordings.trial import ReferenceOrientation, Trial
from narx.settings import FilePath, SamplingRate, checked
from narx.types import FloatArray

_SENSORS = {
    "thigh_right": "00B40C3C",
    "thigh_left": "00B40C45",
    "shank_right": "00B40C35",
    "shank_left": "00B40BA5",
}
_FILE = re.compile(r"(?P<subject>[^-]+)-Trial-(?P<condition>.+)-(?P<number>\d+)\.mat")
_COLUMNS = ("PacketCounter", "Gyr_X", "Gyr_Y", "Gyr_Z", "Acc_X", "Acc_Y", "Acc_Z")
_NATIVE_HZ = 100.0
_COUNTER_RANGE = 2**16
_MAX_GAP_S = 0.025
# averaging time: at 100 Hz, marker noise would mask the speed over a single interval
_ALIGNMENT_INTERVAL_S = 0.03
# What a rotation leaves unexplained, as a multiple of what a reflection leaves: 0.3 to 0.4 in this
# walk, 1.0 to 1.4 with axes exchanged or mirrored. Skin and cluster move against each other, so
# that less is explained than with a tracked sensor.
_MIRRORED = 0.7
# no laboratory is larger; two bones and a marker span a larger area
_FARTHEST_MM, _SMALLEST_AREA_M2 = 1e6, 1e-5


class NeuraSample(TrialSource):
    """Standing, walk, turn, walk, standing: subject, condition and number as in the file names.

    Parameters
    ----------
    root : path-like, optional
        Folder with ``rawimu`` and ``rawvicon`` as published; without it, the published files are
        downloaded once.
    sampling_rate_hz : float, optional
        Rate of the uniform clock; None keeps the recording's 100 Hz.
    """

    name: ClassVar[str] = "neura_sample"

    @checked
    def __init__(
        self, *, root: FilePath | None = None, sampling_rate_hz: SamplingRate | None = None
    ) -> None:
        self._root = root
        self._sampling_rate_hz = float(sampling_rate_hz or _NATIVE_HZ)

    def _list_trials(self) -> pd.DataFrame:
        folder = find_recordings(self.name, self._root)
        rows = [
            (match["subject"], match["condition"], match["number"])
            for path in sorted((folder / "rawvicon").glob("*.mat"))
            if (match := _FILE.fullmatch(path.name))
        ]
        if not rows:
            raise RecordingError(
                f"{folder}: no trial; expected files like rawvicon/S02-Trial-Walk-1.mat"
            )
        return pd.DataFrame(rows, columns=["subject", "condition", "trial"])

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        root = find_recordings(self.name, self._root)
        name = f"{subject}-Trial-{condition}-{trial}"
        optical_file = root / "rawvicon" / f"{name}.mat"
        sensor_files = {
            segment: root / "rawimu" / f"{name}-000_{number}.txt"
            for segment, number in _SENSORS.items()
        }
        tables = {segment: _read_sensor(file) for segment, file in sensor_files.items()}
        joints = _read_joints(optical_file)
        sources = checked_sources(self.name, root, [*sensor_files.values(), optical_file])
        frames = {segment: _segment_frame(segment, joints) for segment in _SENSORS}
        optical_time = np.arange(len(joints["RHJC"])) / _NATIVE_HZ
        rest_s = first_rest_s([table[:, 1:4] for table in tables.values()], _NATIVE_HZ)
        if rest_s < 1.0:
            raise RecordingError(f"{root}: {name} does not begin with a second of standing")

        offsets = {
            segment: _clock_offset(
                sensor_files[segment], table, rest_s, optical_time, frames[segment]
            )
            for segment, table in tables.items()
        }
        # one trigger, one clock; the shanks give the best estimate, since soft tissue moves the
        # thigh's markers
        offset = float(np.mean([v for s, v in offsets.items() if s.startswith("shank")]))
        optical_time = optical_time + offset
        times = [table[:, 0] for table in tables.values()] + [optical_time]
        clock = uniform_clock(
            max(time[0] for time in times),
            min(time[-1] for time in times),
            self._sampling_rate_hz,
            str(optical_file),
        )
        last_rest_s = first_rest_s([t[::-1, 1:4] for t in tables.values()], _NATIVE_HZ)
        end_s = float(clock[-1])
        recorded = Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=self._sampling_rate_hz,
            imus={
                segment: on_clock(
                    segment,
                    table[:, [0, 1, 2, 3]],
                    table[:, [0, 4, 5, 6]],
                    clock,
                    max_gap_s=_MAX_GAP_S,
                )
                for segment, table in tables.items()
            },
            reference={
                segment: ReferenceOrientation(
                    segment,
                    resample_quaternions(optical_time, frame, clock, max_gap_s=_MAX_GAP_S),
                    "anatomical",
                )
                for segment, frame in frames.items()
            },
            still_s=((0.0, rest_s), (end_s - last_rest_s, end_s)),
            straight=False,
            starts_in_calibration_posture=True,
            clock_offset_s=dict.fromkeys(_SENSORS, offset),
            notes=(
                "inertial clock behind the optical one by "
                + ", ".join(f"{1e3 * v:.1f} ms ({s})" for s, v in offsets.items())
                + f"; one trigger, so {1e3 * offset:.1f} ms (mean of the shanks) for all",
                "reference: z from joint centre to joint centre, y along the epicondyle (thigh) or "
                "malleolus (shank) marker and the joint centre beside it",
                "walking_s is the walk before the turn, from the gyroscopes",
            ),
            sources=sources,
        )
        for segment, table in tables.items():
            try:
                _refuse_contradiction(recorded, segment, table, optical_time, frames[segment])
            except RecordingError as error:
                raise RecordingError(f"{sensor_files[segment]}: {error}") from error
        return replace(recorded, walking_s=walk_before_turn_s(recorded, recorded.still_s[0]))


def _read_sensor(path: Path) -> FloatArray:
    """Read time in s, gyroscope in rad/s and accelerometer in m/s^2; lost packets become a gap."""
    table = read_numbers(path, separator=",", columns=_COLUMNS, comment="//", terminated=True)
    steps = np.diff(table[:, 0]) % _COUNTER_RANGE
    back = np.flatnonzero(steps > _COUNTER_RANGE // 2)
    if back.size:  # its wrap is a small step
        raise RecordingError(f"{path}: PacketCounter goes back after row {int(back[0]) + 1}")
    if not (steps > 0).all():
        raise RecordingError(f"{path}: PacketCounter repeats at row {int(np.argmin(steps)) + 1}")
    table[:, 0] = np.concatenate([[0.0], np.cumsum(steps)]) / _NATIVE_HZ
    return table


def _read_joints(path: Path) -> dict[str, FloatArray]:
    """Read joint centres and adjacent markers, m; NaN where missing."""
    variables = read_mat(path)
    joints = {}
    for side in "RL":
        for point in ("HJC", "KJC", "AJC", "KNE", "ANK"):
            values = numeric_field(path, variables, side + point)
            if values.ndim != 2 or values.shape[1] != 3:
                raise RecordingError(
                    f"{path}: {side + point} has shape {values.shape}, expected (N, 3)"
                )
            if np.nanmax(np.abs(values), initial=0.0) > _FARTHEST_MM:
                raise RecordingError(
                    f"{path}: {side + point} is {np.nanmax(np.abs(values)):.3g} mm from the "
                    f"origin, expected at most {_FARTHEST_MM:g}"
                )
            # Vicon writes a lost point as the origin
            lost = (values == 0.0).all(axis=1)
            joints[side + point] = np.where(lost[:, None], np.nan, values / 1000.0)
    lengths = {len(values) for values in joints.values()}
    if len(lengths) > 1:
        raise RecordingError(f"{path}: trajectories differ in length: {sorted(lengths)} frames")
    return joints


def _segment_frame(segment: str, joints: dict[str, FloatArray]) -> FloatArray:
    """Build x forward, y left, z up along the segment from points on it."""
    side = "R" if segment.endswith("right") else "L"
    upper, lower, lateral = ("HJC", "KJC", "KNE") if "thigh" in segment else ("KJC", "AJC", "ANK")
    z = joints[side + upper] - joints[side + lower]
    outwards = joints[side + lateral] - joints[side + lower]
    left = -outwards if side == "R" else outwards
    x = np.cross(left, z)
    # not where points coincide, or lie on a line
    valid = np.linalg.norm(x, axis=1) > _SMALLEST_AREA_M2
    quaternion = np.full((len(z), 4), np.nan)
    axes = np.stack([x, np.cross(z, x), z], axis=-1)[valid]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    quaternion[valid] = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    return quaternion


def _clock_offset(
    path: Path, table: FloatArray, rest_s: float, optical_time: FloatArray, frame: FloatArray
) -> float:
    bias = table[table[:, 0] <= rest_s, 1:4].mean(axis=0)
    try:
        offset, _ = estimate_clock_offset(
            table[:, 0],
            table[:, 1:4] - bias,
            optical_time,
            frame,
            max_offset_s=0.2,
            interval_s=_ALIGNMENT_INTERVAL_S,
        )
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error
    return offset


def _refuse_contradiction(
    trial: Trial, segment: str, table: FloatArray, optical_time: FloatArray, frame: FloatArray
) -> None:
    """Refuse a sensor that does not turn with the points on its segment, or whose z is not up."""
    found = estimate_misalignment(
        table[:, 0], table[:, 1:4], optical_time, frame, interval_s=_ALIGNMENT_INTERVAL_S
    )
    refuse_contradiction(segment, found, mirrored_factor=_MIRRORED)
    anatomical = trial.reference[segment].quaternion_wxyz
    in_sensor_frame = turn_frame(anatomical, found.body_to_sensor)
    refuse_tilted(trial.imus[segment], ReferenceOrientation(segment, in_sensor_frame, "sensor"))
