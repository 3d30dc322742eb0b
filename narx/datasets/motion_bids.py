"""Recordings in Motion-BIDS form.

Jeung et al.: Motion-BIDS, an extension to the brain imaging data structure to organize motion
data for reproducible research, Scientific Data 11:716, 2024. Read are, for every
``sub-<subject>[_ses-<>]_task-<task>[_acq-<>]_tracksys-<system>[_run-<>]_motion.tsv``, the channels
of type GYRO and ACCEL (x, y, z) and ORNT (quat_w, quat_x, quat_y, quat_z), by tracked point.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from narx.datasets.base import TrialSource
from narx.datasets.text_table import read_numbers
from narx.datasets.tracked_sensor import RawSensor, align_sensors, on_clock
from narx.errors import RecordingError, UserError
from narx.files import sha256_of
from narx.recordings.resampling import uniform_clock
from narx.recordings.rest import first_rest_s
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, ReferenceOrientation, Trial
from narx.types import FloatArray

_FILE = re.compile(
    r"sub-(?P<sub>[^_]+)(?:_ses-(?P<ses>[^_]+))?_task-(?P<task>[^_]+)(?:_acq-(?P<acq>[^_]+))?"
    r"_tracksys-(?P<system>[^_]+)(?:_run-(?P<run>[^_]+))?_motion\.tsv"
)
_VECTOR = ("x", "y", "z")
_QUATERNION = ("quat_w", "quat_x", "quat_y", "quat_z")
_UNITS = {
    "GYRO": {"rad/s": 1.0, "deg/s": np.pi / 180.0, "°/s": np.pi / 180.0},
    "ACCEL": {"m/s^2": 1.0, "m/s²": 1.0, "m/s2": 1.0, "g": GRAVITY_M_S2},
    "LATENCY": {"s": 1.0, "ms": 1e-3},
}
_BODY_PARTS = ("thigh", "shank", "pelvis", "foot")
_MAX_TILT_RAD = np.radians(15.0)
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
        Tracked point to segment (``{"imu_l_thigh": "thigh_left"}``). A point that is not in it
        is named after the body part and side that its own name holds, or keeps its name.
    """

    name: ClassVar[str] = "motion_bids"

    def __init__(
        self,
        *,
        root: str | Path | None = None,
        sampling_rate_hz: float | None = None,
        segments: Mapping[str, str] | None = None,
    ) -> None:
        self._root = root
        self._sampling_rate_hz = sampling_rate_hz
        self._segments = dict(segments or {})

    def _recordings(self) -> dict[tuple[str, str, str], list[Path]]:
        """Files of all tracking systems by subject, condition and trial."""
        if self._root is None:
            raise UserError("motion_bids: no folder given; set data_root=DIR for DIR/motion_bids")
        folder = Path(self._root).expanduser()
        if not folder.is_dir():
            raise UserError(f"motion_bids: no folder '{folder}'")
        found: dict[tuple[str, str, str], list[Path]] = {}
        for path in sorted(folder.rglob("*_motion.tsv")):
            if match := _FILE.fullmatch(path.name):
                parts = [match["task"], match["ses"], match["acq"]]
                condition = "_".join(part for part in parts if part)
                found.setdefault((match["sub"], condition, match["run"] or "1"), []).append(path)
        if not found:
            raise RecordingError(
                f"{folder}: no trial; expected files like sub-01_task-walk_tracksys-imu_motion.tsv"
            )
        return found

    def _list_trials(self) -> pd.DataFrame:
        return pd.DataFrame(list(self._recordings()), columns=["subject", "condition", "trial"])

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        files = self._recordings()[subject, condition, trial]
        systems = [_System(path) for path in files]
        inertial: dict[str, tuple[FloatArray, FloatArray]] = {}
        optical: dict[str, tuple[FloatArray, FloatArray]] = {}
        native_hz = None
        for system in systems:
            for point in system.points("GYRO"):
                segment = self._segments.get(point) or segment_of(point)
                if segment in inertial:
                    raise RecordingError(f"{system.path}: segment '{segment}' occurs twice")
                inertial[segment] = (
                    system.table(point, "GYRO", _VECTOR),
                    system.table(point, "ACCEL", _VECTOR),
                )
                native_hz = native_hz or system.rate_hz
            for point in system.points("ORNT"):
                segment = self._segments.get(point) or segment_of(point)
                table = system.table(point, "ORNT", _QUATERNION)
                optical[segment] = (table[:, 0], table[:, 1:])
        if native_hz is None:
            raise RecordingError(f"{files[0]}: no channel of type GYRO")
        rate_hz = float(self._sampling_rate_hz or native_hz)
        gap_s = 2.5 / native_hz
        rest_s = first_rest_s([gyroscope[:, 1:] for gyroscope, _ in inertial.values()], native_hz)
        imus: dict[str, ImuRecording]
        reference: dict[str, ReferenceOrientation] = {}
        offsets: dict[str, float] = {}
        notes: tuple[str, ...] = ()
        if inertial.keys() <= optical.keys():
            aligned = align_sensors(
                {
                    segment: RawSensor(gyroscope, accelerometer, np.zeros(3), *optical[segment])
                    for segment, (gyroscope, accelerometer) in inertial.items()
                },
                rate_hz,
                max_gap_s=gap_s,
                max_optical_gap_s=max(
                    2.5 * float(np.median(np.diff(time))) for time, _ in optical.values()
                ),
            )
            imus, reference = aligned.imus, aligned.reference
            offsets, notes = aligned.clock_offset_s, aligned.notes
            _check_upright(files[0], imus, reference)
        else:
            tables = [table for pair in inertial.values() for table in pair]
            clock = uniform_clock(
                max(table[0, 0] for table in tables), min(t[-1, 0] for t in tables), rate_hz
            )
            imus = {s: on_clock(s, *pair, clock, max_gap_s=gap_s) for s, pair in inertial.items()}
            notes = ("no reference: not every sensor's tracked point has an orientation (ORNT)",)
        rested = rest_s >= _MIN_REST_S
        start_s = float(next(iter(imus.values())).time_s[0])
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=rate_hz,
            imus=imus,
            reference=reference,
            still_s=((start_s, start_s + rest_s),) if rested else (),
            starts_in_calibration_posture=rested,
            clock_offset_s=offsets,
            notes=(*notes, "a rest at the start is taken for the calibration posture"),
            sources={system.path.name: sha256_of(system.path) for system in systems},
        )


class _System:
    """One tracking system's file with its channel table and sidecar."""

    def __init__(self, path: Path) -> None:
        self.path = path
        stem = path.name.removesuffix("_motion.tsv")
        sidecar = path.with_name(f"{stem}_motion.json")
        channels = path.with_name(f"{stem}_channels.tsv")
        try:
            self.rate_hz = float(json.loads(sidecar.read_text("utf-8"))["SamplingFrequency"])
        except FileNotFoundError:
            raise RecordingError(f"{sidecar}: no such file") from None
        except (KeyError, TypeError, ValueError) as error:
            raise RecordingError(
                f"{sidecar}: no number 'SamplingFrequency' ({type(error).__name__})"
            ) from None
        try:
            self._channels = pd.read_csv(channels, sep="\t", dtype=str, keep_default_na=False)
        except FileNotFoundError:
            raise RecordingError(f"{channels}: no such file") from None
        except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
            raise RecordingError(f"{channels}: not a table ({error})") from None
        needed = {"component", "type", "tracked_point", "units"} - set(self._channels)
        if needed:
            raise RecordingError(f"{channels}: no column '{sorted(needed)[0]}'")
        self._values = read_numbers(path, separator="\t", missing_allowed=True)
        if self._values.shape[1] != len(self._channels):
            raise RecordingError(
                f"{path}: {self._values.shape[1]} columns, but {channels.name} lists "
                f"{len(self._channels)} channels"
            )
        latency = self._channels.index[self._channels["type"].str.upper() == "LATENCY"]
        self._time_s = (
            self._column(latency[0], "LATENCY")
            if len(latency)
            else np.arange(len(self._values)) / self.rate_hz
        )

    def points(self, kind: str) -> list[str]:
        """Tracked points that have channels of a type."""
        of_kind = self._channels[self._channels["type"].str.upper() == kind]
        return list(dict.fromkeys(of_kind["tracked_point"]))

    def table(self, point: str, kind: str, components: tuple[str, ...]) -> FloatArray:
        """Time and the components of a tracked point, in SI; missing samples are NaN."""
        columns = [self._time_s]
        for component in components:
            found = self._channels.index[
                (self._channels["tracked_point"] == point)
                & (self._channels["type"].str.upper() == kind)
                & (self._channels["component"].str.lower() == component)
            ]
            if len(found) != 1:
                raise RecordingError(
                    f"{self.path}: {len(found)} channels {kind} {component} of '{point}', "
                    "expected one"
                )
            columns.append(self._column(found[0], kind))
        return np.column_stack(columns)

    def _column(self, channel: int, kind: str) -> FloatArray:
        values = self._values[:, channel]
        if kind not in _UNITS:
            return values
        unit = self._channels["units"][channel].strip()
        if unit not in _UNITS[kind]:
            raise RecordingError(
                f"{self.path}: channel {channel + 1} ({kind}) has unit '{unit}', expected "
                f"{' or '.join(_UNITS[kind])}"
            )
        return values * _UNITS[kind][unit]


def segment_of(tracked_point: str) -> str:
    """Guess the segment from the name of a tracked point.

    Parameters
    ----------
    tracked_point : str
        Such as ``LeftThigh``, ``shank_r`` or ``pelvis``.

    Returns
    -------
    str
        Body part and side where both are recognised (``thigh_left``), the body part alone where
        no side is, otherwise the name itself.
    """
    words = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", tracked_point).lower())
    part = next((p for p in _BODY_PARTS if any(p in word for word in words)), None)
    if part is None:
        return tracked_point
    joined = " ".join(words)
    for side in ("left", "right"):
        if side in joined or side[0] in words:
            return f"{part}_{side}"
    return part


def _check_upright(
    path: Path,
    imus: Mapping[str, ImuRecording],
    reference: Mapping[str, ReferenceOrientation],
) -> None:
    """Refuse a reference whose global z axis is not up: the average specific force tells."""
    for segment, one in reference.items():
        force = imus[segment].accelerometer_m_s2
        there = np.isfinite(one.quaternion_wxyz).all(axis=1) & np.isfinite(force).all(axis=1)
        rotation = Rotation.from_quat(one.quaternion_wxyz[there], scalar_first=True)
        mean = rotation.apply(force[there]).mean(axis=0)
        tilt = np.arccos(np.clip(mean[2] / np.linalg.norm(mean), -1.0, 1.0))
        if tilt > _MAX_TILT_RAD:
            raise RecordingError(
                f"{path}: the orientation of '{segment}' puts gravity {np.degrees(tilt):.0f} deg "
                "from z; expected a global frame with z up"
            )
