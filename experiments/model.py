"""A network and all that belongs to it, as one section of the configuration describes them."""

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
    """The section `model`: a network's design, how it is trained for and how it is run.

    Parameters
    ----------
    hidden, input_lags, output_lags, odd, coupled, normalisation, initial_state
        As `narx.training.NetworkDesign`.
    axis_scaling : {"training", "own"}
        As `narx.inference.NarxMethod`.
    start_up : StartUp
        How the trained network starts.
    washout_s : float, optional
        As `narx.inference.NarxMethod`, s; None leaves a lasting deviation.
    objective : Objective
        What training minimises.
    tracker : PostureTracker, optional
        Learns posture and bias as the network runs, instead of start-up and washout.
    """

    axis_scaling: AxisScaling = "training"
    start_up: StartUp = field(default_factory=StartUp)
    washout_s: PositiveSeconds | None = WASHOUT_S
    objective: Objective = field(default_factory=Objective)
    tracker: PostureTracker | None = None
