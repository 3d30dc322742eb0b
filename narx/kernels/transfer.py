"""Copies between recordings (one row per sequence) and tiles (one column per sample and lane)."""

from typing import Any

import numpy as np

from narx.kernels.compiler import INNER, VIEWS, compiled

TILE_COLUMNS = 128  # with twenty rows of float64 a tile stays in the first-level cache


@compiled(**INNER)
def aligned(n_rows: int, n_columns: int) -> Any:
    """Zeros (n_rows, n_columns), each row on a cache line; `n_columns` a multiple of eight."""
    flat = np.zeros(n_rows * n_columns + 8)
    skip = (-(flat.ctypes.data // 8)) % 8
    return flat[skip : skip + n_rows * n_columns].reshape(n_rows, n_columns)


@compiled(**VIEWS)
def copy_row(source: Any, out: Any) -> None:
    """Copy a row; numba's assignment of one array to another takes seconds to compile."""
    for i in range(len(out)):
        out[i] = source[i]


@compiled(**INNER)
def columns_for(n: int) -> int:
    """Space for `n` columns and one more vector, in whole vectors."""
    return (n + 7) // 8 * 8 + 8


@compiled(**INNER)
def fetch_inputs(
    inputs: Any, state: Any, sequence: Any, start: int, n: int, x: Any, shape: Any, lanes: Any
) -> None:
    """Fill x (C, columns) with samples `start` to `start + n` and the lags before them."""
    n_inputs, n_in, width = len(shape[1]), len(shape[2]), len(lanes)
    for lane in range(width):
        q = sequence[lane]
        for t in range(1 - n_in, n):
            at = (t + n_in - 1) * width + lane
            for c in range(n_inputs):
                if start + t >= 0:
                    x[c, at] = inputs[q, start + t, c]
                else:
                    x[c, at] = state[q, (-start - t - 1) * n_inputs + c]


@compiled(**INNER)
def fetch_outputs(
    outputs: Any, state: Any, sequence: Any, start: int, n: int, y: Any, shape: Any, lanes: Any
) -> None:
    """Fill y (1, columns) with outputs `start` to `start + n` and the lags before them."""
    n_inputs, n_in, n_out, width = len(shape[1]), len(shape[2]), len(shape[3]), len(lanes)
    n_past = n_inputs * (n_in - 1)
    for lane in range(width):
        q = sequence[lane]
        for t in range(-n_out, n):
            at = (t + n_out) * width + lane
            if start + t >= 0:
                y[0, at] = outputs[q, start + t]
            else:
                y[0, at] = state[q, n_past - start - t - 1]


@compiled(**INNER)
def fetch_weights(weights: Any, sequence: Any, packed: Any) -> None:
    """Fill packed (P, W) from weights (B, P), or from a single shared row."""
    for lane in range(len(sequence)):
        q = sequence[lane] if len(weights) > 1 else 0
        for i in range(weights.shape[1]):  # assigning a whole row would take two seconds to compile
            packed[i, lane] = weights[q, i]


@compiled(**INNER)
def final_state(inputs: Any, outputs: Any, state: Any, q: int, shape: Any, final: Any) -> None:
    """Collect the state after the last sample from a recording and its state before."""
    n_inputs, n_in, n_out = len(shape[1]), len(shape[2]), len(shape[3])
    n, n_past = outputs.shape[1], n_inputs * (n_in - 1)
    for i in range(n_in - 1):
        k = n - 1 - i
        for c in range(n_inputs):
            final[i * n_inputs + c] = (
                inputs[q, k, c] if k >= 0 else state[q, (-k - 1) * n_inputs + c]
            )
    for m in range(n_out):
        k = n - 1 - m
        final[n_past + m] = outputs[q, k] if k >= 0 else state[q, n_past - k - 1]


@compiled(**INNER)
def lanes_from(first: int, last: int, sequence: Any) -> int:
    """Assign sequences from `first` on to lanes; return how many. Unused lanes repeat the last."""
    for lane in range(len(sequence)):
        sequence[lane] = min(first + lane, last - 1)
    return min(len(sequence), last - first)
