"""Common parts of all optimisers: types of settings, starts, and the report of their spread."""

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from narx.network.model import Narx
from narx.training.initial_weights import random_weights
from narx.types import FloatArray

# upper limits: time and memory
StartCount = Annotated[int, Field(ge=1, le=10_000)]
IterationCount = Annotated[int, Field(ge=0, le=1_000_000)]
NotNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Curriculum = Annotated[
    tuple[Literal["open", "closed"] | Annotated[int, Field(ge=2)], ...],
    Field(
        min_length=1,
        description="open, closed or a number of samples ahead (2 or more), in a list such as "
        "[open, closed]",
    ),
]


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
        Random starts, or the given one.
    curriculum : sequence of {"open", int, "closed"}
        All stages, or only the last for a trained network, from which earlier ones would move away.
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
        Name such as ``restart_03``.
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
        Number of restarts, number dropped, and smallest, median and largest error.
    """
    finite = errors_deg[np.isfinite(errors_deg)]
    return {
        "restarts": float(len(errors_deg)),
        "dropped": float(len(errors_deg) - len(finite)),
        "validation_rmse_best_deg": float(finite.min()),
        "validation_rmse_median_deg": float(np.median(finite)),
        "validation_rmse_worst_deg": float(finite.max()),
    }
