"""One tile of three coupled axes: the estimated tilt converts the gyroscope's rates.

The tilt is extrapolated to the time of the sample, ``2 p_{k-1} - p_{k-2}`` (`ahead`): with the tilt
of the previous sample, correlated tilt and turn would act like a bias of 0.1 deg/s at 100 Hz.

Layout as in `narx.kernels.axis_tile`, with the axis first: gyroscope ``u``, inputs of the network
``v`` and their derivatives ``tilting`` by the earlier tilt have ``input_lags - 1`` samples before
the tile, outputs ``y`` (3, 1, columns) ``output_lags``, sensitivities ``rows`` (3, K, columns) a
head of `coupled_head` columns. Per lane: ``scales`` (6, W): rates, then angles; ``posture`` (3, W).
"""

from typing import Any

from narx.kernels.compiler import INNER, compiled
from narx.kernels.euler import angle_rates
from narx.kernels.lanes import load, splat, spread, store
from narx.kernels.sizes import VECTOR
from narx.kernels.tanh import activate


@compiled(**INNER)
def memory(shape: Any) -> Any:
    """Past samples used by the sensitivities: through outputs, and through inputs to tilt."""
    return max(len(shape[3]), len(shape[2]) + (1 if len(shape[3]) > 1 else 0))


@compiled(**INNER)
def ahead(y: Any, axis: int, at: int, width: Any, shape: Any, lanes: Any) -> Any:
    """Next output by linear extrapolation from those at `at` and just before it."""
    newest = load(lanes, y, (axis, 0, at))
    if len(shape[3]) > 1:
        return newest + newest - load(lanes, y, (axis, 0, at - width))
    return newest


@compiled(**INNER)
def coupled_head(shape: Any, width: Any) -> Any:
    """Columns of the sensitivities before the tile: enough for the lags, and whole vectors."""
    return (memory(shape) * width + 7) // 8 * 8


@compiled(**INNER)
def coupled_advance(
    weights: Any,
    u: Any,
    v: Any,
    y: Any,
    h: Any,
    scales: Any,
    posture: Any,
    n: int,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Run `n` samples of the three axes in closed loop; weights (P, W)."""
    n_hidden, n_in, n_out = len(shape[0]), len(shape[2]), len(shape[3])
    width, n_features = len(lanes), n_in + n_out
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    for t in range(n):
        at = (t + n_in - 1) * width
        newest = (t + n_out - 1) * width
        p_s = ahead(y, 0, newest, width, shape, lanes)
        p_f = ahead(y, 1, newest, width, shape, lanes)
        rates, _, _ = angle_rates(
            load(lanes, u, (0, at)),
            load(lanes, u, (1, at)),
            load(lanes, u, (2, at)),
            load(lanes, scales, (3, 0)) * p_s + load(lanes, posture, (0, 0)),
            load(lanes, scales, (4, 0)) * p_f + load(lanes, posture, (1, 0)),
            exact,
        )
        store(lanes, v, (0, 0, at), rates[0] * load(lanes, scales, (0, 0)))
        store(lanes, v, (1, 0, at), rates[1] * load(lanes, scales, (1, 0)))
        store(lanes, v, (2, 0, at), rates[2] * load(lanes, scales, (2, 0)))
        for axis in range(3):
            out = load(lanes, weights, (slope + n_hidden, 0))
            for j in range(n_hidden):
                z = load(lanes, weights, (bias + j, 0))
                for m in range(n_out - 1, -1, -1):
                    w = load(lanes, weights, (j * n_features + n_in + m, 0))
                    z = z + w * load(lanes, y, (axis, 0, (t + n_out - 1 - m) * width))
                for i in range(n_in - 1, -1, -1):  # the current input is added last
                    w = load(lanes, weights, (j * n_features + i, 0))
                    z = z + w * load(lanes, v, (axis, 0, at - i * width))
                activation = activate(z, exact)
                store(lanes, h, (axis, j, t * width), activation)
                out = out + load(lanes, weights, (slope + j, 0)) * activation
            store(lanes, y, (axis, 0, (t + n_out) * width), out)


@compiled(**INNER)
def answer_to_tilt(
    u: Any,
    y: Any,
    tilting: Any,
    scales: Any,
    posture: Any,
    n: int,
    shape: Any,
    lanes: Any,
    exact: Any,
) -> None:
    """Derivative of each axis' input by sagittal and frontal output `ahead`: (3, 2, columns)."""
    n_in, n_out, width, v = len(shape[2]), len(shape[3]), len(lanes), VECTOR
    for at in range(0, n * width, 8):
        to = at + (n_in - 1) * width
        newest = at + (n_out - 1) * width
        scale_s, scale_f = spread(v, lanes, scales, (3, 0)), spread(v, lanes, scales, (4, 0))
        _, by_s, by_f = angle_rates(
            load(v, u, (0, to)),
            load(v, u, (1, to)),
            load(v, u, (2, to)),
            scale_s * ahead(y, 0, newest, width, shape, v) + spread(v, lanes, posture, (0, 0)),
            scale_f * ahead(y, 1, newest, width, shape, v) + spread(v, lanes, posture, (1, 0)),
            exact,
        )
        for axis in range(3):
            scale = spread(v, lanes, scales, (axis, 0))
            store(v, tilting, (axis, 0, to), scale * scale_s * by_s[axis])
            store(v, tilting, (axis, 1, to), scale * scale_f * by_f[axis])


@compiled(**INNER)
def couple(
    weights: Any,
    slopes: Any,
    slope_row: int,
    lead: int,
    tilting: Any,
    coefficients: Any,
    axis: int,
    n: int,
    shape: Any,
    lanes: Any,
) -> None:
    """Sensitivity of an axis' output to earlier outputs: coefficients (3 axes, M lags, columns).

    ``dp_a[k] = ... + sum_b sum_m coefficients[b, m] dp_b[k-1-m]``: through its own lags, and
    through its inputs, which depend on the tilt (sagittal, frontal) extrapolated from the two
    preceding outputs: twice the newer minus the older.
    """
    n_hidden, n_in, n_out = len(shape[0]), len(shape[2]), len(shape[3])
    width, n_features, v = len(lanes), len(shape[2]) + len(shape[3]), VECTOR
    for at in range(0, n * width, 8):
        older_s, older_f = splat(v, 0.0), splat(v, 0.0)
        for m in range(memory(shape)):
            own, e = splat(v, 0.0), splat(v, 0.0)
            for j in range(n_hidden):
                d = load(v, slopes, (slope_row + j, lead + at))
                if m < n_out:
                    own = own + d * spread(v, lanes, weights, (j * n_features + n_in + m, 0))
                if m < n_in:
                    e = e + d * spread(v, lanes, weights, (j * n_features + m, 0))
            through_s, through_f = splat(v, 0.0), splat(v, 0.0)
            if m < n_in:
                back = at + (n_in - 1 - m) * width
                through_s = e * load(v, tilting, (axis, 0, back))
                through_f = e * load(v, tilting, (axis, 1, back))
            if n_out > 1:
                newer_s, newer_f = through_s, through_f
                through_s = newer_s + newer_s - older_s
                through_f = newer_f + newer_f - older_f
                older_s, older_f = newer_s, newer_f
            if axis == 0:
                through_s = through_s + own
            elif axis == 1:
                through_f = through_f + own
            else:
                store(v, coefficients, (axis, 2, m, at), own)
            store(v, coefficients, (axis, 0, m, at), through_s)
            store(v, coefficients, (axis, 1, m, at), through_f)


@compiled(**INNER)
def coupled_propagate(
    rows: Any, coefficients: Any, n_weights: int, n: int, n_axes: int, shape: Any, lanes: Any
) -> None:
    """Convert direct derivatives (3, K, columns) of `n_axes` axes to total ones."""
    width, depth = len(lanes), memory(shape)
    lead = coupled_head(shape, width)
    for i in range(n_weights):
        s = load(lanes, rows, (0, i, lead - width))
        f = load(lanes, rows, (1, i, lead - width))
        for t in range(n):
            at, to = t * width, lead + t * width
            next_s, next_f = load(lanes, rows, (0, i, to)), load(lanes, rows, (1, i, to))
            for m in range(depth - 1, -1, -1):
                if m > 0:
                    lag = to - (m + 1) * width
                    old_s, old_f = load(lanes, rows, (0, i, lag)), load(lanes, rows, (1, i, lag))
                else:
                    old_s, old_f = s, f
                next_s = next_s + load(lanes, coefficients, (0, 1, m, at)) * old_f
                next_s = next_s + load(lanes, coefficients, (0, 0, m, at)) * old_s
                next_f = next_f + load(lanes, coefficients, (1, 0, m, at)) * old_s
                next_f = next_f + load(lanes, coefficients, (1, 1, m, at)) * old_f
            if n_axes == 3:
                heading = load(lanes, rows, (2, i, to))
                for m in range(depth - 1, -1, -1):
                    lag = to - (m + 1) * width
                    old_s, old_f = load(lanes, rows, (0, i, lag)), load(lanes, rows, (1, i, lag))
                    heading = heading + load(lanes, coefficients, (2, 0, m, at)) * old_s
                    heading = heading + load(lanes, coefficients, (2, 1, m, at)) * old_f
                    old = load(lanes, rows, (2, i, lag))
                    heading = heading + load(lanes, coefficients, (2, 2, m, at)) * old
                store(lanes, rows, (2, i, to), heading)
            s, f = next_s, next_f
            store(lanes, rows, (0, i, to), s)
            store(lanes, rows, (1, i, to), f)
