"""The contract of a source, on one that holds nothing but names."""

import numpy as np
import pandas as pd
import pytest

from narx.datasets.base import TrialSource
from narx.errors import UserError
from narx.recording import ImuRecording, Trial


class Names(TrialSource):
    name = "names"

    def __init__(self) -> None:
        self.loaded: list[str] = []

    def _list_trials(self) -> pd.DataFrame:
        rows = [(s, c, "1") for s in ("a", "b") for c in ("slow", "fast")]
        return pd.DataFrame([*rows, ("b", "fast", "2")], columns=["subject", "condition", "trial"])

    def load(self, subject: str, condition: str, trial: str) -> Trial:
        self.loaded.append(f"{subject}/{condition}/{trial}")
        imu = ImuRecording("thigh", np.arange(2.0), np.zeros((2, 3)), np.zeros((2, 3)))
        return Trial(self.name, subject, condition, trial, 1.0, {"thigh": imu})


def test_iterates_in_the_order_of_the_index_one_at_a_time():
    source = Names()
    assert len(source) == 5
    first = next(iter(source))
    assert first.name == "names/a/slow/1"
    assert source.loaded == ["a/slow/1"]


@pytest.mark.parametrize(
    ("wanted", "left"),
    [
        ({"subject": "b"}, ["b/slow/1", "b/fast/1", "b/fast/2"]),
        ({"condition": ["slow"], "subject": ["a", "b"]}, ["a/slow/1", "b/slow/1"]),
        ({"trial": 2}, ["b/fast/2"]),
        ({}, ["a/slow/1", "a/fast/1", "b/slow/1", "b/fast/1", "b/fast/2"]),
    ],
)
def test_select_keeps_what_is_named(wanted, left):
    source = Names()
    chosen = source.select(**wanted)
    assert [t.name.removeprefix("names/") for t in chosen] == left
    assert len(source) == 5


def test_select_refuses_names_that_are_not_there():
    with pytest.raises(UserError, match="no subject 'c' .there is a, b"):
        Names().select(subject="c")
    with pytest.raises(UserError, match="no trial '2'"):
        Names().select(condition="slow", trial="2")


def test_the_index_handed_out_is_a_copy():
    source = Names()
    source.index().drop(index=0, inplace=True)
    assert len(source) == 5
