"""Course of a training: cost, damping and gradient by iteration."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

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
        start; values that are not positive are not drawn, nor panels without any. Where
        ``stage`` changes, a dotted line is drawn: cost and gradient jump, since they are those of
        other windows.
    others : sequence of sequence of float
        First quantity of the other starts, drawn faintly.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per quantity.
    """
    drawn = {
        name: values
        for name, values in history.items()
        if name != "stage" and np.isfinite(_positive(values)).any()
    }
    begins = np.flatnonzero(np.diff(np.asarray(history.get("stage", ())))) + 1
    figure, grid = panels(1, max(len(drawn), 1), 2.5, 2.1, sharex=True)
    for k, (panel, (name, values)) in enumerate(zip(grid[0], drawn.items(), strict=False)):
        if k == 0:
            for other in others:
                panel.plot(_positive(other), color="0.6", linewidth=0.6, alpha=0.6)
        panel.plot(_positive(values), color=_COLOURS[k % len(_COLOURS)], linewidth=1.5)
        panel.set_yscale("log")
        for begin in begins:
            panel.axvline(begin, color="0.5", linestyle=":", linewidth=0.8)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
        panel.set(title=name.replace("_deg2", " (deg²)").replace("_", " "), xlabel="iteration")
    figure.suptitle(f"{title}; dotted: next stage" if len(begins) else title)
    return figure


def _positive(values: Sequence[float]) -> np.ndarray:
    array = np.array(values, dtype=float)
    array[~(array > 0)] = np.nan
    return array
