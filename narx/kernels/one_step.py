"""Normal equations of the one-step fit to lagged windows, which are independent of each other.

A column is a window, and consecutive windows fill a vector: nothing is carried from one window to
the next, and starts need not run in lockstep.
"""

from typing import Any

from narx.kernels.compiler import JIT, compiled
from narx.kernels.gram import add_products
from narx.kernels.lanes import load, splat, spread, store
from narx.kernels.sizes import SCALAR, VECTOR
from narx.kernels.tanh import activate
from narx.kernels.transfer import TILE_COLUMNS, aligned


@compiled(**JIT)
def one_step_products(
    weights: Any,
    features: Any,
    targets: Any,
    roots: Any,
    part: int,
    first: int,
    last: int,
    sums: Any,
    shape: Any,
    exact: Any,
) -> None:
    """Fill sums (R * parts, K, K, 8) from `first` to `last` with products of rows.

    weights (R, P), features (F, M), targets (M,), roots (M,): square roots of the windows'
    weights, zero for padding; M is a multiple of eight and split into parts of `part`
    windows. Entry ``r * parts + q`` of sums belongs to start r and part q; row P is the
    residuals'.
    """
    n_hidden, n_features = len(shape[0]), len(shape[1])
    bias, slope = n_hidden * n_features, n_hidden * (n_features + 1)
    n_weights, n_windows = weights.shape[1], features.shape[1]
    n_parts = (n_windows + part - 1) // part
    v, s = VECTOR, SCALAR
    rows = aligned(sums.shape[1], TILE_COLUMNS)
    for item in range(first, last):
        r, begin = item // n_parts, item % n_parts * part
        for start in range(begin, min(begin + part, n_windows), TILE_COLUMNS):
            n = min(TILE_COLUMNS, min(begin + part, n_windows) - start)
            for at in range(0, n, 8):
                root = load(v, roots, (start + at,))
                p = spread(v, s, weights, (r, slope + n_hidden)) - load(v, targets, (start + at,))
                for j in range(n_hidden):
                    z = spread(v, s, weights, (r, bias + j))
                    for i in range(n_features):
                        w = spread(v, s, weights, (r, j * n_features + i))
                        z = z + w * load(v, features, (i, start + at))
                    activation = activate(z, exact)
                    w = spread(v, s, weights, (r, slope + j))
                    p = p + w * activation
                    d = (w - (w * activation) * activation) * root
                    store(v, rows, (bias + j, at), d)
                    store(v, rows, (slope + j, at), activation * root)
                    for i in range(n_features):
                        x = load(v, features, (i, start + at))
                        store(v, rows, (j * n_features + i, at), d * x)
                store(v, rows, (slope + n_hidden, at), splat(v, 1.0) * root)
                store(v, rows, (n_weights, at), p * root)
            add_products(rows, 0, n, sums[item])
