"""Sensitivities of three coupled axes: their normal equations, without a Jacobian."""

from typing import Any

import numpy as np

from narx.kernels.axis_tile import linearise
from narx.kernels.compiler import INNER, JIT, compiled
from narx.kernels.coupled_loop import fetch_axes, fetch_past, fetch_scales, shift, stacked
from narx.kernels.coupled_tile import (
    answer_to_tilt,
    couple,
    coupled_advance,
    coupled_head,
    coupled_propagate,
    memory,
)
from narx.kernels.gram import add_products
from narx.kernels.lanes import load, store
from narx.kernels.sizes import VECTOR
from narx.kernels.transfer import TILE_COLUMNS, aligned, columns_for, fetch_weights


@compiled(**JIT)
def coupled_sensitivities(
    weights: Any,
    rates: Any,
    targets: Any,
    state: Any,
    postures: Any,
    scales: Any,
    roots: Any,
    lengths: Any,
    groups: Any,
    washout: int,
    n_axes: int,
    offset_free: bool,
    given: bool,
    sums: Any,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Add products of residuals and their derivatives to sums (3, K, K, 8), group after group.

    weights (R, P); groups (G, W, 2) is the sequence of each lane and its row of the weights. rates
    and targets (B, N, 3), the latter as normalised outputs, or with `given` as residuals; state
    (B, 3, S), postures (B, 3), scales (6,) as in `narx.kernels.coupled_loop.run`; roots and lengths
    (B,). The first `n_axes` axes are used. With `offset_free` each sequence's
    mean residual is subtracted, axis by axis.
    """
    n_hidden, n_in, n_out, width = len(shape[0]), len(shape[2]), len(shape[3]), len(lanes)
    n_weights, n_rows, bias = weights.shape[1], sums.shape[1], n_hidden * (n_in + n_out)
    depth, lead = memory(shape), coupled_head(shape, width)
    tile = TILE_COLUMNS // width
    sequence, own = np.zeros(width, np.int64), np.zeros(width, np.int64)
    packed, scale = np.empty((n_weights, width)), np.empty((6, width))
    posture = np.empty((3, width))
    u = aligned(3, columns_for((n_in + tile) * width))
    v = stacked(3, 1, columns_for((n_in + tile) * width))
    y = stacked(3, 1, columns_for((n_out + tile) * width))
    h = stacked(3, n_hidden, columns_for(tile * width))
    tilting = stacked(3, 2, columns_for((n_in + tile) * width))
    coefficients = stacked(9, depth, columns_for(tile * width)).reshape(3, 3, depth, -1)
    rows = stacked(3, n_rows, columns_for((depth + tile) * width + 8))
    past = np.zeros((3, n_weights, depth * width))
    totals = np.zeros((3, n_rows, 8))
    root, counted = np.zeros((3, tile * width)), np.zeros((3, width), np.int64)
    for group in groups:
        n_samples = 0
        for lane in range(width):
            sequence[lane], own[lane] = group[lane, 0], group[lane, 1]
            n_samples = max(n_samples, lengths[sequence[lane]])
        fetch_weights(weights, own, packed)
        fetch_scales(scales, postures, sequence, scale, posture)
        fetch_past(state, sequence, n_in, n_out, v, y)
        tilting[:] = 0.0
        rows[:] = 0.0
        totals[:] = 0.0
        counted[:] = 0
        for start in range(0, n_samples, tile):
            n = min(tile, n_samples - start)
            stop = lead + (n * width + 7) // 8 * 8
            fetch_axes(rates, sequence, start, n, n_in - 1, u)
            coupled_advance(packed, u, v, y, h, scale, posture, n, shape, lanes, exact)
            answer_to_tilt(u, y, tilting, scale, posture, n, shape, lanes, exact)
            for axis in range(n_axes):
                linearise(
                    packed,
                    v[axis],
                    y[axis],
                    h[axis],
                    rows[axis],
                    lead,
                    0,
                    n,
                    shape,
                    lanes,
                )
                couple(
                    packed,
                    rows[axis],
                    bias,
                    lead,
                    tilting,
                    coefficients,
                    axis,
                    n,
                    shape,
                    lanes,
                )
            coupled_propagate(rows, coefficients, n_weights, n, n_axes, shape, lanes)
            for axis in range(n_axes):
                for i in range(n_weights):
                    for at in range(depth * width):
                        past[axis, i, at] = rows[axis, i, lead + (n - depth) * width + at]
            count(
                y,
                targets,
                roots,
                lengths,
                group,
                start,
                n,
                washout,
                given,
                n_out,
                lead,
                rows,
                n_weights,
                root,
                counted,
                n_axes,
            )
            for axis in range(n_axes):
                weigh_rows(rows[axis], root[axis], n_weights + 1, lead, n * width)
                rows[axis, :, lead + n * width : stop] = 0.0
                add_products(rows[axis], lead, stop, sums[axis])
                if offset_free:
                    add_columns(rows[axis], lead, stop, totals[axis])
                for i in range(n_weights):
                    for at in range(depth * width):
                        rows[axis, i, lead - depth * width + at] = past[axis, i, at]
            shift(v, n * width, (n_in - 1) * width)
            shift(tilting, n * width, (n_in - 1) * width)
            shift(y, n * width, n_out * width)
        if offset_free:
            take_means_off(totals, counted, sums, n_axes, width)


@compiled(**INNER)
def count(
    y: Any,
    targets: Any,
    roots: Any,
    lengths: Any,
    group: Any,
    start: int,
    n: int,
    washout: int,
    given: bool,
    n_out: Any,
    lead: int,
    rows: Any,
    row: int,
    root: Any,
    counted: Any,
    n_axes: int,
) -> None:
    """Fill the row of residuals, and the root of every column's weight (zero: not used)."""
    width = len(group)
    for lane in range(width):
        q = group[lane, 0]
        for t in range(n):
            k, at = start + t, t * width + lane
            for axis in range(n_axes):
                residual, weight = 0.0, 0.0
                if washout <= k < lengths[q]:
                    residual = targets[q, k, axis]
                    if not given:
                        residual = y[axis, 0, at + n_out * width] - residual
                    if given or not np.isnan(targets[q, k, axis]):
                        weight = roots[q]
                        counted[axis, lane] += 1
                rows[axis, row, lead + at] = residual
                root[axis, at] = weight


@compiled(**INNER)
def weigh_rows(rows: Any, root: Any, n_rows: int, lead: int, n: int) -> None:
    """Multiply columns by the roots of their weights, unless all are one."""
    whole = True
    for at in range(n):
        whole &= root[at] == 1.0
    if not whole:
        for i in range(n_rows):
            for at in range(n):
                rows[i, lead + at] = rows[i, lead + at] * root[at] if root[at] > 0 else 0.0


@compiled(**INNER)
def add_columns(rows: Any, start: int, stop: int, totals: Any) -> None:
    """Add the columns of each row to totals (K, 8), eight at a time."""
    for i in range(len(rows)):
        s = load(VECTOR, totals, (i, 0))
        for at in range(start, stop, 8):
            s = s + load(VECTOR, rows, (i, at))
        store(VECTOR, totals, (i, 0), s)


@compiled(**INNER)
def take_means_off(totals: Any, counted: Any, sums: Any, n_axes: int, width: int) -> None:
    """Subtract what each sequence's means contribute: sum (e-m)(e-m)' = sum ee' - n mm'."""
    for axis in range(n_axes):
        if width == 1:
            for i in range(totals.shape[1]):
                totals[axis, i, 0] = totals[axis, i].sum()
        for lane in range(width):
            if counted[axis, lane] == 0:
                continue
            for i in range(totals.shape[1]):
                mean = totals[axis, i, lane] / counted[axis, lane]
                for j in range(totals.shape[1]):
                    sums[axis, i, j, lane] -= mean * totals[axis, j, lane]
