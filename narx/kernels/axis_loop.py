"""The closed loop over whole recordings and its adjoint, tile by tile."""

from typing import Any

import numpy as np

from narx.kernels.axis_tile import advance, feed_back, head, linearise, predict
from narx.kernels.compiler import JIT, compiled
from narx.kernels.lanes import load, splat, store
from narx.kernels.sizes import VECTOR
from narx.kernels.transfer import (
    TILE_COLUMNS,
    aligned,
    columns_for,
    fetch_inputs,
    fetch_outputs,
    fetch_weights,
    final_state,
    lanes_from,
)


@compiled(**JIT)
def run(
    weights: Any,
    inputs: Any,
    state: Any,
    first: int,
    last: int,
    outputs: Any,
    final: Any,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Run sequences `first` to `last`: weights (B or 1, P), inputs (B, N, C), state (B, S)."""
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width = len(lanes)
    # without sensitivities there is room for longer tiles, which cost less: gathering is per tile
    tile = max(TILE_COLUMNS // width, 64)
    n_samples = outputs.shape[1]
    sequence = np.zeros(width, np.int64)
    packed = np.empty((weights.shape[1], width))
    x = aligned(n_inputs, columns_for((n_in + tile) * width))
    y = aligned(1, columns_for((n_out + tile) * width))
    h = aligned(n_hidden, columns_for(tile * width))
    for group in range(first, last, width):
        used = lanes_from(group, last, sequence)
        fetch_weights(weights, sequence, packed)
        for start in range(0, n_samples, tile):
            n = min(tile, n_samples - start)
            fetch_inputs(inputs, state, sequence, start, n, x, shape, lanes)
            fetch_outputs(outputs, state, sequence, start, 0, y, shape, lanes)
            advance(packed, x, y, h, 0, n, shape, lanes, exact)
            for lane in range(used):
                row = outputs[group + lane]
                for t in range(n):
                    row[start + t] = y[0, (t + n_out) * width + lane]
        for q in range(group, group + used):
            final_state(inputs, outputs, state, q, shape, final[q])


@compiled(**JIT)
def adjoint(
    weights: Any,
    inputs: Any,
    state: Any,
    outputs: Any,
    d_outputs: Any,
    d_final: Any,
    first: int,
    last: int,
    d_weights: Any,
    d_inputs: Any,
    d_state: Any,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Vector-Jacobian product of `run`: d_weights (B, P), d_inputs (B, N, C), d_state (B, S)."""
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, v = len(lanes), VECTOR
    n_features = n_inputs * n_in + n_out
    n_past, bias = n_inputs * (n_in - 1), n_hidden * n_features
    n_weights = weights.shape[1]
    tile = TILE_COLUMNS // width
    n_samples = outputs.shape[1]
    sequence = np.zeros(width, np.int64)
    packed = np.empty((n_weights, width))
    x = aligned(n_inputs, columns_for((n_in + tile) * width))
    y = aligned(1, columns_for((n_out + tile) * width))
    out = aligned(1, columns_for((n_out + tile) * width))
    h = aligned(n_hidden, columns_for(tile * width))
    rows = aligned(n_weights, columns_for((n_out + tile) * width + 8))
    feedback = aligned(n_out, columns_for(tile * width))
    lam = aligned(1, columns_for(tile * width))
    sums = np.empty((n_weights, 8))
    # adjoints of a sample's features from later samples: outputs and inputs, newest first
    ask_y = np.zeros((n_out + 1, width))
    ask_x = np.zeros((n_in, n_inputs, width))
    lead = head(n_out, width)
    for group in range(first, last, width):
        used = lanes_from(group, last, sequence)
        fetch_weights(weights, sequence, packed)
        sums[:] = 0.0
        for lane in range(width):
            q = sequence[lane]
            for i in range(n_past):
                ask_x[i // n_inputs, i % n_inputs, lane] = d_final[q, i]
            for m in range(n_out):
                ask_y[m, lane] = d_final[q, n_past + m]
        for tile_index in range((n_samples + tile - 1) // tile - 1, -1, -1):
            start = tile_index * tile
            n = min(tile, n_samples - start)
            fetch_inputs(inputs, state, sequence, start, n, x, shape, lanes)
            fetch_outputs(outputs, state, sequence, start, n, y, shape, lanes)
            predict(packed, x, y, out, h, n, shape, lanes, exact)
            linearise(packed, x, y, h, rows, lead, 0, n, shape, lanes)
            feed_back(packed, rows, lead, feedback, 0, n, shape, lanes)
            lam[:] = 0.0
            for lane in range(width):
                for t in range(n):
                    lam[0, t * width + lane] = d_outputs[sequence[lane], start + t]
            for t in range(n - 1, -1, -1):
                at = t * width
                g = load(lanes, lam, (0, at)) + load(lanes, ask_y, (0, 0))
                store(lanes, lam, (0, at), g)
                for m in range(n_out):
                    ask = load(lanes, ask_y, (m + 1, 0)) + load(lanes, feedback, (m, at)) * g
                    store(lanes, ask_y, (m, 0), ask)
                for c in range(n_inputs):
                    for i in range(n_in):
                        e = splat(lanes, 0.0)
                        for j in range(n_hidden):
                            w = load(lanes, packed, (j * n_features + i * n_inputs + c, 0))
                            e = e + w * load(lanes, rows, (bias + j, lead + at))
                        e = load(lanes, ask_x, (i, c, 0)) + g * e
                        if i == 0:  # not used by earlier samples, so its column is free
                            store(lanes, x, (c, (t + n_in - 1) * width), e)
                        else:
                            store(lanes, ask_x, (i - 1, c, 0), e)
            for lane in range(used):
                for t in range(n):
                    for c in range(n_inputs):
                        d_inputs[group + lane, start + t, c] = x[c, (t + n_in - 1) * width + lane]
            # columns beyond the last sample have no adjoint
            rows[:, lead + n * width :] = 0.0
            for i in range(n_weights):
                s = load(v, sums, (i, 0))
                for at in range(0, n * width, 8):
                    s = s + load(v, lam, (0, at)) * load(v, rows, (i, lead + at))
                store(v, sums, (i, 0), s)
        for lane in range(used):
            q = group + lane
            for i in range(n_weights):
                d_weights[q, i] = sums[i].sum() if width == 1 else sums[i, lane]
            for i in range(n_past):
                d_state[q, i] = ask_x[i // n_inputs, i % n_inputs, lane]
            for m in range(n_out):
                d_state[q, n_past + m] = ask_y[m, lane]
