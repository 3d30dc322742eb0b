"""The gait cycle of a session: a line and a band per side, named by their number of strides."""

import numpy as np
import pandas as pd

from narx.experiments.figures.cycles import cycle_figure
from narx.kinematics.segment_angles import AXES


def test_sides_share_a_panel_and_are_named_beside_their_strides():
    percent = np.arange(101)
    cycles = pd.concat(
        pd.DataFrame(
            {
                "name": f"knee_{side}", "axis": axis, "percent": percent,
                "mean_deg": 30.0 - 30.0 * np.cos(0.02 * np.pi * percent), "sd_deg": 2.0,
                "n_strides": n,
            }
        )
        for side, n in (("right", 43), ("left", 42))
        for axis in AXES
    )  # fmt: skip
    figure = cycle_figure(cycles, "walk")
    assert figure.get_suptitle() == "walk: mean (line) and SD (band)"
    assert len(figure.axes) == 3
    legend = figure.axes[0].get_legend()
    assert {text.get_text() for text in legend.get_texts()} == {
        "left, 42 strides", "right, 43 strides",
    }  # fmt: skip
    band = figure.axes[0].collections[0].get_paths()[0].vertices
    np.testing.assert_allclose(np.ptp(band[band[:, 0] == 50.0, 1]), 4.0)
