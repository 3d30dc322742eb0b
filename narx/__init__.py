"""Train and evaluate NARX orientation models: 3D segment and knee angles from a gyroscope."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from narx.calibration import calibrate
    from narx.datasets import SimulatedGait
    from narx.evaluation import evaluate_trial
    from narx.inference import (
        Checkpoint,
        NarxMethod,
        OrientationStream,
        angles_from_gyroscope,
        predict,
        predict_session,
    )
    from narx.network import Narx
    from narx.recordings import ImuRecording, Trial
    from narx.training import LevenbergMarquardt, Objective, Trainer
    from narx.windows import LaggedWindows, TrainingSequence

__version__ = "0.1.0"

# imported on first use: torch and numba take a second, `import narx` should not
_ROOM_OF = {
    "angles_from_gyroscope": "narx.inference",
    "calibrate": "narx.calibration",
    "Checkpoint": "narx.inference",
    "evaluate_trial": "narx.evaluation",
    "ImuRecording": "narx.recordings",
    "LaggedWindows": "narx.windows",
    "LevenbergMarquardt": "narx.training",
    "Narx": "narx.network",
    "NarxMethod": "narx.inference",
    "Objective": "narx.training",
    "OrientationStream": "narx.inference",
    "predict": "narx.inference",
    "predict_session": "narx.inference",
    "SimulatedGait": "narx.datasets",
    "Trainer": "narx.training",
    "TrainingSequence": "narx.windows",
    "Trial": "narx.recordings",
}

__all__ = [
    "Checkpoint",
    "ImuRecording",
    "LaggedWindows",
    "LevenbergMarquardt",
    "Narx",
    "NarxMethod",
    "Objective",
    "OrientationStream",
    "SimulatedGait",
    "Trainer",
    "TrainingSequence",
    "Trial",
    "__version__",
    "angles_from_gyroscope",
    "calibrate",
    "evaluate_trial",
    "predict",
    "predict_session",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOM_OF:
        raise AttributeError(f"module 'narx' has no attribute '{name}'")
    value = getattr(import_module(_ROOM_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
