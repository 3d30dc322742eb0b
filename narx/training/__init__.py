"""Training of networks: objective, starting weights, optimisers, teachers."""

from narx.training.design import NetworkDesign
from narx.training.gradient import Adam, Lbfgs
from narx.training.levenberg_marquardt import LevenbergMarquardt
from narx.training.objective import Objective
from narx.training.teachers import MethodTeacher, ReferenceTeacher
from narx.training.trainer import Trainer
from narx.training.trial_reader import TrialReader

__all__ = [
    "Adam",
    "Lbfgs",
    "LevenbergMarquardt",
    "MethodTeacher",
    "NetworkDesign",
    "Objective",
    "ReferenceTeacher",
    "Trainer",
    "TrialReader",
]
