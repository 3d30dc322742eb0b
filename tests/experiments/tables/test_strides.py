"""The tables of strides match the strides."""

import numpy as np
import pytest

from narx.evaluation.strides import cut_strides, stride_table
from narx.experiments.figures.strides import stride_bands
from narx.experiments.tables.strides import cycle_table, reliability_table, stride_errors_table


@pytest.fixture
def sets(make_study):
    knees = [one for one in make_study() if one.segment.startswith("knee")]
    # contacts two strides before the end of each walk, at the walk's own stride frequency
    frequency = {"slow": 0.7, "normal": 0.9, "fast": 1.1}
    return [cut_strides(one, np.arange(2.0, 19.0, 1.0 / frequency[one.condition])) for one in knees]


def test_errors_per_stride(sets):
    frame = stride_errors_table(stride_table(sets), "Knee").frame
    assert set(frame.index.get_level_values("Axis")) == {"sagittal", "frontal", "transverse"}
    assert ("transverse", "CF") not in frame.index
    narx = frame.loc[("sagittal", "NARX")]
    # noise of 1.4 degrees over 101 points widens the range by some 5 degrees
    assert -10.0 < narx["its error"] < -2.0
    share = 100 * narx["its error"] / narx["range of motion"]
    assert narx["error in %"] == pytest.approx(share, rel=0.01)


def test_reliability_and_cycle(sets):
    frame = reliability_table(stride_table(sets), "Knee").frame
    assert (frame["walks"] == 18).all()
    table = cycle_table(sets, ["narx", "complementary_filter"], "Knee").frame
    assert (table["subjects"] == 3).all()
    assert table["differs over, % of the cycle"].between(0, 100).all()


def test_bands(sets):
    figure = stride_bands(sets, ["narx", "complementary_filter"], "Knee")
    assert len(figure.axes) == 6
    assert [t.get_text() for t in figure.axes[5].texts] == ["not observed"]
    lines = figure.axes[0].get_lines()
    np.testing.assert_allclose(lines[0].get_ydata(), lines[1].get_ydata(), atol=1.0)
