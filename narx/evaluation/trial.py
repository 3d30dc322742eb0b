"""Run every method on the segments of a trial and compare the angles with the reference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from narx.calibration.calibrate import CalibratedSegment
from narx.datasets.splits import TrialPart
from narx.errors import MethodNotApplicableError
from narx.evaluation.comparison import Evaluated, knee
from narx.evaluation.workload import Workload
from narx.method import OrientationMethod
from narx.recordings.trial import Trial
from narx.settings import Positive, Seconds, checked

# the two segments of each joint
JOINTS = {
    "knee_right": ("thigh_right", "shank_right"),
    "knee_left": ("thigh_left", "shank_left"),
    "joint": ("imu1", "imu2"),
}


@dataclass(frozen=True)
class Refusal:
    """A method that is not applicable to a recording, and the reason.

    Parameters
    ----------
    trial, segment, method, reason : str
        Names, and the method's error message.
    """

    trial: str
    segment: str
    method: str
    reason: str


@checked
def evaluate_trial(
    trial: Trial,
    calibrated: Mapping[str, CalibratedSegment],
    methods: Mapping[str, OrientationMethod],
    part: TrialPart,
    skip_s: Seconds,
    workload: Workload | None = None,
    scored_rate_hz: Positive | None = None,
) -> tuple[list[Evaluated], list[Refusal]]:
    """Estimate the angles of every segment and joint of a trial by every method.

    Parameters
    ----------
    trial : Trial
        The whole trial; methods run on all of it.
    calibrated : mapping of str to CalibratedSegment
        Its segments, by name.
    methods : mapping of str to OrientationMethod
        By name.
    part : TrialPart
        Part that is scored.
    skip_s : float
        Time after the first sample that is not scored, because causal methods start at zero, s.
    workload : Workload, optional
        Receives the run time of each method.
    scored_rate_hz : float, optional
        Samples per second that are kept of what the methods estimate at the trial's own rate; every
        k-th with k rounded to the nearest whole number, at least 1. None keeps all. Neighbouring
        samples at 500 Hz hold the same error of a movement below 20 Hz.

    Returns
    -------
    evaluated : list of Evaluated
        Segments, then joints.
    refusals : list of Refusal
        Methods that were not applicable.

    Raises
    ------
    UserError
        If an argument has another type, `skip_s` is negative or `scored_rate_hz` not above zero.
    """
    since_start_s = trial.time_s - trial.time_s[0]
    scored = (since_start_s >= max(skip_s, part.start_s)) & (since_start_s < part.stop_s)
    if trial.scored is not None:
        scored &= trial.scored
    step = 1
    if scored_rate_hz is not None:
        step = max(1, round(trial.sampling_rate_hz / scored_rate_hz))
    kept = slice(None, None, step)
    workload = workload or Workload()
    segments: dict[str, Evaluated] = {}
    refusals: list[Refusal] = []
    for name, segment in calibrated.items():
        estimates, std = {}, {}
        for method_name, method in methods.items():
            try:
                with workload.of_method(method_name, segment.signals.n_samples):
                    estimate = method.run(segment.signals)
            except MethodNotApplicableError as error:
                refusals.append(Refusal(trial.name, name, method_name, str(error)))
                continue
            # copies, so that the long arrays are freed
            estimates[method_name] = estimate.angles_rad[kept].copy()
            if estimate.std_rad is not None:
                std[method_name] = estimate.std_rad[kept].copy()
        reference = segment.reference_angles_rad
        segments[name] = Evaluated(
            dataset=trial.dataset,
            subject=trial.subject,
            condition=trial.condition,
            trial=trial.trial,
            segment=name,
            sampling_rate_hz=trial.sampling_rate_hz / step,
            time_s=since_start_s[kept],
            reference_rad=(
                np.full((len(scored[kept]), 3), np.nan) if reference is None else reference[kept]
            ),
            estimates_rad=estimates,
            scored=scored[kept],
            std_rad=std,
        )
    return [*segments.values(), *_joints(segments, calibrated, kept)], refusals


def _joints(
    segments: Mapping[str, Evaluated], calibrated: Mapping[str, CalibratedSegment], kept: slice
) -> Sequence[Evaluated]:
    joints = []
    for joint, (proximal, distal) in JOINTS.items():
        if proximal in segments and distal in segments:
            reference = calibrated[proximal].reference_wxyz, calibrated[distal].reference_wxyz
            if reference[0] is None or reference[1] is None:
                continue
            both = reference[0][kept], reference[1][kept]
            angles = knee(segments[proximal], segments[distal], both)
            joints.append(replace(angles, segment=joint))
    return joints
