"""Bland-Altman plots per plane and speed: Tham et al. Fig. 7."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narx.evaluation.agreement import (
    LimitsOfAgreement,
    limits_of_agreement,
    repeated_limits_of_agreement,
)
from narx.evaluation.comparison import Evaluated
from narx.experiments.figures.canvas import legend_below, panels, styled
from narx.experiments.method_labels import method_label
from narx.experiments.tables.subjects import condition_order
from narx.experiments.tables.table import shown
from narx.kinematics.segment_angles import AXES


def _limits(errors: np.ndarray, subjects: np.ndarray) -> LimitsOfAgreement:
    if len(np.unique(subjects)) > 1:
        return repeated_limits_of_agreement(errors, subjects)
    return limits_of_agreement(errors)


def _draw(
    panel: Axes, means: np.ndarray, errors: np.ndarray, subjects: np.ndarray
) -> tuple[float, float]:
    """Draw one panel; return the lowest and highest error to show."""
    panel.hexbin(
        means, errors, gridsize=(45, 30), bins="log", cmap="Greys", mincnt=1, linewidths=0.0,
        vmin=0.3,
    )  # fmt: skip
    limits = _limits(errors, subjects)
    for value, interval, colour, style, name in (
        (limits.bias, limits.bias_interval, "#0099a8", ":", "mean error"),
        (limits.upper, limits.upper_interval, "#c8102e", "--", "upper 95 % limit of agreement"),
        (limits.lower, limits.lower_interval, "#0060b0", "--", "lower 95 % limit of agreement"),
    ):
        panel.axhline(value, color=colour, linestyle=style, linewidth=1.3, label=name)
        if 2 < limits.n_subjects < limits.n_samples:
            label = "95 % intervals of these over subjects" if name == "mean error" else None
            panel.axhspan(*interval, color=colour, alpha=0.10, linewidth=0, label=label)
        panel.annotate(
            shown(value, 1),
            (1.0, value),
            xycoords=("axes fraction", "data"),
            xytext=(2, 0),
            textcoords="offset points",
            va="center",
            color=colour,
            fontsize=7,
            annotation_clip=False,
        )
    low, high = np.percentile(errors, [0.1, 99.9])
    return min(float(low), limits.lower), max(float(high), limits.upper)


@styled
def bland_altman(
    evaluated: Iterable[Evaluated], method: str = "narx", rate_hz: float = 20.0, title: str = ""
) -> Figure:
    """Draw error against mean angle, one row per plane and one column per condition.

    Parameters
    ----------
    evaluated : iterable of Evaluated
        The same joint or segment (both legs if present) of any subjects and conditions.
    method : str
        Method whose error is drawn.
    rate_hz : float
        Samples per second to draw; more would not change the plot visibly.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        Density of points on a logarithmic scale; bias dotted, limits of agreement dashed, both
        of repeated measures (`narx.evaluation.agreement.repeated_limits_of_agreement`) with their
        95 % intervals shaded for three subjects or more.
    """
    pieces = [e.decimated(rate_hz) for e in evaluated if method in e.estimates_rad]
    conditions = condition_order(piece.condition for piece in pieces)
    figure, grid = panels(
        len(AXES), max(len(conditions), 1), 2.35, 1.75, sharex="row", sharey="row"
    )
    for row, axis_name in enumerate(AXES):
        seen: list[tuple[float, float]] = []
        for column, condition in enumerate(conditions):
            here = [piece for piece in pieces if piece.condition == condition]
            errors = np.concatenate([piece.error_deg(method)[:, row] for piece in here])
            reference = np.concatenate([np.rad2deg(piece.reference_rad[:, row]) for piece in here])
            subjects = np.concatenate([[piece.subject] * len(piece.time_s) for piece in here])
            valid = np.isfinite(errors)
            panel = grid[row, column]
            if valid.sum() > 2:
                # error is reference minus estimate, so their mean is reference minus half the error
                means = reference - errors / 2.0
                seen.append(_draw(panel, means[valid], errors[valid], subjects[valid]))
            else:
                panel.text(0.5, 0.5, "not observed", transform=panel.transAxes, ha="center")
                panel.grid(visible=False)
                panel.tick_params(labelleft=False, labelbottom=False)
            if row == 0:
                panel.set_title(condition)
            if row == len(AXES) - 1:
                panel.set_xlabel("mean of reference and estimate (°)")
        if seen:
            # the intervals of few subjects may extend far beyond
            low, high = min(pair[0] for pair in seen), max(pair[1] for pair in seen)
            grid[row, 0].set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
        grid[row, 0].set_ylabel(f"{axis_name}\nreference - estimate (°)")
    drawn = [panel for panel in figure.axes if panel.get_legend_handles_labels()[0]]
    if drawn:
        legend_below(figure, drawn[0])
    figure.suptitle(title or f"Agreement of {method_label(method)} with the reference")
    return figure
