"""States of the tracker, and the propagation of their covariance over one sample."""

from typing import Any

from narx.kernels.compiler import EXACT_INNER, compiled

# states of the filter; the last two only with an accelerometer
ANGLES, CENTRE, BIAS, LEAN, VELOCITY = 0, 3, 6, 9, 10
GYROSCOPE_STATES, AIDED_STATES = 10, 12
# centre, bias and lean are constant from sample to sample
CONSTANT = VELOCITY - CENTRE

# row of the intermediate results of `narx.kernels.tracker.step` with the changes of a sample
CHANGE = 5


@compiled(**EXACT_INNER)
def _changed(work: Any, source: Any, row: int, out: Any, column: int) -> None:
    """Fill a column of out with the change of angles and velocity, for states in a row of source.

    Most entries of the matrix are zero. work[CHANGE]: leak of the angles to their centres, coupling
    of the tilt angles in a turn, interval, change of the frontal angle with the lean; with an
    accelerometer that of the velocity with the two tilt angles and with itself.
    """
    leak, coupling, dt = work[CHANGE, 0], work[CHANGE, 1], work[CHANGE, 2]
    sagittal, frontal = source[row, 0], source[row, 1]
    out[0, column] = (
        -leak * sagittal - coupling * frontal + leak * source[row, 3] - dt * source[row, 6]
    )
    out[1, column] = (
        coupling * sagittal - leak * frontal + leak * source[row, 4] - dt * source[row, 7]
    ) + work[CHANGE, 3] * source[row, LEAN]
    out[2, column] = -leak * source[row, 2] + leak * source[row, 5] - dt * source[row, 8]
    if work.shape[1] > VELOCITY:
        turn = work[CHANGE, 6]
        out[3, column] = work[CHANGE, 4] * sagittal + turn * source[row, VELOCITY + 1]
        out[4, column] = work[CHANGE, 5] * frontal - turn * source[row, VELOCITY]


@compiled(**EXACT_INNER)
def propagate(covariance: Any, decay: float, work: Any, moved: Any) -> None:
    """Propagate the covariance over one sample: x <- x + change x, two centres times `decay`.

    moved (5, n + 1) is overwritten.
    """
    n = len(covariance)
    n_moving = n - CONSTANT
    if decay != 1.0:
        for i in range(CENTRE, CENTRE + 2):
            for j in range(n):
                covariance[i, j] *= decay
                covariance[j, i] *= decay
    for j in range(n):
        _changed(work, covariance, j, moved, j)
    # half of the products, since the matrix is symmetric
    for row in range(n_moving):
        i = row if row < CENTRE else row + CONSTANT
        for j in range(CENTRE, VELOCITY):
            covariance[i, j] += moved[row, j]
            covariance[j, i] = covariance[i, j]
        _changed(work, moved, row, moved, n)
        for other in range(row + 1):
            j = other if other < CENTRE else other + CONSTANT
            covariance[i, j] += moved[row, j] + moved[other, i] + moved[other, n]
            covariance[j, i] = covariance[i, j]
