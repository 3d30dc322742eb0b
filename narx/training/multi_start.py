"""Many starts, a curriculum of problems, and a choice by error on held-out samples.

Networks that fit equally well one step ahead may drift or diverge in closed loop. Therefore many
starts are trained, first on the easy problem (one step ahead), then with growing horizons, then in
closed loop, and the one with the lowest closed-loop error on held-out samples is chosen. Starts
that have ended a stage in the same minimum are trained further as one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from narx.errors import UserError
from narx.kernels.threads import in_threads
from narx.network.structure import NarxStructure
from narx.training.least_squares.problem import LeastSquaresProblem
from narx.training.least_squares.solver import Options, Result, levenberg_marquardt
from narx.training.least_squares.stopping import ResultCode
from narx.training.progress import Progress
from narx.training.same_minimum import first_alike
from narx.training.stages import Stage
from narx.types import FloatArray

# starts that are trained in parallel, as one thread's unit of work; fixed, so that results do not
# depend on the number of threads
_TOGETHER = 16


@dataclass(frozen=True)
class MultiStartResult:
    """Results of all starts.

    Parameters
    ----------
    weights : ndarray, shape (P,)
        Weights of the best start.
    best : int
        Index of the best start.
    errors : ndarray, shape (R,)
        Root of the weighted mean of squared residuals of every start on the held-out samples;
        not finite where it diverged.
    n_dropped : int
        Starts whose error is not finite.
    all_weights : ndarray, shape (R, P)
        Weights of every start.
    stages : dict of str to list
        For each stage, by name, the results of the starts, in groups.
    rows : ndarray of int, shape (stages, R)
        Row of each start in the result of its group: the same for starts that were trained as one.
    """

    weights: FloatArray
    best: int
    errors: FloatArray
    n_dropped: int
    all_weights: FloatArray
    stages: dict[str, list[Result]]
    rows: NDArray[np.int64]

    @property
    def code(self) -> ResultCode:
        """Reason for which the best start has stopped."""
        last = list(self.stages.values())[-1][self.best // _TOGETHER]
        return last.codes[self.rows[-1, self.best]]

    def history(self, stages: Sequence[Stage], start: int | None = None) -> list[dict[str, float]]:
        """List the iterations of a start through all stages.

        Parameters
        ----------
        stages : sequence of Stage
            The stages that were run.
        start : int, optional
            Index of the start; by default the best.

        Returns
        -------
        list of dict
            ``stage`` (its number), ``cost_deg2`` (the stage's mean square), ``damping`` and
            ``gradient`` of each iteration.
        """
        start = self.best if start is None else start
        rows = []
        for number, (stage, results) in enumerate(zip(stages, self.stages.values(), strict=True)):
            result, column = results[start // _TOGETHER], self.rows[number, start]
            for i in range(result.n_evaluations[column] + 1):
                rows.append(
                    {
                        "stage": float(number),
                        "cost_deg2": 2.0
                        * float(result.history["cost"][i, column])
                        * stage.mean_square,
                        "damping": float(result.history["damping"][i, column]),
                        "gradient": float(result.history["gradient"][i, column]),
                    }
                )
        return rows


class _Group:
    """Starts that are trained together through all stages; an interrupted training is continued.

    Parameters
    ----------
    first : int
        Number of the first start.
    log : callable or None
        As for `multi_start`; what was logged before the cut is logged again.
    progress : Progress
        Keeps the state.
    """

    def __init__(
        self,
        first: int,
        log: Callable[[int, FloatArray, float], None] | None,
        progress: Progress,
    ) -> None:
        self._first, self._log, self._progress = first, log, progress
        kept = progress.of(self._name) or {"results": [], "running": None, "costs": []}
        self.results = [_result(one) for one in kept["results"]]
        self.rows: list[NDArray[np.int64]] = []
        self._running = kept["running"]
        self._costs: list[tuple[FloatArray, float]] = []
        for cost, mean_square in kept["costs"]:
            self._add(mean_square, cost.numpy())

    @property
    def _name(self) -> str:
        return f"group from {self._first}"

    def _add(self, mean_square: float, cost: FloatArray) -> None:
        self._costs.append((cost, mean_square))
        if self._log is not None:
            self._log(self._first, cost, mean_square)

    def train(
        self,
        stages: Sequence[Stage],
        weights: FloatArray,
        structure: NarxStructure | None,
        options: Options,
        trainable: ArrayLike | None,
        low_enough: float,
    ) -> None:
        rows = np.arange(len(weights))
        for number, stage in enumerate(stages):
            alike = np.arange(len(weights))
            if structure is not None:
                alike = first_alike(weights, structure)
            distinct, of_row = np.unique(alike, return_inverse=True)
            rows = of_row[rows]
            if number == len(self.results):
                squares = low_enough / stage.mean_square
                result = levenberg_marquardt(
                    stage.problem,
                    weights[distinct],
                    replace(options, stopping=replace(options.stopping, squares=squares)),
                    trainable=trainable,
                    log=partial(self._add_distinct, stage.mean_square, rows),
                    state=self._running,
                    keep=self._keep,
                )
                self._running = None
                self.results.append(result)
            self.rows.append(rows)
            weights = self.results[number].weights

    def _add_distinct(self, mean_square: float, rows: NDArray[np.int64], cost: FloatArray) -> None:
        of_starts = np.full(len(rows), np.nan)
        of_starts[np.unique(rows, return_index=True)[1]] = cost
        self._add(mean_square, of_starts)

    def _keep(self, running: Callable[[], dict[str, Any]]) -> None:
        self._progress.keep(
            self._name,
            lambda: {
                "results": [
                    vars(result) | {"codes": [code.value for code in result.codes]}
                    for result in self.results
                ],
                "running": running(),
                "costs": self._costs,
            },
        )


def _result(kept: Mapping[str, Any]) -> Result:
    arrays = {
        name: value.numpy() if isinstance(value, Tensor) else value for name, value in kept.items()
    }
    history = {name: value.numpy() for name, value in kept["history"].items()}
    codes = [ResultCode(code) for code in kept["codes"]]
    return Result(**arrays | {"history": history, "codes": codes})


def multi_start(
    stages: Sequence[Stage],
    starts: ArrayLike,
    validation: LeastSquaresProblem,
    options: Options | None = None,
    *,
    structure: NarxStructure | None = None,
    trainable: ArrayLike | None = None,
    low_enough: float = 0.0,
    log: Callable[[int, FloatArray, float], None] | None = None,
    progress: Progress | None = None,
) -> MultiStartResult:
    """Train from many starts, in threads, and choose the best on held-out samples.

    Parameters
    ----------
    stages : sequence of Stage
        Problems, each started from the result of the previous one.
    starts : array_like, shape (R, P)
        Weights to start from.
    validation : LeastSquaresProblem
        Closed-loop fit to held-out samples.
    options : Options, optional
        Options of the solver; defaults if not given.
    structure : NarxStructure, optional
        Sizes of the network, with which starts in the same minimum are found; without it, every
        start is trained by itself.
    trainable : array_like of bool, shape (P,), optional
        Weights that may change; by default all.
    low_enough : float
        A start ends a stage whose mean square (`Stage.mean_square`) is as low as this.
    log : callable, optional
        Called after each iteration of a group of starts, possibly from several threads, with the
        number of its first start, the starts' costs (NaN where a start has stopped, or is trained
        as one with an earlier start), and the stage's factor to mean squares.
    progress : Progress, optional
        State of this training where it was cut off, kept from then on.

    Returns
    -------
    MultiStartResult
        The best start and the spread of all; independent of the number of threads.

    Raises
    ------
    UserError
        If no start has a finite error.
    """
    options = options or Options()
    weights = np.atleast_2d(np.array(starts, dtype=np.float64))
    n_starts = len(weights)
    errors = np.full(n_starts, np.nan)
    groups: dict[int, _Group] = {}

    def train(first: int, last: int) -> None:
        for group in range(first, last, _TOGETHER):
            of_group = slice(group, min(group + _TOGETHER, last))
            one = _Group(group, log, Progress() if progress is None else progress)
            one.train(stages, weights[of_group], structure, options, trainable, low_enough)
            groups[group] = one
            ends, rows = one.results[-1].weights, one.rows[-1]
            squares = validation.products(ends)[rows, -1, -1]
            weights[of_group] = ends[rows]
            errors[of_group] = np.sqrt(squares / max(validation.total_weight, 1e-300))

    in_threads(train, n_starts, _TOGETHER)
    in_order = [groups[number] for number in sorted(groups)]
    results = {
        stage.name: [group.results[number] for group in in_order]
        for number, stage in enumerate(stages)
    }
    rows = np.concatenate([group.rows for group in in_order], axis=1)
    finite = np.isfinite(errors)
    if not finite.any():
        raise UserError(f"training: none of {n_starts} starts stayed finite in closed loop")
    best = int(np.argmin(np.where(finite, errors, np.inf)))
    return MultiStartResult(
        weights[best].copy(), best, errors, int((~finite).sum()), weights, results, rows
    )
