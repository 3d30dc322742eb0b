"""Sensors of one session, and what was tracked with them, as a trial's uniform recordings."""

from collections.abc import Mapping

import numpy as np

from narx.datasets.tracked_sensor import (
    AlignedSensors,
    RawSensor,
    align_sensors,
    on_clock,
)
from narx.datasets.tracking_faults import tracked_poses
from narx.errors import RecordingError
from narx.recordings.clock_alignment import estimate_clock_offset
from narx.recordings.resampling import resample_quaternions, uniform_clock
from narx.recordings.trial import ImuRecording, ReferenceOrientation
from narx.types import FloatArray

Tracked = tuple[FloatArray, FloatArray]

# intervals of a sensor, or of the optical system, that are interpolated across
_GAP_INTERVALS = 2.5


def synchronised(
    inertial: Mapping[str, ImuRecording],
    optical: Mapping[str, Tracked],
    sampling_rate_hz: float,
    where: str,
    *,
    anatomical: bool = False,
) -> AlignedSensors:
    """Bring sensors that share one clock, and their reference, onto a uniform one.

    Parameters
    ----------
    inertial : mapping of str to ImuRecording
        By segment, checked (`narx.recordings.plausibility.admit`), on one clock.
    optical : mapping of str to tuple of ndarray
        By segment: times, shape (K,), in s, and orientations w, x, y, z, shape (K, 4), that rotate
        from the tracked body to a global frame with z up; NaN where missing.
    sampling_rate_hz : float
        Rate of the uniform clock, Hz.
    where : str
        Name of the session, for messages.
    anatomical : bool
        Whether markers on the segment, not on the sensor, were tracked.

    Returns
    -------
    AlignedSensors
        Without a reference if not every sensor has one; a note says so.

    Raises
    ------
    RecordingError
        If the sensors have no time in common, sensor and reference did not record the same motion,
        or z of the reference is not up.
    """
    gap_s = _GAP_INTERVALS / max(1e-9, next(iter(inertial.values())).sampling_rate_hz)
    tables = {
        segment: (
            np.column_stack([one.time_s, one.gyroscope_rad_s]),
            np.column_stack([one.time_s, one.accelerometer_m_s2]),
        )
        for segment, one in inertial.items()
    }
    try:
        if inertial.keys() <= optical.keys() and not anatomical:
            return _aligned(tables, optical, sampling_rate_hz, gap_s)
        offset_s = 0.0
        notes: list[str] = []
        if inertial.keys() <= optical.keys():
            optical, lost = _whole(inertial, optical)
            offset_s, notes = _offset_s(inertial, optical)
            notes += lost
        times = [one.time_s for one in inertial.values()]
        clock = uniform_clock(
            max(time[0] for time in times), min(time[-1] for time in times), sampling_rate_hz
        )
    except RecordingError as error:
        raise RecordingError(f"{where}: {error}") from error
    imus = {s: on_clock(s, *pair, clock, max_gap_s=gap_s) for s, pair in tables.items()}
    if not notes:
        why = ": not every sensor has an orientation" if optical else ""
        return AlignedSensors(imus, {}, {}, (f"no reference{why}",))
    reference = {
        segment: ReferenceOrientation(
            segment,
            resample_quaternions(
                optical[segment][0] + offset_s,
                optical[segment][1],
                clock,
                max_gap_s=_GAP_INTERVALS * float(np.median(np.diff(optical[segment][0]))),
            ),
            "anatomical",
        )
        for segment in inertial
    }
    return AlignedSensors(imus, reference, dict.fromkeys(inertial, offset_s), tuple(notes))


def _whole(
    inertial: Mapping[str, ImuRecording], optical: Mapping[str, Tracked]
) -> tuple[dict[str, Tracked], list[str]]:
    """Poses without lost ones, which some systems write as zeros; notes on them."""
    kept: dict[str, Tracked] = {}
    notes: list[str] = []
    for segment in inertial:
        time_s, body = optical[segment]
        poses, lost = tracked_poses(segment, time_s, body)
        kept[segment] = time_s, poses
        notes += lost
    return kept, notes


def _offset_s(
    inertial: Mapping[str, ImuRecording], optical: Mapping[str, Tracked]
) -> tuple[float, list[str]]:
    """Mean lag of the inertial clock; only angular speeds enter, not the frame of the markers."""
    offsets, notes = [], []
    for segment, one in inertial.items():
        offset, agreement = estimate_clock_offset(
            one.time_s, one.gyroscope_rad_s, *optical[segment]
        )
        offsets.append(offset)
        notes.append(
            f"{segment}: inertial clock {offset * 1e3:.1f} ms behind the optical one "
            f"(correlation of angular speeds {agreement:.3f})"
        )
    shared = float(np.mean(offsets))
    if len(offsets) > 1:
        notes.append(f"one clock offset for all sensors, {shared * 1e3:.1f} ms")
    return shared, notes


def _aligned(
    tables: Mapping[str, tuple[FloatArray, FloatArray]],
    optical: Mapping[str, Tracked],
    rate_hz: float,
    max_gap_s: float,
) -> AlignedSensors:
    sensors = {
        segment: RawSensor(gyroscope, accelerometer, np.zeros(3), *optical[segment])
        for segment, (gyroscope, accelerometer) in tables.items()
    }
    frames = [optical[segment][0] for segment in tables]
    max_optical_gap_s = max(_GAP_INTERVALS * float(np.median(np.diff(time))) for time in frames)
    return align_sensors(sensors, rate_hz, max_gap_s=max_gap_s, max_optical_gap_s=max_optical_gap_s)
