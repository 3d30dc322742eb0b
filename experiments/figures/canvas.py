"""Common parts of all figures: style, a canvas without global state, and saving."""

import functools
import os
from collections.abc import Callable
from typing import Any, Literal, ParamSpec, cast

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from narx.files import atomic_path

P = ParamSpec("P")

# anatomical meaning of the axes
ANGLE_NAMES = (
    "flexion (+) / extension",
    "abduction (+) / adduction",
    "internal (+) / external rot.",
)
REFERENCE_COLOUR = "#000000"

# of a legend in 8 point
_ROW_INCHES = 0.2

_STYLE = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.titleweight": "bold",
    "axes.labelsize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.titlesize": 9.5,
    "figure.titleweight": "bold",
}


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw in the common style, whatever the global settings of matplotlib.

    Parameters
    ----------
    draw : callable
        Makes a figure.

    Returns
    -------
    callable
        The same, drawn in the common style.
    """

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with style.context(["default", _STYLE]):
            return draw(*args, **kwargs)

    return drawn


def panels(
    rows: int, columns: int, width: float = 2.6, height: float = 1.9, **options: Any
) -> tuple[Figure, NDArray[np.object_]]:
    """Create a figure with a grid of axes, independent of pyplot.

    Parameters
    ----------
    rows, columns : int
        Grid.
    width, height : float
        Of one panel, inches.
    **options
        Passed on to `matplotlib.figure.Figure.subplots`.

    Returns
    -------
    figure : matplotlib.figure.Figure
        With a pixel canvas, as required by TensorBoard.
    axes : ndarray of matplotlib.axes.Axes, shape (rows, columns)
        The grid.
    """
    figure = Figure(figsize=(columns * width + 0.6, rows * height + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def legend_below(figure: Figure, axes: Axes) -> None:
    """Put one legend for the whole figure below its panels, clear of the title above.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        With constrained layout, which makes room for the legend.
    axes : matplotlib.axes.Axes
        Panel whose labelled lines are listed.
    """
    handles, labels = axes.get_legend_handles_labels()
    if not labels:
        return
    # constrained layout reserves room for a legend below the panels, but none beside it
    canvas = cast(FigureCanvasAgg, figure.canvas)
    for columns in range(len(labels), 0, -1):
        legend = figure.legend(handles, labels, loc="outside lower center", ncols=columns)
        extent = legend.get_window_extent(canvas.get_renderer())
        if columns == 1 or extent.width <= figure.bbox.width:
            break
        legend.remove()
    # the panels keep their size however many lines are listed
    rows = -(-len(labels) // columns)
    figure.set_figheight(figure.get_figheight() + rows * _ROW_INCHES)


def logarithmic(panel: Axes, which: Literal["x", "y"]) -> None:
    """Make a scale logarithmic, with plain numbers beside it (2 and 5 if there is room).

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        Axes to change.
    which : {"x", "y"}
        Which of its scales.
    """
    panel.set(**{f"{which}scale": "log"})
    axis = panel.xaxis if which == "x" else panel.yaxis
    axis.set_major_formatter("{x:g}")

    def between_decades(value: float, _: object) -> str:
        low, high = np.sort(axis.get_view_interval())
        room = low > 0 and high / low < 50
        return f"{value:g}" if room and f"{value:e}"[0] in "25" else ""

    axis.set_minor_formatter(between_decades)


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure; the suffix determines the format.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Any figure.
    path : path-like
        Such as ``figures/spectrum.png``; written completely or not at all.
    """
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=160)
