"""Whole recordings of three coupled axes in closed loop."""

from typing import Any

import numpy as np

from narx.kernels.compiler import INNER, JIT, compiled
from narx.kernels.coupled_tile import coupled_advance
from narx.kernels.transfer import (
    TILE_COLUMNS,
    aligned,
    columns_for,
    copy_row,
    fetch_weights,
    lanes_from,
)


@compiled(**INNER)
def stacked(n: int, n_rows: int, n_columns: int) -> Any:
    """Zeros (n, n_rows, n_columns), rows on cache lines; `n_columns` a multiple of eight."""
    return aligned(n * n_rows, n_columns).reshape(n, n_rows, n_columns)


@compiled(**INNER)
def fetch_scales(scales: Any, postures: Any, sequence: Any, scale: Any, posture: Any) -> None:
    """Fill the lanes' scale (6, W) and posture (3, W)."""
    for lane in range(len(sequence)):
        for axis in range(3):
            posture[axis, lane] = postures[sequence[lane], axis]
        copy_row(scales, scale[:, lane])


@compiled(**INNER)
def fetch_axes(values: Any, sequence: Any, start: int, n: int, head: int, out: Any) -> None:
    """Fill out (3, columns), after `head` samples, with `n` samples of values (B, N, 3)."""
    width = len(sequence)
    for lane in range(width):
        for t in range(n):
            row = values[sequence[lane], start + t]
            for axis in range(3):
                out[axis, (head + t) * width + lane] = row[axis]


@compiled(**INNER)
def fetch_past(state: Any, sequence: Any, n_in: int, n_out: int, v: Any, y: Any) -> None:
    """Fill the heads of v and y (3, 1, columns) from state (B, 3, S)."""
    width = len(sequence)
    for lane in range(width):
        for axis in range(3):
            past = state[sequence[lane], axis]
            for i in range(n_in - 1):
                v[axis, 0, (n_in - 2 - i) * width + lane] = past[i]
            for m in range(n_out):
                y[axis, 0, (n_out - 1 - m) * width + lane] = past[n_in - 1 + m]


@compiled(**INNER)
def shift(values: Any, n: int, head: int) -> None:
    """Move the last `head` of `head` + `n` columns to the front."""
    for axis in range(values.shape[0]):
        for row in range(values.shape[1]):
            for at in range(head):
                values[axis, row, at] = values[axis, row, at + n]


@compiled(**INNER)
def keep_past(v: Any, y: Any, n_in: int, n_out: int, lane: int, width: int, state: Any) -> None:
    """Copy a lane's state (3, S) from the heads of v and y."""
    for axis in range(3):
        for i in range(n_in - 1):
            state[axis, i] = v[axis, 0, (n_in - 2 - i) * width + lane]
        for m in range(n_out):
            state[axis, n_in - 1 + m] = y[axis, 0, (n_out - 1 - m) * width + lane]


@compiled(**JIT)
def run(
    weights: Any,
    rates: Any,
    state: Any,
    postures: Any,
    scales: Any,
    first: int,
    last: int,
    outputs: Any,
    final: Any,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Run sequences `first` to `last`: rates (B, N, 3) to angles (B, N, 3).

    weights (B or 1, P), state (B, 3, S), postures (B, 3); scales (6,): the inverse scale of each
    axis' rate, then the scale of its angle.
    """
    n_hidden, n_in, n_out, width = len(shape[0]), len(shape[2]), len(shape[3]), len(lanes)
    tile = TILE_COLUMNS // width
    n_samples = outputs.shape[1]
    sequence = np.zeros(width, np.int64)
    packed, scale = np.empty((weights.shape[1], width)), np.empty((6, width))
    posture = np.empty((3, width))
    u = aligned(3, columns_for((n_in + tile) * width))
    v = stacked(3, 1, columns_for((n_in + tile) * width))
    y = stacked(3, 1, columns_for((n_out + tile) * width))
    h = stacked(3, n_hidden, columns_for(tile * width))
    for group in range(first, last, width):
        used = lanes_from(group, last, sequence)
        fetch_weights(weights, sequence, packed)
        fetch_scales(scales, postures, sequence, scale, posture)
        fetch_past(state, sequence, n_in, n_out, v, y)
        for start in range(0, n_samples, tile):
            n = min(tile, n_samples - start)
            fetch_axes(rates, sequence, start, n, n_in - 1, u)
            coupled_advance(packed, u, v, y, h, scale, posture, n, shape, lanes, exact)
            for lane in range(used):
                for t in range(n):
                    for axis in range(3):
                        p = y[axis, 0, (t + n_out) * width + lane]
                        angle = scales[3 + axis] * p + postures[group + lane, axis]
                        outputs[group + lane, start + t, axis] = angle
            shift(v, n * width, (n_in - 1) * width)
            shift(y, n * width, n_out * width)
        for lane in range(used):
            keep_past(v, y, n_in, n_out, lane, width, final[group + lane])
