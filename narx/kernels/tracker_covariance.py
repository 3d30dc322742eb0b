"""The propagation of the tracker's covariance over one sample, of several sensors side by side."""

from typing import Any

from narx.kernels.compiler import EXACT_VIEWS, compiled
from narx.kernels.functions import load, store
from narx.kernels.tracker_layout import CENTRE, CHANGE, CONSTANT, LEAN, VELOCITY


@compiled(**EXACT_VIEWS)
def _changed(work: Any, source: Any, row: int, out: Any, column: int, lanes: Any) -> None:
    """Fill a column of out with the change of angles and velocity, for states in a row of source.

    Most entries of the matrix are zero. work[CHANGE]: leak of the angles to their centres, coupling
    of the tilt angles in a turn, interval, change of the frontal angle with the lean; with an
    accelerometer that of the velocity with the two tilt angles and with itself.
    """
    leak, coupling = load(lanes, work, (CHANGE, 0, 0)), load(lanes, work, (CHANGE, 1, 0))
    dt, leaning = load(lanes, work, (CHANGE, 2, 0)), load(lanes, work, (CHANGE, 3, 0))
    sagittal, frontal = load(lanes, source, (row, 0, 0)), load(lanes, source, (row, 1, 0))
    transverse, lean = load(lanes, source, (row, 2, 0)), load(lanes, source, (row, LEAN, 0))
    # towards the centre, minus the bias
    drift_s = leak * load(lanes, source, (row, 3, 0)) - dt * load(lanes, source, (row, 6, 0))
    drift_f = leak * load(lanes, source, (row, 4, 0)) - dt * load(lanes, source, (row, 7, 0))
    drift_t = leak * load(lanes, source, (row, 5, 0)) - dt * load(lanes, source, (row, 8, 0))
    store(lanes, out, (0, column, 0), drift_s - leak * sagittal - coupling * frontal)
    turned = drift_f + coupling * sagittal - leak * frontal
    store(lanes, out, (1, column, 0), turned + leaning * lean)
    store(lanes, out, (2, column, 0), drift_t - leak * transverse)
    if len(out) > CENTRE:
        turn = load(lanes, work, (CHANGE, 6, 0))
        forward, sideways = (
            load(lanes, source, (row, VELOCITY, 0)),
            load(lanes, source, (row, VELOCITY + 1, 0)),
        )
        tilted = load(lanes, work, (CHANGE, 4, 0)) * sagittal
        store(lanes, out, (3, column, 0), tilted + turn * sideways)
        tilted = load(lanes, work, (CHANGE, 5, 0)) * frontal
        store(lanes, out, (4, column, 0), tilted - turn * forward)


@compiled(**EXACT_VIEWS)
def propagate(covariance: Any, decay: Any, work: Any, moved: Any, lanes: Any) -> None:
    """Propagate covariances (n, n, W) over one sample: x <- x + change x, two centres times decay.

    moved (3 or 5, n + 1, W) is overwritten.
    """
    n, n_moving = len(covariance), len(moved)
    for i in range(CENTRE, CENTRE + 2):
        for j in range(n):
            store(lanes, covariance, (i, j, 0), load(lanes, covariance, (i, j, 0)) * decay)
            store(lanes, covariance, (j, i, 0), load(lanes, covariance, (j, i, 0)) * decay)
    for j in range(n):
        _changed(work, covariance, j, moved, j, lanes)
    # half of the products, since the matrix is symmetric
    for row in range(n_moving):
        i = row if row < CENTRE else row + CONSTANT
        for j in range(CENTRE, VELOCITY):
            grown = load(lanes, covariance, (i, j, 0)) + load(lanes, moved, (row, j, 0))
            store(lanes, covariance, (i, j, 0), grown)
            store(lanes, covariance, (j, i, 0), grown)
        _changed(work, moved, row, moved, n, lanes)
        for other in range(row + 1):
            j = other if other < CENTRE else other + CONSTANT
            grown = load(lanes, covariance, (i, j, 0)) + load(lanes, moved, (row, j, 0))
            grown = grown + load(lanes, moved, (other, i, 0)) + load(lanes, moved, (other, n, 0))
            store(lanes, covariance, (i, j, 0), grown)
            store(lanes, covariance, (j, i, 0), grown)
