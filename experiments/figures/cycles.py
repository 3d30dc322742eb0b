"""Angles over the gait cycle in the clinical layout: one row per joint, mean and band."""

import pandas as pd
from matplotlib.figure import Figure

from narx.experiments.figures.canvas import ANGLE_NAMES, panels, styled
from narx.kinematics.segment_angles import AXES
from narx.recordings.trial import kind_of, side_of

_JOINTS = ("hip", "knee", "ankle")
_COLOURS = {"right": "#0072b2", "left": "#d55e00"}


@styled
def cycle_figure(cycles: pd.DataFrame, title: str) -> Figure:
    """Draw mean and standard deviation over the gait cycle.

    Parameters
    ----------
    cycles : pandas.DataFrame
        From `narx.experiments.predictions.session_tables.cycle_table`.
    title : str
        What is shown, for the title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        One row per joint (or segment, if there is no joint), one column per angle; right and left
        share a panel.
    """
    kinds = list(dict.fromkeys(map(kind_of, cycles["name"])))
    shown = [kind for kind in kinds if kind in _JOINTS] or kinds
    figure, axes = panels(len(shown), 3, sharex=True)
    for row, kind in enumerate(shown):
        for column, axis_name in enumerate(AXES):
            axis = axes[row, column]
            chosen = cycles[(cycles["name"].map(kind_of) == kind) & (cycles["axis"] == axis_name)]
            for name, one in chosen.groupby("name", sort=True):
                colour = _COLOURS[side_of(str(name)) or "right"]
                mean, spread = one["mean_deg"], one["sd_deg"]
                band = mean - spread, mean + spread
                axis.fill_between(one["percent"], *band, color=colour, alpha=0.2, lw=0)
                label = f"{side_of(str(name))}, {one['n_strides'].iloc[0]} strides"
                axis.plot(one["percent"], mean, color=colour, label=label)
            axis.axhline(0.0, color="0.6", lw=0.5)
            if row == 0:
                axis.set_title(ANGLE_NAMES[column])
            if row == len(shown) - 1:
                axis.set_xlabel("gait cycle (%)")
        axes[row, 0].set_ylabel(f"{kind} (degrees)")
        axes[row, 0].legend(loc="best")
    figure.suptitle(f"{title}: mean (line) and SD (band)")
    return figure
