"""Orientation methods to compare a network with, one per file, with a common interface."""

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.baselines.constant import Constant
from narx.baselines.giof import Giof
from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.leaky_integrator import LeakyIntegrator
from narx.baselines.madgwick import Madgwick
from narx.baselines.mahony import Mahony
from narx.baselines.pseudo_integrator import PseudoIntegrator
from narx.baselines.strapdown import Strapdown
from narx.baselines.two_point import TwoPoint
from narx.baselines.vqf import Vqf
from narx.baselines.zero import Zero

__all__ = [
    "ComplementaryFilter",
    "Constant",
    "Giof",
    "GyroIntegration",
    "LeakyIntegrator",
    "Madgwick",
    "Mahony",
    "PseudoIntegrator",
    "Strapdown",
    "TwoPoint",
    "Vqf",
    "Zero",
]
