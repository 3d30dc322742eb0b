"""Distributions of peak errors, correlations and RMSE: Abhayasinghe et al. Fig. 8 and 9."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narx.experiments.figures.canvas import legend_below, panels, styled
from narx.experiments.method_labels import method_colour, method_label, method_order


def _histogram(panel: Axes, table: pd.DataFrame, column: str, methods: Sequence[str]) -> None:
    values = {m: table.loc[table["method"] == m, column].dropna().to_numpy() for m in methods}
    together = np.concatenate([*values.values(), np.empty(0)])
    together = together[np.isfinite(together)]
    if not len(together):
        panel.text(0.5, 0.5, "nothing found", transform=panel.transAxes, ha="center")
        return
    # outliers would compress all other values into one bar; they are counted in the outermost bars
    low, high = np.percentile(together, [0.5, 99.5])
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5
    bins = np.linspace(low, high, 41 if len(together) > 400 else 16).tolist()
    for method, array in values.items():
        panel.hist(
            np.clip(array, low, high),
            bins,
            histtype="stepfilled",
            color=method_colour(method),
            alpha=0.25,
        )
        panel.hist(
            np.clip(array, low, high),
            bins,
            histtype="step",
            color=method_colour(method),
            label=method_label(method),
            linewidth=1.3,
        )
    panel.set_ylabel("count")


@styled
def peak_histograms(peaks: pd.DataFrame, methods: Sequence[str] | None = None) -> Figure:
    """Draw the errors of positive and negative peaks (Fig. 8).

    Parameters
    ----------
    peaks : pandas.DataFrame
        From `narx.experiments.peak_errors.swing_results`.
    methods : sequence of str, optional
        Which; all by default.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels; a thin line marks zero.
    """
    methods = method_order(peaks["method"]) if methods is None else methods
    figure, grid = panels(1, 2, 3.1, 2.3, sharex=True)
    for panel, kind in zip(grid[0], ("positive", "negative"), strict=True):
        _histogram(panel, peaks[peaks["peak"] == kind], "error_deg", methods)
        panel.axvline(0.0, color="0.4", linewidth=0.8)
        panel.set_title(f"{kind} peaks")
        panel.set_xlabel("reference - estimate (°)")
    legend_below(figure, grid[0, 0])
    return figure


@styled
def trial_histograms(trials: pd.DataFrame, methods: Sequence[str] | None = None) -> Figure:
    """Draw the distributions of correlation and RMSE over trials (Fig. 9).

    Parameters
    ----------
    trials : pandas.DataFrame
        From `narx.experiments.peak_errors.swing_results`.
    methods : sequence of str, optional
        Which; all by default.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.
    """
    methods = method_order(trials["method"]) if methods is None else methods
    figure, grid = panels(1, 2, 3.1, 2.3)
    for panel, (column, name) in zip(
        grid[0], (("r", "correlation"), ("rmse_deg", "RMSE (°)")), strict=True
    ):
        _histogram(panel, trials, column, methods)
        panel.set_xlabel(name)
    legend_below(figure, grid[0, 0])
    return figure
