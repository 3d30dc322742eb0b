"""Errors over time: with the linear drift of Han et al. (Fig. 8), and in blocks over hours."""

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure

from narx.evaluation.comparison import Evaluated
from narx.evaluation.drift import block_errors
from narx.experiments.figures.canvas import legend_below, logarithmic, panels, styled
from narx.experiments.method_labels import drawn_rows, line_styles, method_colour, method_label
from narx.kinematics.segment_angles import AXES


@styled
def linear_drift(
    columns: Sequence[tuple[str, Evaluated]],
    start_s: float,
    stop_s: float,
    methods: Sequence[str] = ("two_point", "gyro_integration"),
    drifting: str = "gyro_integration",
    title: str = "",
) -> Figure:
    """Draw errors over a walk with a straight line through one of them at its start and stop.

    Parameters
    ----------
    columns : sequence of (str, Evaluated)
        Title and segment, such as thigh and shank of one walk, standing included.
    start_s, stop_s : float
        Start A and stop B of walking.
    methods : sequence of str
        Methods whose errors are drawn.
    drifting : str
        Method whose errors at A and B define the line.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        One row per axis. Only here, errors are estimate minus reference, as in the paper, because
        the method subtracts the drift.
    """
    styles = line_styles(methods)
    figure, grid = panels(len(AXES), len(columns), 3.2, 1.5, sharex="col")
    for row, name in enumerate(AXES):
        for column, (heading, piece) in enumerate(columns):
            panel = grid[row, column]
            for method in methods:
                if method not in piece.estimates_rad:
                    continue
                error = np.rad2deg(piece.estimates_rad[method] - piece.reference_rad)[:, row]
                panel.plot(
                    piece.time_s,
                    error,
                    color=method_colour(method),
                    linestyle=styles[method],
                    label=method_label(method),
                )
                valid = np.isfinite(error)
                if method == drifting and valid.any():
                    ends = np.interp((start_s, stop_s), piece.time_s[valid], error[valid])
                    panel.plot(
                        (start_s, stop_s),
                        ends,
                        color="#007a33",
                        linestyle=":",
                        marker="o",
                        markersize=3,
                        linewidth=1.6,
                        label="linear drift A to B",
                    )
            panel.axhline(0.0, color="0.4", linewidth=0.7)
            for mark, letter in ((start_s, "A"), (stop_s, "B")):
                panel.axvline(mark, color="0.5", linewidth=0.8, linestyle=":")
                if row == 0:
                    panel.annotate(
                        letter,
                        (mark, 1.0),
                        xycoords=("data", "axes fraction"),
                        xytext=(2, -8),
                        textcoords="offset points",
                        fontweight="bold",
                    )
            panel.margins(x=0)
            if row == 0:
                panel.set_title(heading)
            if row == len(AXES) - 1:
                panel.set_xlabel("time (s)")
        grid[row, 0].set_ylabel(f"{name}\nestimate - reference (°)")
    legend_below(figure, grid[0, 0])
    if title:
        figure.suptitle(title)
    return figure


@styled
def error_over_time(
    evaluated: Iterable[Evaluated],
    methods: Sequence[str] | None = None,
    block_s: float = 10.0,
    title: str = "",
) -> Figure:
    """Draw the RMSE of successive blocks, one thin line per trial and a thick one their mean.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Long trials of one joint or segment.
    methods : sequence of str, optional
        Rows of the benchmark to draw; by default those of `drawn_rows`.
    block_s : float
        Length of a block, s.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        One panel per axis, RMSE on a logarithmic scale, time in minutes.
    """
    trials = list(evaluated)
    if methods is None:
        methods = drawn_rows(m for trial in trials for m in trial.estimates_rad)
    styles = line_styles(methods)
    figure, grid = panels(1, len(AXES), 2.6, 2.2, sharey=True)
    for axis, name in enumerate(AXES):
        panel = grid[0, axis]
        for method in methods:
            curves = []
            for trial in trials:
                if method not in trial.estimates_rad:
                    continue
                error = np.deg2rad(trial.error_deg(method)[:, axis])
                middle, value = block_errors(trial.time_s, error, block_s)
                panel.plot(middle / 60, value, color=method_colour(method), alpha=0.2, lw=0.6)
                curves.append(dict(zip(np.round(middle, 3), value, strict=True)))
            times = sorted({moment for curve in curves for moment in curve})
            mean = [np.mean([c[moment] for c in curves if moment in c]) for moment in times]
            panel.plot(
                np.array(times) / 60,
                mean,
                color=method_colour(method),
                label=method_label(method),
                linestyle=styles[method],
                linewidth=1.8,
            )
        logarithmic(panel, "y")
        panel.set_title(name)
        panel.set_xlabel("time (min)")
    grid[0, 0].set_ylabel(f"RMSE of each {block_s:g} s (°)")
    legend_below(figure, grid[0, 0])
    if title:
        figure.suptitle(title)
    return figure
