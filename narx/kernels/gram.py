"""Products of all pairs of rows, summed over the columns: the normal matrix of a tile.

The last row before the padding contains the residuals, so one product gives matrix, gradient and
cost. Sixteen sums are held in registers at a time.
"""

from typing import Any

from narx.kernels.compiler import INNER, JIT, compiled
from narx.kernels.lanes import load, store
from narx.kernels.sizes import VECTOR

BLOCK = 4


@compiled(**INNER)
def add_products(rows: Any, start: int, stop: int, sums: Any) -> None:
    """Add rows[i] * rows[j] to sums[i, j], lower triangle of blocks.

    Rows are (K, columns) with K a multiple of four; sums (K, K, 8): columns `start` to `stop`, a
    multiple of eight, are distributed over the eight lanes.
    """
    v = VECTOR
    for i in range(0, rows.shape[0], BLOCK):
        for j in range(0, i + BLOCK, BLOCK):
            s00 = load(v, sums, (i, j, 0))
            s01 = load(v, sums, (i, j + 1, 0))
            s02 = load(v, sums, (i, j + 2, 0))
            s03 = load(v, sums, (i, j + 3, 0))
            s10 = load(v, sums, (i + 1, j, 0))
            s11 = load(v, sums, (i + 1, j + 1, 0))
            s12 = load(v, sums, (i + 1, j + 2, 0))
            s13 = load(v, sums, (i + 1, j + 3, 0))
            s20 = load(v, sums, (i + 2, j, 0))
            s21 = load(v, sums, (i + 2, j + 1, 0))
            s22 = load(v, sums, (i + 2, j + 2, 0))
            s23 = load(v, sums, (i + 2, j + 3, 0))
            s30 = load(v, sums, (i + 3, j, 0))
            s31 = load(v, sums, (i + 3, j + 1, 0))
            s32 = load(v, sums, (i + 3, j + 2, 0))
            s33 = load(v, sums, (i + 3, j + 3, 0))
            for t in range(start, stop, 8):
                b0 = load(v, rows, (j, t))
                b1 = load(v, rows, (j + 1, t))
                b2 = load(v, rows, (j + 2, t))
                b3 = load(v, rows, (j + 3, t))
                a = load(v, rows, (i, t))
                s00 = s00 + a * b0
                s01 = s01 + a * b1
                s02 = s02 + a * b2
                s03 = s03 + a * b3
                a = load(v, rows, (i + 1, t))
                s10 = s10 + a * b0
                s11 = s11 + a * b1
                s12 = s12 + a * b2
                s13 = s13 + a * b3
                a = load(v, rows, (i + 2, t))
                s20 = s20 + a * b0
                s21 = s21 + a * b1
                s22 = s22 + a * b2
                s23 = s23 + a * b3
                a = load(v, rows, (i + 3, t))
                s30 = s30 + a * b0
                s31 = s31 + a * b1
                s32 = s32 + a * b2
                s33 = s33 + a * b3
            store(v, sums, (i, j, 0), s00)
            store(v, sums, (i, j + 1, 0), s01)
            store(v, sums, (i, j + 2, 0), s02)
            store(v, sums, (i, j + 3, 0), s03)
            store(v, sums, (i + 1, j, 0), s10)
            store(v, sums, (i + 1, j + 1, 0), s11)
            store(v, sums, (i + 1, j + 2, 0), s12)
            store(v, sums, (i + 1, j + 3, 0), s13)
            store(v, sums, (i + 2, j, 0), s20)
            store(v, sums, (i + 2, j + 1, 0), s21)
            store(v, sums, (i + 2, j + 2, 0), s22)
            store(v, sums, (i + 2, j + 3, 0), s23)
            store(v, sums, (i + 3, j, 0), s30)
            store(v, sums, (i + 3, j + 1, 0), s31)
            store(v, sums, (i + 3, j + 2, 0), s32)
            store(v, sums, (i + 3, j + 3, 0), s33)


@compiled(**JIT)
def fold(sums: Any, products: Any) -> None:
    """Turn sums (G, K, K, 8) of groups into products (R, S, S), lower triangles.

    With one start all groups and lanes are summed in order; with several, each start has a lane.
    """
    n_starts, size = len(products), products.shape[1]
    for r in range(n_starts):
        for i in range(size):
            for j in range(i + 1):
                if n_starts > 1:
                    products[r, i, j] = sums[r // 8, i, j, r % 8]
                else:
                    total = 0.0
                    for group in range(len(sums)):
                        for lane in range(8):
                            total += sums[group, i, j, lane]
                    products[r, i, j] = total
