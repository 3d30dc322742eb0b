"""Simulated walking with known ground truth: the built-in data set, which needs no download."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

import numpy as np
import pandas as pd
from pydantic import Field
from scipy.spatial.transform import Rotation

from narx.datasets.base import TrialSource
from narx.errors import UserError
from narx.recordings.trial import GRAVITY_M_S2, ImuRecording, ReferenceOrientation, Trial
from narx.settings import (
    Count,
    Names,
    PositiveSeconds,
    SamplingRate,
    Seconds,
    Seed,
    checked,
)
from narx.settings.values import LONGEST_S
from narx.simulation.attachment import Attachment, carried
from narx.simulation.body import TABLE_1, Body, body_of, subjects_of
from narx.simulation.functional_movements import PARTS, calibration_angles, duration_s
from narx.simulation.gait_timing import GaitTiming, overground_timing, treadmill_timing
from narx.simulation.markers import track
from narx.simulation.pauses import Pauses
from narx.simulation.random_numbers import stream
from narx.simulation.recorder import MOTION_RATE_HZ, Recorder
from narx.simulation.running import SPEED_KM_H as RUNNING_KM_H
from narx.simulation.sensor import sensor_model
from narx.simulation.session import ErrorSource, Session, draw_session, leave_out
from narx.simulation.size import check_size, longest_walk_s
from narx.simulation.skeleton import SEGMENTS, SkeletonMotion, move
from narx.simulation.true_motion import TrueMotion
from narx.simulation.turns import Turns
from narx.simulation.walker import WalkingPattern, walking_pattern
from narx.simulation.walking import VARIATION_CHANNELS, walk

LEGS = ("thigh_right", "shank_right", "thigh_left", "shank_left")

# Tham et al. (2020), section III: mean and standard deviation over the subjects
SPEEDS_KM_H = {"slow": (2.6, 0.2), "normal": (3.3, 0.2), "fast": (4.3, 0.3)}
# Han et al. (2020) give no speed over ground; this is the usual speed of adults (Bohannon, Age
# Ageing 26:15, 1997)
OVERGROUND_SPEED_KM_H = {"normal": (4.5, 0.3), "abnormal": (3.6, 0.3)}

TREADMILL_STAND_S = 4.0
TREADMILL_RISE_S = 4.0
TreadmillDuration = Annotated[float, Field(gt=TREADMILL_STAND_S + TREADMILL_RISE_S, le=LONGEST_S)]

Angle = Annotated[float, Field(ge=0, le=180)]

Protocol = Literal["treadmill", "stand_walk_stand"]


class SimulatedGait(TrialSource):
    """Simulated walkers with IMUs on thighs and shanks and an optical reference.

    Parameters
    ----------
    subjects : iterable of str, optional
        ``S1`` ... ``S5`` have the height and mass of Table 1 of Tham et al. (2020); ``V1``,
        ``V2``, ... are drawn at random; ``drawn30`` stands for thirty of these.
    protocol : {"treadmill", "stand_walk_stand"}, optional
        Treadmill: one trial each at ``slow``, ``normal`` and ``fast``, which begins with short
        standing before the belt starts. Stand-walk-stand: some trials each of ``normal`` and
        ``abnormal`` (legs swung outwards) over ground, with standing before and after, as in Han et
        al. (2020).
    conditions : iterable of str, optional
        Conditions of the protocol to simulate; None is all of them but ``running``, which the
        treadmill has as well.
    trials_per_condition : int, optional
        Repetitions; None is 1 on the treadmill and 3 over ground.
    treadmill_duration_s : float, optional
        Length of a treadmill trial, including standing.
    pauses_s : tuple of tuple of (float, float), optional
        Pauses on the treadmill, s, from the last full step to the next one.
    sits : bool, optional
        Sit down in the pauses instead of standing.
    turns_s : tuple of tuple of (float, float), optional
        Begin and end of turns, s: the walker of the treadmill protocol then walks over ground.
    turn_deg : float, optional
        Angle of a turn, the first one to the left, the next one to the right.
    handling_s : float, optional
        Every sensor is in a hand for that long at first, and the recording longer by as much.
    slips_s : tuple of float, optional
        Times at which every sensor slips on its segment, s.
    slip_deg : float, optional
        Angle of a slip.
    stand_s : tuple of (float, float), optional
        Shortest and longest standing before and after walking over ground.
    steps : tuple of (int, int), optional
        Fewest and most steps over ground.
    sampling_rate_hz : float, optional
        Rate of IMUs and reference.
    sensor : {"physilog", "mpu6150"}, optional
        Error model of the IMUs.
    mounting : {"random", "strapped"}, optional
        Orientation of the sensor on the segment: arbitrary, or within some 10 degrees of the
        nominal one.
    segments : iterable of str, optional
        Segments with an IMU: of ``pelvis``, ``thigh_right``, ``shank_right``, ``thigh_left``,
        ``shank_left``.
    ideal : bool, optional
        No errors: exact sensors, no soft tissue, the bones' orientation as reference. The mounting
        of the sensors is unchanged.
    without : iterable of str, optional
        Sources of error to leave out, all others unchanged (`ErrorSource` of
        `narx.simulation.session`).
    seed : int, optional
        Every random number is determined by it and the names of subject, condition and trial, so
        that a trial does not depend on which others are generated.

    Raises
    ------
    UserError
        If a name or number is not one of these.
    """

    name: ClassVar[str] = "simulated_gait"

    @checked
    def __init__(
        self,
        *,
        subjects: Names = tuple(TABLE_1),
        protocol: Protocol = "treadmill",
        conditions: Names | None = None,
        trials_per_condition: Count | None = None,
        treadmill_duration_s: TreadmillDuration = 300.0,
        pauses_s: tuple[tuple[float, float], ...] = (),
        sits: bool = False,
        turns_s: tuple[tuple[float, float], ...] = (),
        turn_deg: Angle = 180.0,
        handling_s: Seconds = 0.0,
        slips_s: tuple[float, ...] = (),
        slip_deg: Angle = 20.0,
        stand_s: tuple[PositiveSeconds, PositiveSeconds] = (3.0, 5.0),
        steps: tuple[Count, Count] = (3, 5),
        sampling_rate_hz: SamplingRate = 500.0,
        sensor: Literal["physilog", "mpu6150"] = "physilog",
        mounting: Literal["random", "strapped"] = "random",
        segments: Names = LEGS,
        ideal: bool = False,
        without: tuple[ErrorSource, ...] = (),
        seed: Seed = 0,
    ) -> None:
        subjects = subjects_of(subjects)
        self.seed = seed
        self.protocol, on_treadmill = protocol, protocol == "treadmill"
        usual = SPEEDS_KM_H if on_treadmill else OVERGROUND_SPEED_KM_H
        self.conditions = tuple(usual if conditions is None else conditions)
        self._speeds_km_h = {**usual, "running": RUNNING_KM_H} if on_treadmill else usual
        _check_names("condition", self.conditions, self._speeds_km_h)
        self.segments = segments
        _check_names("segment", self.segments, SEGMENTS)
        self.mounting = mounting
        self.sensor = sensor_model(sensor)
        if trials_per_condition is None:
            trials_per_condition = 1 if on_treadmill else 3
        for key, (least, most) in {"stand_s": stand_s, "steps": steps}.items():
            if least > most:
                raise UserError(
                    f"simulated_gait: {key}=[{least:g}, {most:g}], expected [shortest, longest]"
                )
        self.trials_per_condition = trials_per_condition
        self.treadmill_duration_s = treadmill_duration_s
        walk_s = (
            handling_s + TREADMILL_STAND_S + TREADMILL_RISE_S, handling_s + treadmill_duration_s
        )  # fmt: skip
        self._pauses, self._turns = Pauses(pauses_s, sits), Turns(turns_s, turn_deg)
        self._pauses.check(protocol, *walk_s)
        self._turns.check(protocol, *walk_s)
        self._attachment = Attachment(handling_s, slips_s, slip_deg)
        self._attachment.check(protocol, *walk_s)
        self.stand_s, self.steps = stand_s, steps
        self.sampling_rate_hz = sampling_rate_hz
        self.ideal = ideal
        check_size(
            len(subjects) * len(self.conditions) * trials_per_condition,
            handling_s + (treadmill_duration_s if on_treadmill else longest_walk_s(stand_s, steps)),
            max(sampling_rate_hz, MOTION_RATE_HZ),
        )
        self.without = frozenset(without)
        for triad, source in {
            "gyroscope": "gyroscope_bias",
            "accelerometer": "accelerometer",
        }.items():
            if source in self.without:
                steady = getattr(self.sensor, triad).without_drift()
                self.sensor = replace(self.sensor, **{triad: steady})
        self._recorder = Recorder(sampling_rate_hz, self.sensor, ideal, seed)
        self._bodies = {subject: body_of(subject, self.seed) for subject in subjects}
        self._calibrations: dict[str, Mapping[str, Mapping[str, ImuRecording]]] = {}

    def _list_trials(self) -> pd.DataFrame:
        on_treadmill = self.protocol == "treadmill"
        duration_s = self.treadmill_duration_s + self._attachment.handling_s
        rows = [
            (
                subject,
                condition,
                str(trial),
                3.6 * self._speed_m_s(subject, condition),
                duration_s if on_treadmill else np.nan,
            )
            for subject in self._bodies
            for condition in self.conditions
            for trial in range(1, self.trials_per_condition + 1)
        ]
        columns = ["subject", "condition", "trial", "speed_km_h", "duration_s"]
        return pd.DataFrame(rows, columns=columns)

    def _load(self, subject: str, condition: str, trial: str) -> Trial:
        motion, timing, session = self._motion(subject, condition, trial)
        keep = self._recorder.kept(motion.time_s)
        names = (subject, condition, trial)
        imus, reference = {}, {}
        for segment in self.segments:
            moved = self._moved(segment, motion, names)
            imus[segment] = self._recorder.record(segment, motion, session, names, moved)
            if self.ideal:
                wxyz = motion.orientations[segment][keep].as_quat(scalar_first=True)
            else:
                rng = stream(self.seed, *names, segment, "markers")
                wxyz = track(session.markers[segment], motion, segment, keep, rng)
            if moved is not None:
                wxyz = carried(wxyz, moved[keep])
            reference[segment] = ReferenceOrientation(segment, wxyz, "anatomical")
        end_s = float(next(iter(imus.values())).time_s[-1])
        handling_s = self._attachment.handling_s
        still = ((handling_s, timing.start_s), (timing.end_s, end_s))
        return Trial(
            dataset=self.name,
            subject=subject,
            condition=condition,
            trial=trial,
            sampling_rate_hz=self.sampling_rate_hz,
            imus=imus,
            reference=reference,
            calibration=self._calibration(subject),
            still_s=tuple(part for part in still if part[1] - part[0] > 0.5),
            straight=not self._turns,
            starts_in_calibration_posture=handling_s == 0.0,
            walking_s=(timing.start_s, min(timing.end_s, end_s)),
            events=timing.events,
            notes=("simulated; reference relative to the calibration posture",),
        )

    def truth(self, subject: str, condition: str, trial: str) -> TrueMotion:
        """Return the true motion of a trial.

        Parameters
        ----------
        subject, condition, trial : str
            Names as in the index.

        Returns
        -------
        TrueMotion
            Motion without errors of sensors or markers; the sensors' orientation includes the
            motion of the tissue under them.

        Raises
        ------
        UserError
            If there is no such trial.
        """
        self.select(subject, condition, trial)
        motion, _, session = self._motion(subject, condition, trial)
        keep = self._recorder.kept(motion.time_s)
        names = (subject, condition, trial)
        sensors = {
            s: self._recorder.orientation(s, motion, session, self._moved(s, motion, names))
            for s in self.segments
        }
        return TrueMotion(
            motion.time_s[keep],
            {joint: angles[keep] for joint, angles in motion.joint_angles.items()},
            {s: r[keep].as_quat(scalar_first=True) for s, r in motion.orientations.items()},
            {s: r[keep].as_quat(scalar_first=True) for s, r in sensors.items()},
            {s: motion.position(s, session.mountings[s].offset_m)[keep] for s in self.segments},
            self._speed_m_s(subject, condition),
        )

    def _speed_m_s(self, subject: str, condition: str) -> float:
        mean, spread = self._speeds_km_h[condition]
        # one number per person: a fast walker is fast in every condition
        return (mean + spread * float(stream(self.seed, subject, "speed").normal())) / 3.6

    def _motion(
        self, subject: str, condition: str, trial: str
    ) -> tuple[SkeletonMotion, GaitTiming, Session]:
        """Move the walker."""
        body = self._bodies[subject]
        pattern = walking_pattern(
            subject, body, self._speed_m_s(subject, condition), self.seed,
            swings_outwards=condition == "abnormal", runs=condition == "running",
        )  # fmt: skip
        rng = stream(self.seed, subject, condition, trial, "timing")
        timing, length_s = self._timing(pattern, rng)
        time_s, rate_hz = self._recorder.clock_s(length_s)
        rng = stream(self.seed, subject, condition, trial, "sway")
        travels = self.protocol != "treadmill" or bool(self._turns)
        motion = walk(pattern, timing, body, time_s, rate_hz, rng, travels)
        if self._turns:
            motion = self._turns.turned(motion, pattern.speed_m_s)
        return motion, timing, self._session(subject, body)

    def _timing(
        self, pattern: WalkingPattern, rng: np.random.Generator
    ) -> tuple[GaitTiming, float]:
        """Gait timing and length of the trial."""
        feet = (pattern.stride_s, pattern.toe_off, pattern.left_lag)
        if self.protocol == "treadmill":
            length_s = self.treadmill_duration_s + self._attachment.handling_s
            timing = treadmill_timing(
                rng,
                *feet,
                TREADMILL_STAND_S + self._attachment.handling_s,
                TREADMILL_RISE_S,
                length_s,
                VARIATION_CHANNELS,
            )
            pauses = self._pauses
            events = {name: pauses.without(times) for name, times in timing.events.items()}
            return replace(timing, pauses=pauses, events=events), length_s
        before, after = rng.uniform(*self.stand_s, size=2)
        before += self._attachment.handling_s
        n_steps = int(rng.integers(self.steps[0], self.steps[1] + 1))
        timing = overground_timing(rng, *feet, before, n_steps, after, VARIATION_CHANNELS)
        return timing, timing.end_s + after

    def _session(self, subject: str, body: Body) -> Session:
        drawn = draw_session(self.seed, subject, body, self.sensor, self.mounting, self.segments)
        return leave_out(drawn, self.without)

    def _moved(
        self, segment: str, motion: SkeletonMotion, names: tuple[str, ...]
    ) -> Rotation | None:
        """Rotation of a sensor relative to its segment."""
        if not self._attachment:
            return None
        rng = stream(self.seed, *names, segment, "attachment")
        return self._attachment.rotation(rng, motion.time_s)

    def _calibration(self, subject: str) -> Mapping[str, Mapping[str, ImuRecording]]:
        """Calibration movements of a subject's session, shared by all trials of it."""
        if subject not in self._calibrations:
            body = self._bodies[subject]
            session = self._session(subject, body)
            parts = {}
            for part in PARTS:
                time_s, rate_hz = self._recorder.clock_s(duration_s(part))
                if part == "still":
                    # flat on a table; the rotation of the earth is below the resolution of the
                    # gyroscopes
                    rest = np.zeros((len(time_s), 3))
                    force = np.tile([0.0, 0.0, GRAVITY_M_S2], (len(time_s), 1))
                    parts[part] = {
                        segment: self._recorder.measured(
                            segment, rest, force, time_s, session, (subject, "calibration", part)
                        )
                        for segment in self.segments
                    }
                    continue
                rng = stream(self.seed, subject, "calibration", part)
                exact = "movements" in self.without
                motion = move(time_s, rate_hz, calibration_angles(part, time_s, rng, exact), body)
                side = part.rpartition("_")[2]
                parts[part] = {
                    segment: self._recorder.record(
                        segment, motion, session, (subject, "calibration", part)
                    )
                    for segment in self.segments
                    if part == "standing" or segment.endswith(side)
                }
            # cached for one subject at a time, as trials are ordered by subject
            self._calibrations = {subject: parts}
        return self._calibrations[subject]


def _check_names(what: str, names: Iterable[str], known: Iterable[str]) -> None:
    known = tuple(known)
    for name in names:
        if name not in known:
            raise UserError(f"simulated_gait: no {what} '{name}'; known are {', '.join(known)}")
