"""Angles with their reference: Tham et al. Fig. 6, Abhayasinghe et al. Fig. 10, Han Fig. 6, 7."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from narx.evaluation.comparison import Evaluated
from narx.experiments.figures.canvas import (
    ANGLE_NAMES,
    REFERENCE_COLOUR,
    legend_below,
    panels,
    styled,
)
from narx.experiments.method_labels import drawn_rows, line_styles, method_colour, method_label
from narx.kinematics.segment_angles import AXES

LINE_RATE_HZ = 100.0


def first_and_last_minute(
    evaluated: Evaluated, window_s: float = 10.0
) -> list[tuple[str, Evaluated]]:
    """Cut a window out of the first scored minute and one out of the last.

    Parameters
    ----------
    evaluated : Evaluated
        A trial of two minutes or more; a shorter one gives its first and last window.
    window_s : float
        Length of each, s.

    Returns
    -------
    list of (str, Evaluated)
        Titles and pieces, as `waveforms` takes them. The windows are not chosen at random: they
        begin 20 s into the first scored minute and end 20 s before the end.
    """
    scored = evaluated.time_s[evaluated.scored]
    if not len(scored):
        scored = evaluated.time_s
    start, end = float(scored[0]), float(scored[-1])
    margin = 20.0 if end - start >= 120.0 else 0.0
    first = start + margin
    last = max(first, end - margin - window_s)
    return [
        (f"minute {int(begin // 60) + 1}", evaluated.between(begin, begin + window_s))
        for begin in (first, last)
    ]


@styled
def waveforms(
    columns: Sequence[tuple[str, Evaluated]],
    methods: Sequence[str] | None = None,
    axes: Sequence[int] = (0, 1, 2),
    marks_s: Sequence[float] = (),
    title: str = "",
) -> Figure:
    """Draw estimates beside the reference, one column per piece and one row per axis.

    Parameters
    ----------
    columns : sequence of (str, Evaluated)
        Title and angles: two windows of one knee, or thigh and shank of one walk.
    methods : sequence of str, optional
        Rows of the benchmark to draw; by default those of `drawn_rows`.
    axes : sequence of int
        Rows, indices into `narx.kinematics.segment_angles.AXES`.
    marks_s : sequence of float
        Times of vertical lines, such as start and stop of walking.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        Reference dashed in black, methods in their colours, shaded by two standard deviations to
        either side where they predict any; NaN is not drawn.
    """
    if methods is None:
        methods = drawn_rows(m for _, piece in columns for m in piece.estimates_rad)
    styles = line_styles(methods)
    # a noisy dashed line at 500 Hz would look solid
    columns = [(name, piece.decimated(LINE_RATE_HZ)) for name, piece in columns]
    width = max(2.6, 6.4 / len(columns)) if len(columns) < 3 else 2.6
    figure, grid = panels(len(axes), len(columns), width, 1.55, sharex="col", sharey="row")
    for row, axis in enumerate(axes):
        for column, (name, piece) in enumerate(columns):
            panel = grid[row, column]
            for method in methods:
                if method not in piece.estimates_rad:
                    continue
                if method in piece.std_rad:
                    middle, std = piece.estimates_rad[method], piece.std_rad[method]
                    band = np.rad2deg(
                        [(middle - 2.0 * std)[:, axis], (middle + 2.0 * std)[:, axis]]
                    )
                    panel.fill_between(
                        piece.time_s,
                        *band,
                        color=method_colour(method),
                        alpha=0.2,
                        lw=0,
                        label=f"{method_label(method)}, ± 2 predicted SD",
                    )
                panel.plot(
                    piece.time_s,
                    _without_wraps(np.rad2deg(piece.estimates_rad[method][:, axis])),
                    color=method_colour(method),
                    label=method_label(method),
                    linestyle=styles[method],
                    alpha=0.9,
                )
            panel.plot(
                piece.time_s,
                np.rad2deg(piece.reference_rad[:, axis]),
                color=REFERENCE_COLOUR,
                linestyle=(0, (4, 2)),
                linewidth=1.0,
                label="reference",
            )
            for mark in marks_s:
                panel.axvline(mark, color="0.5", linewidth=0.8, linestyle=":")
            panel.margins(x=0)
            if row == 0:
                panel.set_title(name)
            if row == len(axes) - 1:
                panel.set_xlabel("time (s)")
        grid[row, 0].set_ylabel(f"{AXES[axis]} (°)\n{ANGLE_NAMES[axis]}", fontsize=7)
        _keep_to_reference(grid[row], [piece for _, piece in columns], axis, methods)
    legend_below(figure, grid[0, 0])
    if title:
        figure.suptitle(title)
    return figure


def _without_wraps(angle_deg: np.ndarray) -> np.ndarray:
    """Interrupt a line where an angle wraps from 180 to -180 degrees, instead of drawing a jump."""
    broken = angle_deg.copy()
    broken[1:][np.abs(np.diff(angle_deg)) > 180.0] = np.nan
    return broken


def _keep_to_reference(
    row: np.ndarray, pieces: Sequence[Evaluated], axis: int, methods: Sequence[str]
) -> None:
    """Limit the height of a row so that a diverging method does not flatten the others."""
    reference = np.rad2deg(np.concatenate([piece.reference_rad[:, axis] for piece in pieces]))
    if not np.isfinite(reference).any():
        return
    low, high = float(np.nanmin(reference)), float(np.nanmax(reference))
    room = 0.75 * max(high - low, 10.0)
    drawn = row[0].get_ylim()
    row[0].set_ylim(max(drawn[0], low - room), min(drawn[1], high + room))
    for panel, piece in zip(row, pieces, strict=True):
        outside = []
        for method in methods:
            estimate = piece.estimates_rad.get(method)
            if estimate is None or not np.isfinite(estimate[:, axis]).any():
                continue
            middle = float(np.rad2deg(np.nanmedian(estimate[:, axis])))
            if not low - room <= middle <= high + room:
                outside.append(f"{method_label(method)} at {middle:.0f}°")
        if outside:
            text = panel.text(
                0.99, 0.96, "outside: " + "\n".join(outside), transform=panel.transAxes,
                ha="right", va="top", fontsize=6.5, color="0.3",
                bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1},
            )  # fmt: skip
            # a note must not change the width of its panel
            text.set_in_layout(False)
