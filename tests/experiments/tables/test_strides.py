"""The tables of strides match the strides."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from narx.evaluation.reliability import reliability
from narx.evaluation.strides import cut_strides, mean_waveforms, stride_table
from narx.evaluation.waveform_test import waveform_test
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


def strides_of(subject, numbers):
    """Strides of a person: range, maximum and minimum of reference and estimate, and the RMSE."""
    columns = [
        "range_reference", "range_estimate", "maximum_reference", "maximum_estimate",
        "minimum_reference", "minimum_estimate", "rmse",
    ]  # fmt: skip
    names = {
        "dataset": "d", "subject": subject, "condition": "normal", "trial": "1",
        "segment": "knee_right", "axis": "sagittal", "method": "narx",
    }  # fmt: skip
    return pd.DataFrame(numbers, columns=columns, dtype=float).assign(**names)


def test_errors_by_hand():
    """Means of the people's means, and of their standard deviations."""
    one = strides_of("A", [[60, 58, 61, 60, 1, 2, 1], [60, 54, 61, 58, 1, 4, 3]])
    other = strides_of("B", [[40, 41, 42, 42, 2, 1, 2]] * 3 + [[40, 45, 42, 44, 2, -1, 6]])
    frame = stride_errors_table(pd.concat([one, other], ignore_index=True), "Knee").frame
    row = frame.loc[("sagittal", "NARX")]
    assert row["strides"] == 6
    # errors of the range: 2 and 6, and three times -1 and -5
    assert row["range of motion"] == pytest.approx((60 + 40) / 2)
    assert row["its error"] == pytest.approx((4 - 2) / 2)
    assert row["its SD"] == pytest.approx((np.sqrt(8) + 2) / 2)
    assert row["error in %"] == pytest.approx(100 * 1 / 50)
    # 1 and 3, and three times 0 and -2
    assert row["highest angle, error"] == pytest.approx((2 - 0.5) / 2)
    assert row["SD (highest)"] == pytest.approx((np.sqrt(2) + 1) / 2)
    # -1 and -3, and three times 1 and 3
    assert row["lowest angle, error"] == pytest.approx((-2 + 1.5) / 2)
    assert row["SD (lowest)"] == pytest.approx((np.sqrt(2) + 1) / 2)
    assert row["RMSE in % of range"] == pytest.approx(100 * (2 + 3) / 2 / 50)


def test_reliability_is_of_the_means_of_walks():
    rng = np.random.default_rng(0)
    ranges = rng.normal(60.0, 6.0, 8)
    means = ranges + 6.0 + rng.normal(0.0, 1.5, 8)
    # one to eight strides of a walk, about its mean
    walks = [
        strides_of(str(k), [[a + d, b - d, 0, 0, 0, 0, 0] for d in np.linspace(-3.0, 3.0, k + 1)])
        if k
        else strides_of("0", [[a, b, 0, 0, 0, 0, 0]])
        for k, (a, b) in enumerate(zip(ranges, means, strict=True))
    ]
    frame = reliability_table(pd.concat(walks, ignore_index=True), "Knee").frame
    row, found = frame.loc[("sagittal", "NARX")], reliability(ranges, means)
    assert row["walks"] == 8
    expected = [found.icc_2_1, found.icc_3_1, found.sem, found.mdc]
    assert row[["ICC(2,1)", "ICC(3,1)", "SEM", "MDC"]].tolist() == pytest.approx(expected)
    assert found.icc_3_1 > found.icc_2_1 + 0.01
    for name, bounds in (("2,1", found.icc_2_1_interval), ("3,1", found.icc_3_1_interval)):
        assert row[f"95 % interval of ICC({name})"] == "{:.2f} to {:.2f}".format(*bounds)


def test_where_the_waveforms_differ(sets):
    """Parts of the cycle of which one is more certain than another."""
    percent, rng, people = np.arange(101.0), np.random.default_rng(0), []
    for k in range(5):
        size = [8.0 + 0.5 * rng.normal(), 3.0 + 1.5 * rng.normal()]
        wave = size @ np.exp(-(((percent - [[30.0], [70.0]]) / 7.0) ** 2))
        wave += 0.5 * np.sin(2 * np.pi * percent * (1 + k % 3) / 50.0 + 6.0 * rng.random())
        estimate = sets[0].reference_deg - wave[:, None]
        people.append(replace(sets[0], subject=str(k), estimates_deg={"narx": estimate}))
    row = cycle_table(people, ["narx"], "Knee").frame.loc[("sagittal", "NARX")]
    found = waveform_test(*mean_waveforms(people, "narx", 0))
    assert len({p for *_, p in found.clusters}) > 1
    assert row["subjects"] == 5
    assert row["smallest p"] == min(p for *_, p in found.clusters)
    assert row["differs over, % of the cycle"] == found.share_percent
    assert row["largest mean difference"] == found.largest_difference_deg


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
