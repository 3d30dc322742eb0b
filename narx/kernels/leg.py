"""Tell the swing of a leg from other motion, by the skewness of the sagittal rate.

A leg swings forward faster than backward; the skewness of its sagittal rate, mean cube over the 3/2
power of the mean square, is 0.5 to 1.2 in sixteen pocket walks and at most 0.4 in six walks with
the phone in a hand (medians of a recording).
"""

import math

from narx.kernels.compiler import EXACT_VIEWS, compiled

# Below the skewness of a leg, the standard deviation grows by `STD_GROWTH` times the relative
# difference. If it is more than doubled, the motion is doubtful.
LEG_SKEWNESS, STD_GROWTH, MOST_GROWTH, DOUBTFUL_GROWTH = 0.5, 2.5, 6.0, 2.0
# mean square (rad^2 / s^2) before the first samples in walking, which have to outweigh it
START_SQUARE = 0.5


@compiled(**EXACT_VIEWS)
def std_growth(square: float, cube: float) -> float:
    """Factor on the standard deviation from mean square and mean cube of the sagittal rate."""
    skewness = cube / (square * math.sqrt(square))
    growth = 1.0 + STD_GROWTH * max(1.0 - skewness / LEG_SKEWNESS, 0.0)
    return float(min(growth, MOST_GROWTH))
