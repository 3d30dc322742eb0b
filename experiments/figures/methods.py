"""Methods side by side: mean over subjects with its interval, and every subject as a dot."""

import pandas as pd
from matplotlib.figure import Figure

from narx.evaluation.significance import bootstrap_mean
from narx.experiments.figures.canvas import logarithmic, panels, styled
from narx.experiments.method_labels import method_colour, method_label, method_order
from narx.experiments.tables.subjects import subject_means
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of


@styled
def methods_figure(
    results: pd.DataFrame,
    quantity: str = "rmse_deg",
    printed: dict[str, float] | None = None,
    seed: int = 0,
    title: str = "",
) -> Figure:
    """Draw one figure of merit of every method, a column an axis and a row a segment.

    Parameters
    ----------
    results : pandas.DataFrame
        Columns of ``results.csv``; sides are averaged.
    quantity : {"rmse_deg", "precision_deg", "r"}
        What is drawn.
    printed : dict of str to float, optional
        Figure of print by axis, drawn as a dashed line.
    seed : int
        Of the bootstrap.
    title : str
        Above everything.

    Returns
    -------
    matplotlib.figure.Figure
        Mean, 95 % bootstrap interval over subjects, a faint dot a subject; errors on a
        logarithmic scale.
    """
    without_side = results["segment"].map(kind_of)
    means = subject_means(results.assign(segment=without_side), ("segment", "axis", "method"))
    segments = list(dict.fromkeys(means["segment"]))
    methods = method_order(means["method"])
    figure, grid = panels(
        len(segments), len(AXES), 2.4, 0.4 + 0.21 * len(methods), sharex=True, sharey=True
    )
    for row, segment in enumerate(segments):
        for column, axis in enumerate(AXES):
            panel = grid[row, column]
            here = means[(means["segment"] == segment) & (means["axis"] == axis)]
            for place, method in enumerate(methods):
                values = here.loc[here["method"] == method, quantity].dropna().to_numpy()
                if not len(values):
                    panel.annotate(
                        "not observed",
                        (0.02, place),
                        xycoords=("axes fraction", "data"),
                        va="center",
                        color="0.5",
                        fontsize=6.5,
                    )
                    continue
                interval = bootstrap_mean(values, seed=seed)
                colour = method_colour(method)
                panel.plot(values, [place] * len(values), "o", color=colour, alpha=0.3, ms=3)
                panel.plot([interval.low, interval.high], [place] * 2, color=colour, lw=1.8)
                panel.plot(interval.mean, place, "D", color=colour, ms=4.5)
            if printed and axis in printed:
                panel.axvline(printed[axis], color="k", linestyle="--", linewidth=0.8)
                panel.annotate(
                    "paper",
                    (printed[axis], 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(2, -7),
                    textcoords="offset points",
                    fontsize=6.5,
                )
            if quantity != "r":
                logarithmic(panel, "x")
            if row == 0:
                panel.set_title(axis)
        grid[row, 0].set_ylabel(segment)
    grid[0, 0].set_yticks(range(len(methods)), [method_label(method) for method in methods])
    grid[0, 0].set_ylim(len(methods) - 0.5, -0.5)
    name = {"rmse_deg": "RMSE (°)", "precision_deg": "precision, SD of the error (°)"}
    for panel in grid[-1]:
        panel.set_xlabel(name.get(quantity, quantity))
    if title:
        figure.suptitle(title)
    return figure
