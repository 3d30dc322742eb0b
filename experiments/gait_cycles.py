"""Number of gait cycles in a comparison."""

from dataclasses import dataclass

import numpy as np

from narx.errors import UserError
from narx.evaluation.comparison import Evaluated
from narx.gait.phases import gait_phases
from narx.kinematics.segment_angles import SAGITTAL
from narx.method import SegmentSignals
from narx.recordings.trial import Trial, side_of
from narx.types import FloatArray


@dataclass(frozen=True)
class GaitCycles:
    """Cycles of one leg in one trial.

    Parameters
    ----------
    compared : int
        Cycles from one foot contact to the next, within the scored part.
    complete : int
        Those in which no sample of the reference is missing.
    """

    compared: int
    complete: int


def foot_contacts_s(trial: Trial, segment: str, thigh: SegmentSignals) -> FloatArray:
    """Find the foot contacts of a leg.

    Parameters
    ----------
    trial : Trial
        Contains the foot contacts, if it is simulated.
    segment : str
        A segment or the knee of the leg.
    thigh : SegmentSignals
        Thigh of the same leg (or the segment itself), whose gyroscope gives the contacts if the
        trial does not contain them.

    Returns
    -------
    ndarray, shape (C,)
        Times from the first sample of the trial, s; empty where no walking is found.
    """
    contacts_s = trial.events.get(f"heel_strike_{side_of(segment)}")
    if contacts_s is not None:
        return np.asarray(contacts_s) - float(trial.time_s[0])
    try:
        found = gait_phases(thigh.axis_rates_rad_s[:, SAGITTAL], thigh.sampling_rate_hz)
    except UserError:
        return np.empty(0)
    return found.times_s["b"][np.isfinite(found.times_s["b"])]


def gait_cycles(trial: Trial, joint: Evaluated, thigh: SegmentSignals) -> GaitCycles:
    """Count the gait cycles of one leg.

    Parameters
    ----------
    trial : Trial
        The trial.
    joint : Evaluated
        A knee of that trial.
    thigh : SegmentSignals
        Thigh of the same leg, see `foot_contacts_s`.

    Returns
    -------
    GaitCycles
        Zero of both if no walking is found.
    """
    contacts_s = foot_contacts_s(trial, joint.segment, thigh)
    if not contacts_s.size:
        return GaitCycles(0, 0)
    edges = np.searchsorted(joint.time_s, contacts_s)
    edges = edges[edges < len(joint.time_s)]
    scored = _all_between(joint.scored, edges)
    there = _all_between(np.isfinite(joint.reference_rad[:, SAGITTAL]), edges)
    return GaitCycles(int(scored.sum()), int((scored & there).sum()))


def _all_between(flags: np.ndarray, edges: np.ndarray) -> np.ndarray:
    so_far = np.concatenate([[0], np.cumsum(flags)])
    return np.diff(so_far[edges]) == np.diff(edges)
