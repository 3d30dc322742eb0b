"""Which rows of a benchmark a figure shows, since twenty lines cannot be told apart."""

from collections.abc import Sequence

import numpy as np

from narx.evaluation.comparison import Evaluated
from narx.experiments.method_labels import method_of, method_order

_MOST_LINES = 6


def most_accurate(pieces: Sequence[Evaluated], axes: Sequence[int] = (0, 1, 2)) -> list[str]:
    """Choose the network and the most accurate other methods, each in its most accurate form.

    Parameters
    ----------
    pieces : sequence of Evaluated
        Trials of one joint or segment.
    axes : sequence of int
        Axes whose errors count, indices into `narx.kinematics.segment_angles.AXES`.

    Returns
    -------
    list of str
        At most six rows, in the order of the tables.
    """
    mean_square = {
        row: _mean_square(pieces, row, list(axes))
        for row in {row for piece in pieces for row in piece.estimates_rad}
    }
    best_form: dict[str, str] = {}
    for row in sorted(mean_square, key=lambda row: (mean_square[row], row)):
        best_form.setdefault(method_of(row), row)
    ranked = sorted(best_form.values(), key=lambda row: (row != "narx", mean_square[row], row))
    return method_order(ranked[:_MOST_LINES])


def _mean_square(pieces: Sequence[Evaluated], row: str, axes: list[int]) -> float:
    errors = [p.error_deg(row)[:, axes].ravel() for p in pieces if row in p.estimates_rad]
    error = np.concatenate(errors)
    finite = error[np.isfinite(error)]
    return float(np.mean(finite**2)) if len(finite) else float("inf")
