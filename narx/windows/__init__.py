"""Training data of networks: sequences without gaps, and lagged windows of them."""

from narx.windows.lagged import LaggedWindows
from narx.windows.sequences import TrainingSequence, contiguous, from_arrays, hold_back

__all__ = [
    "LaggedWindows",
    "TrainingSequence",
    "contiguous",
    "from_arrays",
    "hold_back",
]
