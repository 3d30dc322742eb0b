"""Random starts that are trained one after another by gradients."""

import sys
from collections.abc import Callable

from narx.training.objective import Log
from narx.training.optimizer import restart_tag
from narx.training.progress import Progress, State
from narx.types import FloatArray


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
        state = progress.of("restarts") or {"ends": [], "histories": []}
        self.ends: list[FloatArray] = [end.numpy() for end in state["ends"]]
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

    def end_stage(self, weights: FloatArray) -> None:
        """Go on to the next stage.

        Parameters
        ----------
        weights : ndarray, shape (P,)
            Result of this one.
        """
        self.stage, self.weights, self.descent = self.stage + 1, weights, None

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
            "restarts",
            lambda: {
                "ends": self.ends,
                "histories": self.histories,
                "stage": self.stage,
                "weights": self.weights,
                "descent": descent(),
            },
        )
