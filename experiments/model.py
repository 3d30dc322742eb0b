"""The section `model` of the configuration: a network's design, training objective and use."""

from dataclasses import dataclass, field

from narx.inference.narx_method import AxisScaling
from narx.inference.start_up import StartUp
from narx.inference.tracker import PostureTracker
from narx.inference.washout import WASHOUT_S
from narx.settings import PositiveSeconds
from narx.training.design import NetworkDesign
from narx.training.objective import Objective


@dataclass(frozen=True)
class ModelSettings(NetworkDesign):
    """The section `model`: a network's design, its training objective and how it is run.

    Parameters
    ----------
    hidden, input_lags, output_lags, odd, coupled, normalisation, initial_state
        As `narx.training.NetworkDesign`.
    axis_scaling : {"training", "own"}
        As `narx.inference.NarxMethod`.
    start_up : StartUp
        How the trained network starts.
    washout_s : float, optional
        As `narx.inference.NarxMethod`, s; with None, a constant offset is not removed.
    objective : Objective
        Objective that training minimises.
    tracker : PostureTracker, optional
        Estimates posture and gyroscope bias while the network runs; replaces start-up and washout.
    """

    axis_scaling: AxisScaling = "training"
    start_up: StartUp = field(default_factory=StartUp)
    washout_s: PositiveSeconds | None = WASHOUT_S
    objective: Objective = field(default_factory=Objective)
    tracker: PostureTracker | None = None
