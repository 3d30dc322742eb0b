"""Sources of trials, and their division into training and test."""

from narx.datasets.base import TrialSource
from narx.datasets.broad import Broad
from narx.datasets.csv_recording import read_recording, write_recording
from narx.datasets.joint_1to3dof import Joint1To3Dof
from narx.datasets.motion_bids import MotionBids
from narx.datasets.neura_sample import NeuraSample
from narx.datasets.simulated_gait import SimulatedGait
from narx.datasets.smartphone_pocket import SmartphonePocket
from narx.datasets.splits import (
    Fold,
    TrialPart,
    everything,
    leave_one_out,
    one_window,
    within_trial,
)

__all__ = [
    "Broad",
    "Fold",
    "Joint1To3Dof",
    "MotionBids",
    "NeuraSample",
    "SimulatedGait",
    "SmartphonePocket",
    "TrialPart",
    "TrialSource",
    "everything",
    "leave_one_out",
    "one_window",
    "read_recording",
    "within_trial",
    "write_recording",
]
