"""The network of one sensor, one sample at a time."""

from typing import Any

from narx.kernels.compiler import EXACT_INNER, compiled
from narx.kernels.functions import tanh

# row of the intermediate results, after those of `narx.kernels.kalman`
OUTPUT = 2


@compiled(**EXACT_INNER)
def three_outputs(weights: Any, features: Any, arguments: Any, work: Any) -> None:
    """Fill work[OUTPUT] (3,) from scaled features (3, width), newest first.

    Each axis has a row of features; arguments (3, n_hidden) is overwritten. Without hidden neurons
    `weights` are the coefficients of a linear recursion, in s and 1.
    """
    width, n_hidden = features.shape[1], arguments.shape[1]
    bias, second = n_hidden * width, n_hidden * (width + 1)
    for axis in range(3):
        if n_hidden == 0:
            total = 0.0
            for i in range(width):
                total += weights[i] * features[axis, i]
        else:
            for h in range(n_hidden):
                argument = weights[bias + h]
                for i in range(width):
                    argument += weights[h * width + i] * features[axis, i]
                arguments[axis, h] = argument
            total = weights[second + n_hidden]
            for h in range(n_hidden):
                total += weights[second + h] * tanh(arguments[axis, h])
        work[OUTPUT, axis] = total
