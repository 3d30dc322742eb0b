"""The swing angle of one trial from minimum to minimum: Abhayasinghe et al. Fig. 7."""

import numpy as np
from matplotlib.figure import Figure

from narx.evaluation.agreement import agreement
from narx.experiments.figures.canvas import REFERENCE_COLOUR, legend_below, panels, styled
from narx.experiments.method_labels import method_colour, method_label
from narx.experiments.peak_errors import Swing, peak_errors


@styled
def swing_figure(angles: Swing, method: str = "giof", longest_s: float = 15.0) -> Figure:
    """Draw reference, estimate and their peaks, with correlation and RMSE of the whole trial.

    Parameters
    ----------
    angles : Swing
        From `narx.experiments.peak_errors.swing`.
    method : str
        Method of the estimate.
    longest_s : float
        Longest part drawn, from the start.

    Returns
    -------
    matplotlib.figure.Figure
        One panel.
    """
    result = agreement(np.deg2rad(angles.reference_deg), np.deg2rad(angles.estimate_deg))
    figure, grid = panels(1, 1, 6.0, 2.4)
    panel = grid[0, 0]
    shown = angles.time_s <= angles.time_s[0] + longest_s
    panel.plot(
        angles.time_s[shown],
        angles.estimate_deg[shown],
        color=method_colour(method),
        label=method_label(method),
    )
    panel.plot(
        angles.time_s[shown],
        angles.reference_deg[shown],
        color=REFERENCE_COLOUR,
        linestyle=(0, (4, 2)),
        label="reference",
    )
    peaks = peak_errors(angles)
    peaks = peaks[peaks["time_s"] <= angles.time_s[0] + longest_s]
    panel.plot(
        peaks["time_s"] + peaks["lag_s"],
        peaks["estimate_deg"],
        "o",
        color=method_colour(method),
        markersize=3.5,
    )
    panel.plot(
        peaks["time_s"], peaks["reference_deg"], "o", color="k", markersize=3, fillstyle="none"
    )
    panel.margins(x=0.01)
    panel.set(xlabel="time (s)", ylabel="thigh angle (°), forward +")
    panel.set_title(f"r = {result.r:.4f}, RMSE = {result.rmse_deg:.2f}° over the whole trial")
    legend_below(figure, panel)
    return figure
