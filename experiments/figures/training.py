"""Course of a training: cost, damping and gradient by iteration."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from narx.experiments.figures.canvas import panels, styled

_COLOURS = ("#c8102e", "#0060b0", "#009e73", "#e69f00", "#7b3fa0")


@styled
def training_figure(
    history: Mapping[str, Sequence[float]],
    others: Sequence[Sequence[float]] = (),
    title: str = "Training",
) -> Figure:
    """Draw the history of a training, one panel per quantity, on logarithmic scales.

    Parameters
    ----------
    history : mapping of str to sequence of float
        By quantity (``cost``, ``damping``, ``gradient``, ...), one value per iteration of the best
        restart; values that are not positive are not drawn, nor panels without any.
    others : sequence of sequence of float
        First quantity of the other restarts, drawn faintly.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per quantity.
    """
    drawn = {name: v for name, v in history.items() if np.isfinite(_positive(v)).any()}
    figure, grid = panels(1, max(len(drawn), 1), 2.5, 2.1)
    for k, (panel, (name, values)) in enumerate(zip(grid[0], drawn.items(), strict=False)):
        if k == 0:
            for other in others:
                panel.plot(_positive(other), color="0.6", linewidth=0.6, alpha=0.6)
        panel.plot(_positive(values), color=_COLOURS[k % len(_COLOURS)], linewidth=1.5)
        panel.set_yscale("log")
        panel.set(title=name.replace("_", " "), xlabel="iteration")
    figure.suptitle(title)
    return figure


def _positive(values: Sequence[float]) -> np.ndarray:
    array = np.array(values, dtype=float)
    array[~(array > 0)] = np.nan
    return array
