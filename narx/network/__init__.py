"""The NARX network: sizes, scales, one step, the closed loop, its stability."""

from narx.network.cell import NarxCell
from narx.network.model import Narx
from narx.network.normalisation import Normalisation
from narx.network.stability import StabilityStatement, stability_statement
from narx.network.structure import NarxStructure

__all__ = [
    "Narx",
    "NarxCell",
    "NarxStructure",
    "Normalisation",
    "StabilityStatement",
    "stability_statement",
]
