"""The network of the tracker, one sample at a time, of several sensors side by side."""

from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled
from narx.kernels.functions import load, splat, store, tanh
from narx.kernels.tracker_layout import OUTPUT


@compiled(**EXACT_VIEWS)
def three_outputs(weights: Any, features: Any, arguments: Any, work: Any, lanes: Any) -> None:
    """Fill work[OUTPUT] (3, W) from scaled features (3, width, W), newest first.

    Each axis has a row of features; arguments (3, n_hidden, W) is overwritten. Without hidden
    neurons `weights` are the coefficients of a linear recursion, in s and 1.
    """
    width, n_hidden = features.shape[1], arguments.shape[1]
    bias, second = n_hidden * width, n_hidden * (width + 1)
    for axis in range(3):
        if n_hidden == 0:
            total = splat(lanes, 0.0)
            for i in range(width):
                total = total + weights[i] * load(lanes, features, (axis, i, 0))
        else:
            for h in range(n_hidden):
                argument = splat(lanes, weights[bias + h])
                for i in range(width):
                    scaled = load(lanes, features, (axis, i, 0))
                    argument = argument + weights[h * width + i] * scaled
                store(lanes, arguments, (axis, h, 0), argument)
            total = splat(lanes, weights[second + n_hidden])
            for h in range(n_hidden):
                total = total + weights[second + h] * tanh(load(lanes, arguments, (axis, h, 0)))
        store(lanes, work, (OUTPUT, axis, 0), total)
