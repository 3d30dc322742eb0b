"""Mean and standard deviation over the gait cycle, estimate and reference."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from narx.evaluation.strides import StrideSet
from narx.experiments.figures.canvas import (
    ANGLE_NAMES,
    REFERENCE_COLOUR,
    legend_below,
    panels,
    styled,
)
from narx.experiments.method_labels import method_colour, method_label


@styled
def stride_bands(sets: Sequence[StrideSet], methods: Sequence[str], title: str = "") -> Figure:
    """Draw the bands of all strides, one row per method and one column per angle.

    Parameters
    ----------
    sets : sequence of StrideSet
        Of joints or segments of one kind.
    methods : sequence of str
        Rows from top to bottom.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        Line: mean over strides; band: one standard deviation to either side. Only strides with
        reference and estimate.
    """
    figure, axes = panels(len(methods), 3, sharex=True, sharey="col")
    percent = np.linspace(0.0, 100.0, 101)
    for row, method in enumerate(methods):
        for column in range(3):
            axis = axes[row, column]
            pairs = [
                (one.reference_deg[:, :, column], one.estimates_deg[method][:, :, column])
                for one in sets
                if method in one.estimates_deg
            ]
            reference, estimate = (np.concatenate(side) for side in zip(*pairs, strict=True))
            valid = np.isfinite(reference + estimate).all(axis=1)
            lines = (reference, REFERENCE_COLOUR), (estimate, method_colour(method))
            if valid.any():
                for strides, colour in lines:
                    mean, spread = strides[valid].mean(axis=0), strides[valid].std(axis=0)
                    band = mean - spread, mean + spread
                    axis.fill_between(percent, *band, color=colour, alpha=0.2, lw=0)
                    axis.plot(percent, mean, color=colour)
            else:
                middle = axis.get_xaxis_transform()
                axis.text(50.0, 0.5, "not observed", ha="center", transform=middle)
            if row == 0:
                axis.set_title(ANGLE_NAMES[column])
            if row == len(methods) - 1:
                axis.set_xlabel("gait cycle (%)")
        axes[row, 0].set_ylabel(f"{method_label(method)}\nangle (°)")
    # a legend in a panel would lie on its lines
    for colour, name in [
        (REFERENCE_COLOUR, "reference"),
        *((method_colour(method), method_label(method)) for method in methods),
    ]:
        axes[0, 0].plot([], [], color=colour, label=name)
    legend_below(figure, axes[0, 0])
    figure.suptitle(title)
    return figure
