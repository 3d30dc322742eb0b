"""Random starts that are trained one after another by gradients.

A start that ends a stage in the same minimum as an earlier one takes over the earlier one's end.
"""

import sys
from collections.abc import Callable

import numpy as np

from narx.network.structure import NarxStructure
from narx.training.objective import Log
from narx.training.optimizer import restart_tag
from narx.training.progress import Progress, State
from narx.training.same_minimum import first_alike
from narx.types import FloatArray

_PART = "starts one after another"


class Restarts:
    """Restarts that are trained one after another, from where they were cut off.

    Parameters
    ----------
    log : callable
        As for `Optimizer.fit`; what was logged before the cut is logged again.
    progress : Progress
        Keeps the state.
    """

    def __init__(self, log: Log, progress: Progress) -> None:
        self._log, self._progress = log, progress
        state = progress.of(_PART) or {"ends": [], "passed": [], "histories": []}
        self.ends: list[FloatArray] = [end.numpy() for end in state["ends"]]
        # weights at the end of each stage of each restart
        self._passed = [[weights.numpy() for weights in one] for one in state["passed"]]
        self.histories: list[list[dict[str, float]]] = []
        for history in state["histories"]:
            self.histories.append([])
            for numbers in history:
                # a checkpoint is written alike only if equal names are one object
                self.record({sys.intern(name): value for name, value in numbers.items()})
        self._resumed = "stage" in state
        if self._resumed:
            self.stage, self.weights = state["stage"], state["weights"].numpy()
            self.descent: State | None = state["descent"]

    def begin(self, weights: FloatArray) -> None:
        """Begin the next restart, unless one is in the middle.

        Parameters
        ----------
        weights : ndarray, shape (P,)
            Its start.
        """
        if self._resumed:
            self._resumed = False
            return
        self.stage, self.weights, self.descent = 0, weights, None
        self.histories.append([])
        self._passed.append([])

    def record(self, numbers: dict[str, float]) -> None:
        """Add an iteration to the history of the restart, and log its cost.

        Parameters
        ----------
        numbers : dict of str to float
            ``stage``, ``cost_deg2`` and ``gradient``.
        """
        restart, history = len(self.histories) - 1, self.histories[-1]
        self._log(len(history), {f"{restart_tag(restart)}/cost_deg2": numbers["cost_deg2"]})
        history.append(numbers)

    def end_stage(self, weights: FloatArray, structure: NarxStructure) -> bool:
        """Go on to the next stage, unless an earlier restart has gone on from there.

        Parameters
        ----------
        weights : ndarray, shape (P,)
            Result of this one.
        structure : NarxStructure
            Sizes of the network.

        Returns
        -------
        bool
            False if the restart has the end of an earlier one.
        """
        self.weights, self.descent = weights, None
        self._passed[-1].append(weights)
        self.stage += 1
        numbers = [i for i, one in enumerate(self._passed) if len(one) >= self.stage]
        there = np.array([self._passed[i][self.stage - 1] for i in numbers])
        first = numbers[first_alike(there, structure)[-1]]
        if first == numbers[-1]:
            return True
        self.weights = self.ends[first]
        return False

    def end(self) -> None:
        """End the restart with the weights that it has."""
        self.ends.append(self.weights)

    def keep(self, descent: Callable[[], State]) -> None:
        """Keep the state.

        Parameters
        ----------
        descent : callable
            Returns the state within the stage.
        """
        self._progress.keep(
            _PART,
            lambda: {
                "ends": self.ends,
                "passed": self._passed,
                "histories": self.histories,
                "stage": self.stage,
                "weights": self.weights,
                "descent": descent(),
            },
        )
