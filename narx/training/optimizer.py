"""Common parts of all optimisers: ranges of settings, starts, and the report of their spread."""

from collections.abc import Sequence

import numpy as np

from narx.network.model import Narx
from narx.training.initial_weights import random_weights
from narx.training.ranges import between, whole
from narx.training.stages import check_curriculum
from narx.types import FloatArray

# limits of time and memory
_MOST_RESTARTS, _MOST_ITERATIONS = 10_000, 1_000_000


def check_common(
    restarts: int,
    iterations: int,
    curriculum: Sequence[str | int],
    prior_deg2: float,
    cost_change: float,
) -> None:
    """Refuse settings that no optimiser can take.

    Parameters
    ----------
    restarts, iterations : int
        Starts, and iterations of each.
    curriculum : sequence of {"open", int, "closed"}
        Stages.
    prior_deg2 : float
        Strength of the prior, deg^2.
    cost_change : float
        Share of the cost by which a step must lower it.

    Raises
    ------
    UserError
        Naming the field, its value and what is allowed.
    """
    whole("optimizer.restarts", restarts, 1, _MOST_RESTARTS)
    whole("optimizer.iterations", iterations, 0, _MOST_ITERATIONS)
    check_curriculum(curriculum)
    between("optimizer.prior_deg2", prior_deg2, 0.0)
    between("optimizer.cost_change", cost_change, 0.0, 1.0)


def starts_of(
    model: Narx,
    rng: np.random.Generator,
    restarts: int,
    curriculum: Sequence[str | int],
    start: FloatArray | None,
) -> tuple[FloatArray, Sequence[str | int]]:
    """Choose the starts of a training and its stages.

    Parameters
    ----------
    model : Narx
        Network.
    rng : numpy.random.Generator
        Draws the starts.
    restarts : int
        Number of starts.
    curriculum : sequence of {"open", int, "closed"}
        All stages.
    start : ndarray, shape (P,), optional
        Weights of a trained network.

    Returns
    -------
    starts : ndarray, shape (R, P)
        Random, or the one that is given.
    curriculum : sequence of {"open", int, "closed"}
        All stages, or the last one: earlier ones would move away from a trained network.
    """
    if start is not None:
        return np.array(start, dtype=np.float64)[None], curriculum[-1:]
    return np.array([random_weights(model, rng) for _ in range(restarts)]), curriculum


def restart_tag(restart: int) -> str:
    """Name a restart in logs.

    Parameters
    ----------
    restart : int
        Its number, from zero.

    Returns
    -------
    str
        Such as ``restart_03``.
    """
    return f"restart_{restart:02d}"


def spread_report(errors_deg: FloatArray) -> dict[str, float]:
    """Summarise the errors of restarts.

    Parameters
    ----------
    errors_deg : ndarray, shape (R,)
        Closed-loop error of each on held-out samples, deg; not finite if it diverged. At
        least one is finite.

    Returns
    -------
    dict of str to float
        Number of restarts, number dropped, and least, median and largest error.
    """
    finite = errors_deg[np.isfinite(errors_deg)]
    return {
        "restarts": float(len(errors_deg)),
        "dropped": float(len(errors_deg) - len(finite)),
        "validation_rmse_best_deg": float(finite.min()),
        "validation_rmse_median_deg": float(np.median(finite)),
        "validation_rmse_worst_deg": float(finite.max()),
    }
