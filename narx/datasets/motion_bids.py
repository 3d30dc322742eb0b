"""Recordings in Motion-BIDS format.

Jeung et al.: Motion-BIDS, an extension to the brain imaging data structure to organize motion
data for reproducible research, Scientific Data 11:716, 2024. For every raw ``*_motion.tsv`` with
the entities sub, task and tracksys (and ses, acq, run), the channels of type GYRO and ACCEL (x, y,
z) and ORNT (quat_w, quat_x, quat_y, quat_z) are read by tracked point, together with sampling rate,
latencies, status and acquisition times.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from narx.datasets.base import TrialSource
from narx.datasets.bids_files import entities_of, raw_motion_files, start_offsets_s
from narx.datasets.bids_system import QUATERNION, VECTOR, TrackingSystem
from narx.datasets.segment_names import segment_of
from narx.datasets.synchronised import Tracked, synchronised
from narx.errors import RecordingError, UserError
from narx.files import safe_name, sha256_of
from narx.recordings.plausibility import admit
from narx.recordings.rest import first_rest_s
from narx.recordings.stamps import checked_rate_hz
from narx.recordings.trial import ImuRecording, Trial
from narx.settings import FilePath, Name, SamplingRate, checked

_MIN_REST_S = 0.5


class MotionBids(TrialSource):
    """A Motion-BIDS folder: subject, task (with session and acquisition) and run.

    Parameters
    ----------
    root : path-like
        The data set's folder.
    sampling_rate_hz : float, optional
        Rate of the uniform clock; None keeps that of the first inertial system.
    segments : mapping of str to str, optional
        Tracked point to segment (``{"imu_l_thigh": "thigh_left"}``). Other points are named after
        the body part and side in their name, or keep their name.
    """

    name: ClassVar[str] = "motion_bids"

    @checked
    def __init__(
        self,
        *,
        root: FilePath | None = None,
        sampling_rate_hz: SamplingRate | None = None,
        segments: dict[Name, Name] | None = None,
    ) -> None:
        self._root = root
        self._sampling_rate_hz = (
            None
            if sampling_rate_hz is None
            else checked_rate_hz(sampling_rate_hz, "motion_bids: sampling_rate_hz")
        )
        self._segments = dict(segments or {})

    def _recordings(self) -> dict[tuple[str, str, str], list[Path]]:
        """Files of all tracking systems by subject, condition and trial."""
        if self._root is None:
            raise UserError("motion_bids: no folder given; set data_root=DIR for DIR/motion_bids")
        folder = Path(self._root).expanduser()
        if not folder.is_dir():
            raise UserError(f"motion_bids: no folder '{folder}'")
        found: dict[tuple[str, str, str], list[Path]] = {}
        for path in raw_motion_files(folder):
            entities = entities_of(path.name)
            parts = [entities.get(key, "") for key in ("task", "ses", "acq")]
            condition = "_".join(part for part in parts if part)
            found.setdefault((entities["sub"], condition, entities.get("run", "1")), []).append(
                path
            )
        if not found:
            raise RecordingError(
                f"{folder}: no trial; expected files like sub-01_task-walk_tracksys-imu_motion.tsv"
            )
        return found

    def _list_trials(self) -> pd.DataFrame:
        return pd.DataFrame(list(self._recordings()), columns=["subject", "condition", "trial"])

    def _segments_of(self, points: list[str]) -> dict[str, str]:
        """Segment of each tracked point; points that would share a segment keep their own names."""
        named = {point: self._segments.get(point) or segment_of(point) for point in points}
        names = list(named.values())
        return {
            point: segment if names.count(segment) == 1 else safe_name(point)
            for point, segment in named.items()
        }

    def _inertial(
        self, systems: list[TrackingSystem], notes: list[str]
    ) -> tuple[dict[str, ImuRecording], float | None]:
        """Sensors by segment, and the rate of the first system with one."""
        inertial: dict[str, ImuRecording] = {}
        native_hz = None
        for system in systems:
            for point, segment in self._segments_of(system.points("GYRO")).items():
                if segment in inertial:
                    notes.append(f"{system.path.name}: a second sensor on '{segment}', not read")
                    continue
                gyroscope = system.table(point, "GYRO", VECTOR)
                if gyroscope is None:
                    notes.append(f"{system.path.name}: no gyroscope x, y, z of '{point}', not read")
                    continue
                accelerometer = system.table(point, "ACCEL", VECTOR)
                if accelerometer is None:
                    notes.append(f"{system.path.name}: no accelerometer x, y, z of '{point}'")
                    accelerometer = np.full_like(gyroscope, np.nan)
                    accelerometer[:, 0] = gyroscope[:, 0]
                where = f"{system.path}: '{point}'"
                sensor = admit(
                    ImuRecording(segment, gyroscope[:, 0], gyroscope[:, 1:], accelerometer[:, 1:]),
                    where,
                )
                notes += [f"{where}: {note}" for note in sensor.notes]
                inertial[segment] = sensor
                native_hz = native_hz or system.rate_hz
        return inertial, native_hz

    def _optical(
        self, systems: list[TrackingSystem], wanted: Mapping[str, object], notes: list[str]
    ) -> dict[str, Tracked]:
        """Times and orientations of the segments that have a sensor."""
        optical: dict[str, Tracked] = {}
        for system in systems:
            for point, segment in self._segments_of(system.points("ORNT")).items():
                table = system.table(point, "ORNT", QUATERNION)
                if table is None:
                    notes.append(
                        f"{system.path.name}: the orientation (ORNT) of '{point}' is given by "
                        "Euler angles or in part, not as a quaternion: not read"
                    )
                elif segment in wanted and segment not in optical:
                    optical[segment] = table[:, 0], table[:, 1:]
        return optical

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        files = self._recordings()[subject, condition, trial]
        systems, notes = _opened(files, Path(str(self._root)).expanduser())
        inertial, native_hz = self._inertial(systems, notes)
        if native_hz is None:
            raise RecordingError(f"{files[0]}: no channel of type GYRO")
        optical = self._optical(systems, inertial, notes)
        rate_hz = self._sampling_rate_hz or native_hz
        aligned = synchronised(inertial, optical, rate_hz, str(files[0]))
        imus = aligned.imus
        rest_s = first_rest_s([imu.gyroscope_rad_s for imu in imus.values()], rate_hz)
        rested = rest_s >= _MIN_REST_S
        start_s = float(next(iter(imus.values())).time_s[0])
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=rate_hz,
            imus=imus,
            reference=aligned.reference,
            still_s=((start_s, start_s + rest_s),) if rested else (),
            starts_in_calibration_posture=rested,
            clock_offset_s=aligned.clock_offset_s,
            notes=(
                *notes,
                *aligned.notes,
                "the rest at the start is assumed to be the calibration posture",
            ),
            sources={system.path.name: sha256_of(system.path) for system in systems},
        )


def _opened(files: list[Path], root: Path) -> tuple[list[TrackingSystem], list[str]]:
    """Open all systems of a trial on one clock, which starts with the first of them.

    A system that cannot be read is left out, as long as another one has a gyroscope.
    """
    begins_s = start_offsets_s(files, root)
    systems: list[TrackingSystem] = []
    errors: list[RecordingError] = []
    for path in files:
        try:
            systems.append(TrackingSystem(path, root, begins_s.get(path, 0.0)))
        except RecordingError as error:
            errors.append(error)
    if errors and not any(system.points("GYRO") for system in systems):
        raise errors[0]
    notes = [f"not read: {error}" for error in errors]
    notes += [note for system in systems for note in system.notes]
    late = {path.name: begin for path, begin in begins_s.items() if begin}
    notes += [f"{name} begins {begin:g} s later, by acq_time" for name, begin in late.items()]
    return systems, notes
