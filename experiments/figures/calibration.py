"""Calibration of the predicted standard deviation: observed against nominal coverage."""

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from narx.evaluation.comparison import Evaluated
from narx.evaluation.uncertainty import calibration, coverage_curve
from narx.experiments.figures.canvas import panels, styled
from narx.experiments.method_labels import method_colour, method_label, method_order
from narx.kinematics.segment_angles import AXES


@styled
def calibration_figure(
    evaluated: Iterable[Evaluated], rate_hz: float = 20.0, title: str = ""
) -> Figure:
    """Draw the coverage of central bands of every width, one panel per axis.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        Trials of one joint or segment; methods without a predicted standard deviation are left
        out.
    rate_hz : float
        Samples per second to use.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        The diagonal is perfect calibration; below it the prediction is overconfident. The 68 and 95
        % bands are marked, and the shares of errors that they hold given as numbers.
    """
    trials = [trial.decimated(rate_hz) for trial in evaluated]
    levels = np.linspace(0.01, 0.99, 99)
    figure, grid = panels(1, len(AXES), 2.4, 2.3, sharex=True, sharey=True)
    for axis, name in enumerate(AXES):
        panel = grid[0, axis]
        panel.plot([0, 1], [0, 1], color="0.5", linestyle="--", linewidth=0.8)
        for method in method_order(m for trial in trials for m in trial.std_rad):
            mine = [trial for trial in trials if method in trial.std_rad]
            error = np.concatenate([np.deg2rad(t.error_deg(method)[:, axis]) for t in mine])
            std = np.concatenate([t.std_rad[method][:, axis] for t in mine])
            found = calibration(error, std)
            colour = method_colour(method)
            panel.plot(
                levels,
                coverage_curve(error, std, levels),
                color=colour,
                label=f"{method_label(method)}\n68 % band: {100 * found.coverage_68:.0f} %, "
                f"95 % band: {100 * found.coverage_95:.0f} %",
            )
            panel.plot(
                [0.68, 0.95], [found.coverage_68, found.coverage_95], "o", color=colour, ms=4
            )
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.3), frameon=False, fontsize=7)
        panel.set(title=name, xlabel="predicted share in a band", xlim=(0, 1), ylim=(0, 1))
        panel.set_aspect("equal")
    grid[0, 0].set_ylabel("observed share of errors in it")
    if title:
        figure.suptitle(title)
    return figure
