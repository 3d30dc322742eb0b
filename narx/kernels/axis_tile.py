"""Operations on one tile of samples: run the network, linearise it, propagate sensitivities.

Layout: the last axis of every array holds columns, and a column is a sample of a lane: sample
`t` of lane `l` of W lies at ``t * W + l``. With W parallel lanes (restarts, recordings), a vector
is one sample of all lanes; with one lane, it is consecutive samples. Whatever does not depend on
the previous sample is therefore vectorised either way, and a lag of m samples is m * W columns.

Inputs ``x`` (C, columns) start with the ``input_lags - 1`` samples before the tile, fed-back
outputs ``y`` (1, columns) with the ``output_lags`` samples before it, and sensitivities ``rows``
(K, columns) with `head` columns, whose end corresponds to the same samples.
"""

from typing import Any

from narx.kernels.compiler import INNER, compiled
from narx.kernels.lanes import load, splat, spread, store
from narx.kernels.sizes import VECTOR
from narx.kernels.tanh import activate


@compiled(**INNER)
def head(n_out: Any, width: Any) -> Any:
    """Columns of `rows` before the tile: enough for the lags, and whole vectors."""
    return (n_out * width + 7) // 8 * 8


@compiled(**INNER)
def advance(
    weights: Any, x: Any, y: Any, h: Any, start: int, stop: int, shape: Any, lanes: Any, exact: Any
) -> None:
    """Run samples `start` to `stop` in closed loop: outputs to `y`, activations to `h`."""
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, n_v, n_features = len(lanes), n_inputs * n_in, n_inputs * n_in + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    newest = load(lanes, y, (0, (start + n_out - 1) * width))
    for t in range(start, stop):
        out = load(lanes, weights, (slope + n_hidden, 0))
        for j in range(n_hidden):
            z = load(lanes, weights, (bias + j, 0))
            for i in range(n_in):
                for c in range(n_inputs):
                    w = load(lanes, weights, (j * n_features + i * n_inputs + c, 0))
                    z = z + w * load(lanes, x, (c, (t + n_in - 1 - i) * width))
            for m in range(n_out - 1, 0, -1):
                w = load(lanes, weights, (j * n_features + n_v + m, 0))
                z = z + w * load(lanes, y, (0, (t + n_out - 1 - m) * width))
            # the newest output is added last: everything else is available earlier
            z = z + load(lanes, weights, (j * n_features + n_v, 0)) * newest
            activation = activate(z, exact)
            store(lanes, h, (j, t * width), activation)
            out = out + load(lanes, weights, (slope + j, 0)) * activation
        store(lanes, y, (0, (t + n_out) * width), out)
        newest = out


@compiled(**INNER)
def predict(
    weights: Any, x: Any, y: Any, out: Any, h: Any, n: int, shape: Any, lanes: Any, exact: Any
) -> None:
    """Run `n` samples in open loop on past outputs `y`: outputs to `out`, activations to `h`."""
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, n_v, n_features = len(lanes), n_inputs * n_in, n_inputs * n_in + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    v = VECTOR
    for at in range(0, n * width, 8):
        p = spread(v, lanes, weights, (slope + n_hidden, 0))
        for j in range(n_hidden):
            z = spread(v, lanes, weights, (bias + j, 0))
            for i in range(n_in):
                for c in range(n_inputs):
                    w = spread(v, lanes, weights, (j * n_features + i * n_inputs + c, 0))
                    z = z + w * load(v, x, (c, at + (n_in - 1 - i) * width))
            for m in range(n_out - 1, -1, -1):
                w = spread(v, lanes, weights, (j * n_features + n_v + m, 0))
                z = z + w * load(v, y, (0, at + (n_out - 1 - m) * width))
            activation = activate(z, exact)
            store(v, h, (j, at), activation)
            p = p + spread(v, lanes, weights, (slope + j, 0)) * activation
        store(v, out, (0, at + n_out * width), p)


@compiled(**INNER)
def linearise(
    weights: Any,
    x: Any,
    y: Any,
    h: Any,
    rows: Any,
    lead: int,
    start: int,
    stop: int,
    shape: Any,
    lanes: Any,
) -> None:
    """Differentiate samples by weights, their inputs held, into `rows`.

    The column of sample 0 is `lead`. Up to seven columns beyond the last are written as well.
    """
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, n_v, n_features = len(lanes), n_inputs * n_in, n_inputs * n_in + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    v = VECTOR
    for at in range(start * width, stop * width, 8):
        to = at + lead
        for j in range(n_hidden):
            activation = load(v, h, (j, at))
            w = spread(v, lanes, weights, (slope + j, 0))
            d = w - (w * activation) * activation
            store(v, rows, (bias + j, to), d)
            store(v, rows, (slope + j, to), activation)
            for i in range(n_in):
                for c in range(n_inputs):
                    p = load(v, x, (c, at + (n_in - 1 - i) * width))
                    store(v, rows, (j * n_features + i * n_inputs + c, to), d * p)
            for m in range(n_out):
                p = load(v, y, (0, at + (n_out - 1 - m) * width))
                store(v, rows, (j * n_features + n_v + m, to), d * p)
        store(v, rows, (slope + n_hidden, to), splat(v, 1.0))


@compiled(**INNER)
def feed_back(
    weights: Any,
    rows: Any,
    lead: int,
    feedback: Any,
    start: int,
    stop: int,
    shape: Any,
    lanes: Any,
) -> None:
    """Differentiate samples by the outputs before them, from what `linearise` left in `rows`."""
    n_hidden, n_inputs, n_in, n_out = len(shape[0]), len(shape[1]), len(shape[2]), len(shape[3])
    width, n_v, n_features = len(lanes), n_inputs * n_in, n_inputs * n_in + n_out
    bias, v = n_hidden * n_features, VECTOR
    for at in range(start * width, stop * width, 8):
        for m in range(n_out):
            a = splat(v, 0.0)
            for j in range(n_hidden):
                w = spread(v, lanes, weights, (j * n_features + n_v + m, 0))
                a = a + w * load(v, rows, (bias + j, at + lead))
            store(v, feedback, (m, at), a)


@compiled(**INNER)
def propagate(rows: Any, feedback: Any, start: int, stop: int, shape: Any, lanes: Any) -> None:
    """Convert direct derivatives to total ones by adding those through earlier outputs."""
    n_out, width = len(shape[3]), len(lanes)
    first = head(n_out, width)
    for i in range(0, rows.shape[0], 4):  # four rows at a time hide each other's latency
        # the last two stay in registers: store and load take longer than a step
        before = first + (start - 1) * width
        s0 = load(lanes, rows, (i, before))
        s1 = load(lanes, rows, (i + 1, before))
        s2 = load(lanes, rows, (i + 2, before))
        s3 = load(lanes, rows, (i + 3, before))
        before = before - (width if n_out > 1 else 0)
        r0 = load(lanes, rows, (i, before))
        r1 = load(lanes, rows, (i + 1, before))
        r2 = load(lanes, rows, (i + 2, before))
        r3 = load(lanes, rows, (i + 3, before))
        for t in range(start, stop):
            at = first + t * width
            g0 = load(lanes, rows, (i, at))
            g1 = load(lanes, rows, (i + 1, at))
            g2 = load(lanes, rows, (i + 2, at))
            g3 = load(lanes, rows, (i + 3, at))
            for m in range(n_out - 1, 1, -1):
                a = load(lanes, feedback, (m, t * width))
                lag = at - (m + 1) * width
                g0 = g0 + a * load(lanes, rows, (i, lag))
                g1 = g1 + a * load(lanes, rows, (i + 1, lag))
                g2 = g2 + a * load(lanes, rows, (i + 2, lag))
                g3 = g3 + a * load(lanes, rows, (i + 3, lag))
            if n_out > 1:
                a = load(lanes, feedback, (1, t * width))
                g0 = g0 + a * r0
                g1 = g1 + a * r1
                g2 = g2 + a * r2
                g3 = g3 + a * r3
            a = load(lanes, feedback, (0, t * width))
            r0, r1, r2, r3 = s0, s1, s2, s3
            s0 = g0 + a * s0
            s1 = g1 + a * s1
            s2 = g2 + a * s2
            s3 = g3 + a * s3
            store(lanes, rows, (i, at), s0)
            store(lanes, rows, (i + 1, at), s1)
            store(lanes, rows, (i + 2, at), s2)
            store(lanes, rows, (i + 3, at), s3)
