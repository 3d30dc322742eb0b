"""What a run shows in TensorBoard."""

from pathlib import Path
from types import TracebackType

import pandas as pd
from matplotlib.figure import Figure
from torch.utils.tensorboard import SummaryWriter

from narx.training.objective import Log


class TensorBoardLog:
    """Event file of one run, closed at the end of a `with` block.

    Parameters
    ----------
    directory : pathlib.Path
        Where the event file goes.
    """

    def __init__(self, directory: Path) -> None:
        self._writer = SummaryWriter(str(directory))

    def __enter__(self) -> "TensorBoardLog":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._writer.close()

    def for_fold(self, fold: str) -> Log:
        """Return what an optimizer calls once an iteration.

        Parameters
        ----------
        fold : str
            Name under which the curves appear.

        Returns
        -------
        callable
            ``log(iteration, numbers)``.
        """

        def log(iteration: int, numbers: dict[str, float]) -> None:
            for name, value in numbers.items():
                self._writer.add_scalar(f"training/{fold}/{name}", value, iteration)

        return log

    def results(self, results: pd.DataFrame) -> None:
        """Show the mean RMSE of every segment, axis and method.

        Parameters
        ----------
        results : pandas.DataFrame
            Columns of ``results.csv``.
        """
        means = results.groupby(["segment", "axis", "method"])["rmse_deg"].mean().dropna()
        for names, value in zip(means.index.to_frame(index=False).to_numpy(), means, strict=True):
            self._writer.add_scalar("/".join(["rmse_deg", *map(str, names)]), value)

    def figure(self, name: str, figure: Figure) -> None:
        """Show a figure.

        Parameters
        ----------
        name : str
            Its tag.
        figure : matplotlib.figure.Figure
            What to show.
        """
        self._writer.add_figure(name, figure, close=False)
