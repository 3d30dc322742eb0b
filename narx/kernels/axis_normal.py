"""Normal equations of a fit, accumulated tile by tile, so that no Jacobian is stored."""

from typing import Any

import numpy as np

from narx.kernels.axis_tile import advance, feed_back, head, linearise, propagate
from narx.kernels.compiler import INNER, JIT, compiled
from narx.kernels.gram import add_products
from narx.kernels.transfer import (
    TILE_COLUMNS,
    aligned,
    columns_for,
    fetch_inputs,
    fetch_outputs,
)


@compiled(**JIT)
def normal_equations(
    weights: Any,
    inputs: Any,
    targets: Any,
    state: Any,
    roots: Any,
    lengths: Any,
    groups: Any,
    washout: int,
    horizon: int,
    sums: Any,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Add products of residuals and their derivatives to sums (K, K, 8), group after group.

    weights (P, W) belong to the lanes; groups (G, W) is the sequence of each lane.
    inputs (B, N, C), targets (B, N), state (B, S), roots (B,): square root of a sequence's
    weight, lengths (B,): samples that are used. Residual and derivative are zero where the target
    is NaN. `horizon` > 0 restarts from measured outputs every that many samples. Row P of sums
    belongs to the residuals.
    """
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, n_weights = len(lanes), len(weights)
    tile = TILE_COLUMNS // width
    x = aligned(n_inputs, columns_for((n_in + tile) * width))
    y = aligned(1, columns_for((n_out + tile) * width))
    h = aligned(n_hidden, columns_for(tile * width))
    feedback = aligned(n_out, columns_for(tile * width))
    rows = aligned(len(sums), columns_for((n_out + tile) * width + 8))
    past = np.zeros((len(sums), n_out * width))
    root = np.zeros(tile * width)
    since = np.zeros(width, np.int64)
    lead = head(n_out, width)
    for group in groups:
        n_samples = 0
        for lane in range(width):
            n_samples = max(n_samples, lengths[group[lane]])
        rows[:] = 0.0
        since[:] = n_out
        fetch_outputs(targets, state, group, 0, 0, y, shape, lanes)
        for start in range(0, n_samples, tile):
            n = min(tile, n_samples - start)
            fetch_inputs(inputs, state, group, start, n, x, shape, lanes)
            whole = weigh(targets, roots, lengths, group, start, n, washout, root, width)
            begin = 0
            while begin < n:
                end = n
                if horizon > 0:
                    if (start + begin) % horizon == 0 and start + begin > 0:
                        restart(y, begin, targets, state, group, start, since, n_out)
                    end = min(n, begin + horizon - (start + begin) % horizon)
                advance(weights, x, y, h, begin, end, shape, lanes, exact)
                linearise(weights, x, y, h, rows, lead, begin, end, shape, lanes)
                feed_back(weights, rows, lead, feedback, begin, end, shape, lanes)
                if horizon > 0:
                    cut(feedback, begin, end, since)
                propagate(rows, feedback, begin, end, shape, lanes)
                residuals(y, targets, group, start, begin, end, rows, n_weights, n_out, width)
                begin = end
            for i in range(n_weights):
                for at in range(n_out * width):
                    past[i, at] = rows[i, lead + (n - n_out) * width + at]
            if not whole:
                for i in range(n_weights + 1):
                    for at in range(n * width):
                        rows[i, lead + at] = rows[i, lead + at] * root[at] if root[at] > 0 else 0.0
            stop = lead + (n * width + 7) // 8 * 8
            rows[:, lead + n * width : stop] = 0.0
            add_products(rows, lead, stop, sums)
            for at in range(n_out * width):
                for i in range(n_weights):
                    rows[i, lead - n_out * width + at] = past[i, at]
                y[0, at] = y[0, at + n * width]


@compiled(**INNER)
def weigh(
    targets: Any,
    roots: Any,
    lengths: Any,
    group: Any,
    start: int,
    n: int,
    washout: int,
    root: Any,
    width: Any,
) -> bool:
    """Set the root of each column's weight; return whether all are one."""
    whole = True
    for lane in range(width):
        q = group[lane]
        for t in range(n):
            k = start + t
            weight = 0.0
            if washout <= k < lengths[q] and not np.isnan(targets[q, k]):
                weight = roots[q]
            root[t * width + lane] = weight
            whole &= weight == 1.0
    return whole


@compiled(**INNER)
def residuals(
    out: Any,
    targets: Any,
    sequence: Any,
    start: int,
    begin: int,
    end: int,
    rows: Any,
    row: int,
    n_out: Any,
    width: Any,
) -> None:
    """Write output minus target to a row (NaN where the target is missing)."""
    # one-dimensional, so that the compiler can tell that elements are contiguous
    output, error = out[0, n_out * width :], rows[row, head(n_out, width) :]
    if width == 1:
        target = targets[sequence[0], start:]
        for t in range(begin, end):
            error[t] = output[t] - target[t]
    else:
        for t in range(begin, end):
            for lane in range(width):
                at = t * width + lane
                error[at] = output[at] - targets[sequence[lane], start + t]


@compiled(**INNER)
def restart(
    y: Any, begin: int, targets: Any, state: Any, sequence: Any, start: int, since: Any, n_out: Any
) -> None:
    """Replace the lags by measured outputs, in the lanes where all of them are valid."""
    width, n_past = len(sequence), state.shape[1] - n_out
    measured = np.empty(n_out)
    for lane in range(width):
        q = sequence[lane]
        missing = False
        for m in range(n_out):
            k = start + begin - 1 - m
            measured[m] = targets[q, k] if k >= 0 else state[q, n_past - k - 1]
            missing |= np.isnan(measured[m])
        if not missing:
            for m in range(n_out):
                y[0, (begin + n_out - 1 - m) * width + lane] = measured[m]
            since[lane] = 0


@compiled(**INNER)
def cut(feedback: Any, begin: int, end: int, since: Any) -> None:
    """Clear the feedback through outputs that were measured, not computed."""
    width = len(since)
    for lane in range(width):
        for t in range(begin, end):
            for m in range(since[lane], len(feedback)):
                feedback[m, t * width + lane] = 0.0
            since[lane] += 1
