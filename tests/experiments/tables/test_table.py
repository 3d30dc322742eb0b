import io

import numpy as np
import pandas as pd
import pytest

from narx.experiments.tables.table import Table, as_markdown, shown


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.25, "1.2"), (-0.04, "0.0"), (np.nan, "–"), (None, "–"), (pd.NA, "–"), (7, "7"),
        (np.int64(7), "7"), ("CF", "CF"), (True, "yes"), (np.bool_(False), "no"),
        (np.inf, "inf"), (np.float64(3.0), "3.0"),
    ],
)  # fmt: skip
def test_cells(value, text):
    assert shown(value, 1) == text


def table():
    frame = pd.DataFrame(
        {
            "Speed": ["Slow", "Slow", "Fast", "Fast"],
            "Method": ["CF", "NARX", "NARX", "CF"],
            "RMSE": [1.234, np.nan, 2.0, -0.0],
            "text": ["a|b", "", "x", "y"],
        }
    )
    return Table("A title", frame.set_index(["Speed", "Method"]), {"RMSE": 2}, "A note.")


def test_markdown():
    assert table().to_markdown() == (
        "**A title**\n"
        "\n"
        "| Speed | Method | RMSE | text |\n"
        "| ----- | ------ | ---: | ---- |\n"
        "| Slow  | CF     | 1.23 | a\\|b |\n"
        "|       | NARX   |    – |      |\n"
        "| Fast  | NARX   | 2.00 | x    |\n"
        "|       | CF     | 0.00 | y    |\n"
        "\n"
        "A note.\n"
    )
    assert as_markdown([table(), table()]).count("A title") == 2


def test_a_repeated_level_shows_again_when_the_level_before_changes():
    frame = pd.DataFrame({"a": ["x", "y"], "b": ["same", "same"], "c": ["1", "2"], "d": [0.0, 1.0]})
    cells = Table("", frame.set_index(["a", "b", "c"])).cells()
    assert cells["b"].tolist() == ["same", "same"]


def test_csv_keeps_every_digit():
    frame = Table("", pd.DataFrame({"x": [1 / 3, np.nan]})).frame
    again = pd.read_csv(io.StringIO(table().to_csv()))
    assert again["RMSE"].tolist()[0] == 1.234
    assert len(again) == 4
    assert frame["x"].iloc[0] == 1 / 3


def test_latex():
    text = table().to_latex()
    assert "\\caption{A title}" in text
    assert "Slow & CF & 1.23 & a|b" in text
