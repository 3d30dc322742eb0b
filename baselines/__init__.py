"""Orientation methods to compare a network with, one a file, behind one interface."""

from narx.baselines.complementary_filter import ComplementaryFilter
from narx.baselines.giof import Giof
from narx.baselines.gyro_integration import GyroIntegration
from narx.baselines.madgwick import Madgwick
from narx.baselines.mahony import Mahony
from narx.baselines.pseudo_integrator import PseudoIntegrator
from narx.baselines.two_point import TwoPoint
from narx.baselines.vqf import Vqf

__all__ = [
    "ComplementaryFilter",
    "Giof",
    "GyroIntegration",
    "Madgwick",
    "Mahony",
    "PseudoIntegrator",
    "TwoPoint",
    "Vqf",
]
